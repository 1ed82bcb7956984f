// SPDX-License-Identifier: GPL-3.0-or-later
// Layers of maps, and the comparison of points.
#pragma once

#include <graze/floquet/follow/parameter_map.hpp>

#include <bit>
#include <cstdint>

namespace graze::support {

inline MapLayer from_rest(MapDirection follow = MapDirection::none) {
  return {[](const Vector&) { return Vector{{0.0, 0.0}}; }, follow};
}

/// Equal to the last bit, NaN included.
inline bool same(double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }

inline bool same(const MapPoint& a, const MapPoint& b) {
  return a.type == b.type && a.period == b.period && a.impacts == b.impacts && same(a.lambda_1, b.lambda_1) &&
         same(a.standard_error, b.standard_error) && same(a.state[0], b.state[0]) && same(a.state[1], b.state[1]);
}

}  // namespace graze::support
