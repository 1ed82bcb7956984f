// SPDX-License-Identifier: GPL-3.0-or-later
// Random cases: an admissible orbit with one impact in n = 1 ... 4 forcing periods, in closed form, and the parameter and range in
// which its family is to be followed. Case k of a seed is made from (seed, k) alone, with a generator that gives the same numbers
// everywhere.
#pragma once

#include "family.hpp"

#include <cstdint>

namespace graze::reference {

struct Case {
  Frame frame;
  Values<double> start;  ///< the event's coordinates, the parameter last
  double to = 0.0;
  Range range() const { return {std::min(start.back(), to), std::max(start.back(), to)}; }
  int direction() const { return to > start.back() ? 1 : -1; }
};

/// The parameter that changes is drawn too, where none is given.
Case random_case(std::uint64_t seed, std::uint64_t index, std::optional<std::size_t> name = std::nullopt);

/// Arguments of the program, all digits, after the problem's file: `continue` from the case's orbit.
std::string arguments(const Case& one);

}  // namespace graze::reference
