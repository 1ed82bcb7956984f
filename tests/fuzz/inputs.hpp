// SPDX-License-Identifier: GPL-3.0-or-later
// What the program reads from outside: one kind for each door, with sound examples.
#pragma once

#include "mutation.hpp"

#include <functional>
#include <string>
#include <vector>

namespace graze::fuzz {

struct Kind {
  std::string name;
  Form form = Form::text;
  std::size_t cost = 1;  ///< of so many inputs of other kinds there is one of this
  std::vector<std::string> words;
  std::function<std::vector<std::string>()> seeds;
  /// Ends, or throws std::invalid_argument with one sentence. Anything else is a fault of the program.
  std::function<void(const std::string& input)> take;
  /// Makes an input pass checks that hardly any damaged one passes, such as a checksum; may be empty.
  std::function<void(std::string& input, Dice& dice)> mend = {};
};

std::vector<Kind> kinds();

}  // namespace graze::fuzz
