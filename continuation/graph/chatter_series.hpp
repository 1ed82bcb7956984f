// SPDX-License-Identifier: GPL-3.0-or-later
// A series of families towards complete chatter: each family gains one impact at the grazing on which the previous one ends,
// and keeps the period. The distances of the grazings shrink by a constant ratio (near the coefficient of restitution for
// Newton's law). They accumulate where the chatter becomes complete; there the family of sticking orbits begins.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

namespace graze {

struct SeriesLimit {
  double ratio = 0.0;  ///< of successive distances between neighbouring grazings
  double value = 0.0;  ///< accumulation point in the continuation parameter, by geometric extrapolation
};

/// Number of grazings needed to recognise a series: three ratios.
inline constexpr std::size_t grazings_of_series = 5;

/// The accumulation point from the last grazings of a series, latest first; empty unless their distances shrink geometrically.
/// If the distances shrink by a power law (as at low frequencies, without a limit within reach), a ratio q grows by (1 - q)^2 /
/// 2 or less per grazing: the ratio must be much steadier than that.
inline std::optional<SeriesLimit> limit_of_series(const std::array<double, grazings_of_series>& values) {
  constexpr double steady = 0.25;
  const auto ratio = [&](std::size_t k) { return (values[k] - values[k + 1]) / (values[k + 1] - values[k + 2]); };
  const double q = ratio(0);
  if (!(q > 0.0 && q < 1.0)) return std::nullopt;
  for (const std::size_t k : {1, 2})
    if (!(std::abs(ratio(k) - ratio(k - 1)) < steady * (1.0 - q) * (1.0 - q))) return std::nullopt;
  return SeriesLimit{q, values[0] + (values[0] - values[1]) * q / (1.0 - q)};
}

}  // namespace graze
