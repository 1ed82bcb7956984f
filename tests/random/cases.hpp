// SPDX-License-Identifier: GPL-3.0-or-later
// Random cases: an admissible orbit, with the parameter and range in which its family is followed. Of ten cases, five are
// orbits with one impact in n = 1 ... 4 forcing periods at random parameters, in closed form. Three are such orbits near a
// fold, a doubling and a grazing. Two are attractors with up to six impacts in up to four periods, on which the motion from
// rest has settled. With other models than the barrier, half are attractors, and half have one impact in n forcing periods
// (between equal stops also in one half of n = 1 or 3). Case k of a seed depends on (seed, k) alone, with a generator that
// gives the same numbers on every machine.
#pragma once

#include "family.hpp"

#include <cstdint>

namespace graze::reference {

struct Case {
  Frame frame;
  Values<double> start;  ///< coordinates of the events, the parameter last
  double to = 0.0;
  Range range() const { return {std::min(start.back(), to), std::max(start.back(), to)}; }
  int direction() const { return to > start.back() ? 1 : -1; }
};

/// The continuation parameter is drawn too if none is given.
Case random_case(std::uint64_t seed, std::uint64_t index, std::optional<std::size_t> name = std::nullopt,
                 Model model = Model::barrier);

/// Arguments of the program, with all digits, after the problem file: `continue` from the orbit of the case.
std::string arguments(const Case& one);

/// A range of a parameter in which every orbit is requested.
struct SkeletonCase {
  Frame frame;  ///< its periods and impacts do not matter
  Range range;
  int most_periods = 3;
};

/// At least one family with one impact lies in its range.
SkeletonCase random_skeleton(std::uint64_t seed, std::uint64_t index, std::optional<std::size_t> name = std::nullopt);

/// Arguments of the program, after the problem file: `diagram --skeleton`.
std::string arguments(const SkeletonCase& one);

/// All families with one impact in 1 ... most_periods periods that meet one of many values in the range. Each is followed in
/// both directions from there, as one family from end to end.
std::vector<Family> one_impact_families(const Frame& frame, const Range& range, int most_periods);

}  // namespace graze::reference
