// SPDX-License-Identifier: GPL-3.0-or-later
// Run identity: whether two results belong to the same run, so that one can continue the other. If they do not: the first
// difference.
#pragma once

#include <graze/apps/text/json.hpp>

#include <optional>
#include <string>

namespace graze::apps {

/// The given parts of a result's head, on which its numbers depend. The path of the problem's file and the settings of --set
/// are left out: the parameters already contain them.
Json identity_of(const Json& head, const std::vector<std::string>& parts);

/// The parts of a result's head on which its numbers depend; maps have a list of their own.
inline const std::vector<std::string> run_identity_parts = {"model", "parameters", "systems", "options"};

/// The first difference: "parameters.b is 0.05 there and 0.06 now"; nullopt: none.
std::optional<std::string> difference(const Json& there, const Json& now);
/// The first difference in the essence of two heads.
std::optional<std::string> difference(const Json& there, const Json& now, const std::vector<std::string>& parts);

}  // namespace graze::apps
