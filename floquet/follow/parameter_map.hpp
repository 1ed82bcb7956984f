// SPDX-License-Identifier: GPL-3.0-or-later
// ParameterMap: the attractor at every point of a grid over two parameters: its type, its z = p/n and its first exponent.
//
// The grid has columns (values of the first parameter) and rows (values of the second). A layer is the whole grid computed from
// one start. Either every point starts from it, or the rows are followed: the first point of a row starts from it, each further
// one from the end state of its neighbour in the given direction, on its orbit or, without an orbit, at the end of its
// transient (as in a sweep, with its hysteresis). Rows are independent of each other: any part of the map can be computed
// anywhere, in any order, with bitwise the same result.
//
// A followed row of more than 512 points is divided into stretches that are computed at the same time (row.hpp): the attractor at
// the end of each decides whether the next begins on it, or from it.
//
// Newton's method proves periodic points, mostly after a few dozen forcing periods, and their exponents follow from the
// multipliers; only the other points need a full transient and a time average.
#pragma once

#include <graze/floquet/attractor/attractor.hpp>

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace graze {

/// `count` equally spaced values of a parameter, from `from` to `to`, both included.
struct ParameterAxis {
  std::string parameter;
  double from = 0.0, to = 0.0;
  int count = 1;
  double at(int i) const;
};

struct ParameterGrid {
  ParameterAxis columns, rows;
};

enum class MapDirection { none, up, down };

/// "none", "up", "down".
std::string_view map_direction_name(MapDirection direction);

struct MapLayer {
  std::function<Vector(const Vector& p)> start;  ///< state at forcing phase 0; it may depend on the parameters
  MapDirection follow = MapDirection::none;      ///< along the rows, by columns
};

enum class MapType : std::uint8_t {
  undecided,
  periodic,
  chaotic,
  inadmissible,  ///< the start lies inside the barrier there
  lost,          ///< the motion could not be continued
  not_run
};
inline constexpr int map_types = 6;

/// "undecided", "periodic", "chaotic", "inadmissible", "lost", "not_run".
std::string_view map_type_name(MapType type);

struct MapPoint {
  MapType type = MapType::not_run;
  int period = 0, impacts = 0;  ///< n and p of a periodic attractor, else 0
  /// Per unit of dimensionless time; NaN if there is none, -infinity if the motion loses a direction at once.
  double lambda_1 = std::numeric_limits<double>::quiet_NaN();
  double standard_error = std::numeric_limits<double>::quiet_NaN();  ///< 0 for periodic: exact from the multipliers
  Vector state;                                                      ///< on the attractor, at forcing phase 0; NaN if none
  Vector quantities;  ///< of the attractor, by MapOptions::measure; empty if there is none or nothing is measured
};

struct MapOptions {
  int settle = 1000;             ///< longest transient from the layer's start, in forcing periods
  int transient = 300;           ///< the same from the neighbour's state
  int max_period = 64;           ///< longest period recognised
  int periods = 5000;            ///< longest average, in forcing periods
  double standard_error = 3e-3;  ///< bound for the average's standard errors; the sign of lambda_1 must also be significant
  FlowOptions flow = {};
  std::function<Vector(const Vector& p, const Attractor& attractor)> measure = {};  ///< quantities of a point, from any thread
  std::function<bool()> cancelled = {};
  std::function<void()> progress = {};  ///< after every point, from any thread
};

/// The points of `count` rows from row `first` on, ordered by row, layer, column. Points not reached because of `cancelled` are
/// not_run. Uses the threads of the caller's oneTBB arena; the result does not depend on their number.
/// @throws std::invalid_argument for an unknown parameter, values out of range, or an invalid grid or options.
std::vector<MapPoint> map_rows(const HybridSystem& system, const Vector& p, const ParameterGrid& grid,
                               const std::vector<MapLayer>& layers, int first, int count, const MapOptions& options = {});

/// Makes the checks of map_rows alone: throws as it does, and computes nothing.
void check_map(const HybridSystem& system, const Vector& p, const ParameterGrid& grid, const std::vector<MapLayer>& layers,
               const MapOptions& options);

}  // namespace graze
