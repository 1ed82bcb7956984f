// SPDX-License-Identifier: GPL-3.0-or-later
// How far a Taylor series of a Hertz contact (hertz_series.hpp) is trusted.
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

namespace graze::detail {

/// Order of the series. Cost per step ~ order^2 and length of a step ~ tolerance^(1/order): -ln(tolerance)/2 is best, 15 at
/// 1e-13.
inline constexpr std::size_t hertz_order = 16;

/// The terms fall off over a step as powers of tolerance^(1/order), so that a last one of a quarter of the tolerance leaves out a
/// twentieth of it. The rest is for the tangent, whose error grows as that of the state over the speed of entry.
inline constexpr double hertz_last_term = 0.25;

/// Of half a turn about the equilibrium (0, 0), pi sqrt(2/|a|) in s, the shortest possible contact: a step goes so far at most.
inline constexpr double hertz_longest_step = 0.3 * std::numbers::pi;

/// (x/y)^(1/order) to 4%, which is all that the length of a step needs: read as a whole number, a double is its logarithm to base
/// 2 up to 0.09, with 2^52 for the unit.
[[gnu::always_inline]] inline double rough_root(double x, double y, std::size_t order = hertz_order) {
  constexpr auto one = std::bit_cast<std::int64_t>(1.0);
  const std::int64_t ratio = std::bit_cast<std::int64_t>(x) - std::bit_cast<std::int64_t>(y);
  return 0.97 * std::bit_cast<double>(one + ratio / static_cast<std::int64_t>(order));
}

}  // namespace graze::detail
