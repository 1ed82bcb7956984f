// SPDX-License-Identifier: GPL-3.0-or-later
// Length of the steps of a Hertz contact's Taylor series (hertz_series.hpp).
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

/// The terms of a step fall off as powers of tolerance^(1/order): if the last one is a quarter of the tolerance, the truncation
/// error is a twentieth of it. The rest is for the tangent, whose error grows as that of the state over the speed of entry.
inline constexpr double hertz_last_term = 0.25;

/// Longest step, over sqrt(2/|a|): 0.3 of the shortest possible contact, half a turn about the equilibrium (0, 0),
/// pi sqrt(2/|a|) in s.
inline constexpr double hertz_longest_step = 0.3 * std::numbers::pi;

/// (x/y)^(1/order) to 4%, enough for the length of a step. A double read as a whole number is its logarithm to base 2 within
/// 0.09, in units of 2^-52.
[[gnu::always_inline]] inline double rough_root(double x, double y, std::size_t order = hertz_order) {
  constexpr auto one = std::bit_cast<std::int64_t>(1.0);
  const std::int64_t ratio = std::bit_cast<std::int64_t>(x) - std::bit_cast<std::int64_t>(y);
  return 0.97 * std::bit_cast<double>(one + ratio / static_cast<std::int64_t>(order));
}

}  // namespace graze::detail
