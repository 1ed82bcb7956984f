// SPDX-License-Identifier: GPL-3.0-or-later
// Files that come with the program: published figures and models written as text.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace graze::apps {

/// A file or folder of data/, installed beside the program or in the source tree. Empty: neither exists.
std::filesystem::path shipped(const std::string& name);

/// Names of the models in data/models, sorted.
std::vector<std::string> shipped_models();

/// The text of a shipped model. @throws std::invalid_argument with the nearest name.
std::string shipped_model(const std::string& name);

}  // namespace graze::apps
