// SPDX-License-Identifier: GPL-3.0-or-later
// Random cases: an admissible orbit, and the parameter and range in which its family is to be followed. Of ten, five are orbits
// with one impact in n = 1 ... 4 forcing periods at random parameters, in closed form, three are such orbits next to a fold, a
// doubling and a grazing, and two are attractors with up to six impacts in up to four periods, on which the motion from rest has
// settled. Of other models than the barrier, half are attractors, and half have one impact in n forcing periods (between equal
// stops, in one half of n = 1 or 3). Case k of a seed is made from (seed, k) alone, with a generator that gives the same numbers
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
Case random_case(std::uint64_t seed, std::uint64_t index, std::optional<std::size_t> name = std::nullopt,
                 Model model = Model::barrier);

/// Arguments of the program, all digits, after the problem's file: `continue` from the case's orbit.
std::string arguments(const Case& one);

/// A range of a parameter, of which every orbit is wanted.
struct SkeletonCase {
  Frame frame;  ///< its periods and impacts do not matter
  Range range;
  int most_periods = 3;
};

/// At least one family with one impact is in its range.
SkeletonCase random_skeleton(std::uint64_t seed, std::uint64_t index, std::optional<std::size_t> name = std::nullopt);

/// Arguments of the program, after the problem's file: `diagram --skeleton`.
std::string arguments(const SkeletonCase& one);

/// All families with one impact in 1 ... most_periods periods that meet one of many values in the range: followed both ways from
/// there, each as one family from end to end.
std::vector<Family> one_impact_families(const Frame& frame, const Range& range, int most_periods);

}  // namespace graze::reference
