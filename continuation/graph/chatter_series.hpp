// SPDX-License-Identifier: GPL-3.0-or-later
// A series of families towards complete chatter: each gains one impact at the grazing on which it ends, and is of the same period
// as the last. The grazings come closer to each other in a constant ratio (for Newton's law it is near the coefficient of
// restitution), and accumulate where the chatter becomes complete: there the family of orbits that stick begins.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

namespace graze {

struct SeriesLimit {
  double ratio = 0.0;  ///< of a distance between neighbouring grazings to the one before
  double value = 0.0;  ///< of the continuation parameter, by geometric extrapolation
};

/// Grazings that a series must have before it is known as one: three ratios.
inline constexpr std::size_t grazings_of_series = 5;

/// From the last grazings of a series, the latest first; empty unless their distances shrink geometrically. Where grazings come
/// closer by a power law (as at low frequencies, without a limit in reach), a ratio q grows by (1 - q)^2 / 2 and less: it
/// must be steadier than that by far.
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
