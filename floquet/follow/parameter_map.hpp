// SPDX-License-Identifier: GPL-3.0-or-later
// ParameterMap: the attractor at every point of a grid over two parameters: what it is, its z = p/n and its first exponent.
//
// The grid has columns (values of the first parameter) and rows (values of the second). A layer is the whole grid seen from one
// start: either every point starts from it, or a row is followed: its first point starts from it, every further one from where
// its neighbour came to, which is on its orbit, or, where it has none, at the end of its transient, in the direction given (as in
// a sweep, with its hysteresis). So rows know nothing of each other, and any part of the map can be computed anywhere, in any
// order, with the same result to the last bit.
//
// What is periodic is proved by Newton's method, mostly after a few dozen forcing periods, and its exponents are those of its
// multipliers; only the rest takes a transient and a time average.
#pragma once

#include <graze/floquet/attractor/attractor.hpp>

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace graze {

/// So many equally spaced values of a parameter, from `from` to `to`, both included.
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
  lost,          ///< the motion could not be carried on
  not_run
};
inline constexpr int map_types = 6;

/// "undecided", "periodic", "chaotic", "inadmissible", "lost", "not_run".
std::string_view map_type_name(MapType type);

struct MapPoint {
  MapType type = MapType::not_run;
  int period = 0, impacts = 0;  ///< n and p of a periodic one, else 0
  /// Per unit of dimensionless time; NaN where there is none, -infinity where the motion forgets a direction at once.
  double lambda_1 = std::numeric_limits<double>::quiet_NaN();
  double standard_error = std::numeric_limits<double>::quiet_NaN();  ///< 0 of a periodic one: it is that of its multipliers
  Vector state;                                                      ///< on the attractor, at forcing phase 0; NaN if none
  Vector quantities;  ///< of the attractor, by MapOptions::measure; empty if there is none or nothing is measured
};

struct MapOptions {
  int settle = 1000;             ///< most forcing periods before an average, from the layer's start
  int transient = 300;           ///< the same, from the neighbour's state
  int max_period = 64;           ///< longest period that is recognised
  int periods = 5000;            ///< most forcing periods of an average
  double standard_error = 3e-3;  ///< bound of the average's standard errors; it goes on until the sign of lambda_1 is sure, too
  FlowOptions flow = {};
  std::function<Vector(const Vector& p, const Attractor& attractor)> measure = {};  ///< quantities of a point, from any thread
  std::function<bool()> cancelled = {};
  std::function<void()> progress = {};  ///< after every point, from any thread
};

/// The points of `count` rows from row `first` on, ordered by row, layer, column. Points that were not reached because of
/// `cancelled` are not_run. Uses the threads of the oneTBB arena that it is called in; the result does not depend on them.
/// @throws std::invalid_argument for an unknown parameter, values out of range, a grid or options without sense.
std::vector<MapPoint> map_rows(const HybridSystem& system, const Vector& p, const ParameterGrid& grid,
                               const std::vector<MapLayer>& layers, int first, int count, const MapOptions& options = {});

/// Checks what map_rows throws for, without computing anything.
void check_map(const HybridSystem& system, const Vector& p, const ParameterGrid& grid, const std::vector<MapLayer>& layers,
               const MapOptions& options);

}  // namespace graze
