// SPDX-License-Identifier: GPL-3.0-or-later
// External inputs of the program: one kind for each entry point, with valid examples.
#pragma once

#include "mutation.hpp"

#include <functional>
#include <string>
#include <vector>

namespace graze::fuzz {

struct Kind {
  std::string name;
  Form form = Form::text;
  std::size_t cost = 1;  ///< relative cost: one input of this kind per `cost` inputs of other kinds
  std::vector<std::string> words;
  std::function<std::vector<std::string>()> seeds;
  /// Returns, or throws std::invalid_argument with one sentence. Any other outcome is a fault of the program.
  std::function<void(const std::string& input)> take;
  /// Repairs checks that almost no damaged input passes, such as a checksum; may be empty.
  std::function<void(std::string& input, Dice& dice)> mend = {};
};

std::vector<Kind> kinds();

}  // namespace graze::fuzz
