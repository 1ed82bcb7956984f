// SPDX-License-Identifier: GPL-3.0-or-later
// Parameter maps: points against attractors found one by one and against closed forms, parts against the whole map. Also
// tested: hysteresis of followed rows, points near bifurcations, misuse.
#include <graze/floquet/follow/parameter_map.hpp>
#include <graze/floquet/follow/sweep.hpp>
#include <graze/floquet/orbit/shooting.hpp>
#include <graze/lib/models/oscillator.hpp>

#include "support/damped_hertz.hpp"
#include "support/map_points.hpp"
#include "support/newton_oscillator.hpp"

#include <catch2/catch.hpp>

#include <oneapi/tbb/task_arena.h>

#include <atomic>
#include <cmath>

using namespace graze;
using namespace graze::support;
using Catch::Matchers::Contains;

namespace {

std::vector<MapPoint> in_arena(int threads, const ParameterGrid& grid, const std::vector<MapLayer>& layers, int first,
                               int count) {
  oneapi::tbb::task_arena arena(threads);
  std::vector<MapPoint> points;
  arena.execute([&] { points = map_rows(damped_hertz(), hertz_parameters(), grid, layers, first, count); });
  return points;
}

}  // namespace

TEST_CASE("map: any part has identical bits on any number of threads") {
  const ParameterGrid grid{{"eta", 0.70, 0.75, 7}, {"r", 1.9, 2.1, 4}};
  const std::vector<MapLayer> layers = {from_rest(), from_rest(MapDirection::up), from_rest(MapDirection::down)};
  const std::vector<MapPoint> whole = in_arena(2, grid, layers, 0, 4);
  REQUIRE(whole.size() == 7 * 4 * 3);
  std::vector<MapPoint> parts;
  for (const auto& [first, count] : {std::pair{0, 1}, {1, 2}, {3, 1}})
    for (const MapPoint& point : in_arena(1, grid, layers, first, count)) parts.push_back(point);
  REQUIRE(parts.size() == whole.size());
  int chaotic = 0, periodic = 0;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    INFO(i);
    CHECK(same(whole[i], parts[i]));
    chaotic += whole[i].type == MapType::chaotic;
    periodic += whole[i].type == MapType::periodic;
  }
  CHECK(chaotic > 5);  // both kinds occurred
  CHECK(periodic > 5);
}

TEST_CASE("map: its points agree with attractors found one by one") {
  // The slow way: the complete transient, all returns tried, long averages. The points of the grid lie away from bifurcations.
  const ParameterGrid grid{{"eta", 0.66, 0.94, 5}, {"r", 1.2, 2.9, 4}};
  const std::vector<MapPoint> points = map_rows(damped_hertz(), hertz_parameters(), grid, {from_rest()}, 0, 4);
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 5; ++column) {
      const double eta = grid.columns.at(column), r = grid.rows.at(row);
      INFO("eta " << eta << " r " << r);
      const MapPoint& point = points[static_cast<std::size_t>(row * 5 + column)];
      AttractorOptions slow;
      slow.periods_on_orbit = 0;
      slow.lyapunov.standard_error = 1e-3;
      const Attractor attractor = find_attractor(damped_hertz(), hertz_parameters(eta, r), Vector{{0.0, 0.0}}, slow);
      CHECK(map_type_name(point.type) == attractor_type_name(attractor.type));
      CHECK(point.period == attractor.period);
      CHECK(point.impacts == attractor.impacts);
      if (attractor.type == AttractorType::periodic) {
        // One orbit, reached in two ways by Newton's method: equal up to its tolerance, 1e-12, times the condition of the
        // orbit.
        CHECK(point.lambda_1 == Approx(attractor.exponents[0]).margin(1e-9));
        CHECK(point.standard_error == 0.0);
      } else {
        const double error = std::hypot(point.standard_error, attractor.standard_errors[0]);
        CHECK(std::abs(point.lambda_1 - attractor.exponents[0]) < 5.0 * error);
      }
    }
}

TEST_CASE("map: the impactless orbit exists exactly where its amplitude is below the clearance") {
  // A(eta) = xi / sqrt((1 - eta^2)^2 + (2 b eta)^2) < r; both exponents are -b.
  const HybridSystem& system = newton_oscillator();
  const Vector p = parameters(system, {{"b", 0.05}, {"k_r", 0.7}});
  const ParameterGrid grid{{"eta", 0.6, 1.5, 12}, {"r", 0.5, 4.0, 8}};
  const std::vector<MapPoint> points = map_rows(system, p, grid, {from_rest(MapDirection::up)}, 0, 8);
  int impactless = 0;
  for (int row = 0; row < 8; ++row)
    for (int column = 0; column < 12; ++column) {
      const double eta = grid.columns.at(column), r = grid.rows.at(row), detuning = 1.0 - eta * eta;
      const double amplitude = 1.0 / std::hypot(detuning, 0.1 * eta);
      const MapPoint& point = points[static_cast<std::size_t>(row * 12 + column)];
      if (point.type != MapType::periodic || point.impacts > 0) continue;
      INFO("eta " << eta << " r " << r);
      ++impactless;
      CHECK(amplitude < r);
      CHECK(point.period == 1);
      CHECK(point.lambda_1 == Approx(-0.05).epsilon(1e-10));  // rounding of exp and ln over a period
      CHECK(point.state[0] == Approx(detuning * amplitude * amplitude).margin(1e-9));
    }
  CHECK(impactless > 20);
}

TEST_CASE("map: a followed row agrees with the sweep and has its hysteresis") {
  // Upwards the impactless orbit lasts to its grazing at 0.710687; downwards chaos lasts to about 0.6975.
  const ParameterGrid grid{{"eta", 0.69, 0.715, 26}, {"r", 2.0, 2.0, 1}};
  const std::vector<MapPoint> points =
      map_rows(damped_hertz(), hertz_parameters(), grid, {from_rest(MapDirection::up), from_rest(MapDirection::down)}, 0, 1);
  SweepOptions options;
  options.from = 0.69;
  options.to = 0.715;
  options.step = 0.001;
  options.attractor.transient = 300;
  options.attractor.periods_on_orbit = 0;
  options.attractor.lyapunov.standard_error = 3e-3;
  options.attractor.lyapunov.min_periods = 500;
  options.attractor.lyapunov.max_periods = 5000;
  const std::vector<SweepRow> rows = sweep(damped_hertz(), hertz_parameters(), Vector{{0.0, 0.0}}, options);
  REQUIRE(rows.size() == 26);
  int up_and_down_differ = 0;
  for (int k = 0; k < 26; ++k) {
    const MapPoint &up = points[static_cast<std::size_t>(k)], &down = points[static_cast<std::size_t>(26 + k)];
    INFO("eta " << grid.columns.at(k));
    CHECK(map_type_name(up.type) == attractor_type_name(rows[static_cast<std::size_t>(k)].attractor.type));
    up_and_down_differ += up.type != down.type;
    if (k <= 20) CHECK(up.impacts == 0);
    // Both directions agree on chaos inside the chaotic interval; its ends depend on the state of the motion.
    if (k >= 9 && k <= 24) CHECK(down.type == MapType::chaotic);
  }
  CHECK(up_and_down_differ >= 10);
}

TEST_CASE("map: leaving a weakly unstable orbit is not taken for chaos") {
  // Just below the period doubling at eta = 0.919542643 the 1/1 orbit repels by 0.1 per cent a period. The motion that leaves
  // it grows steadily: its exponent is positive by many standard errors, although the attractor is the 2/2 orbit.
  const Vector p = hertz_parameters(0.9190);
  const PeriodicOrbit orbit = shoot(damped_hertz(), p, Vector{{2.05, 1.4}}, 1);
  REQUIRE(orbit.converged());
  REQUIRE_FALSE(orbit.stable());
  CHECK(std::abs(orbit.multipliers.values.front()) < 1.01);
  for (const double away : {1e-12, 1e-6, 1e-3}) {
    INFO(away);
    const Vector start = orbit.state + Vector{{0.0, away}};
    const ParameterGrid grid{{"eta", 0.9190, 0.9190, 1}, {"r", 2.0, 2.0, 1}};
    const MapLayer layer{[start](const Vector&) { return start; }, MapDirection::none};
    MapOptions options;
    options.settle = 300;
    const MapPoint point = map_rows(damped_hertz(), p, grid, {layer}, 0, 1, options).front();
    CHECK(point.type == MapType::periodic);
    CHECK(point.period == 2);
  }
}

TEST_CASE("map: a transient that grows for a while is not taken for chaos") {
  // In a row followed upwards the motion leaves the impactless orbit at its grazing. The transient lasts some thousand forcing
  // periods, and its exponent is positive by five standard errors as soon as five would suffice. The attractor is the 1/2
  // orbit, with a decay of e^-0.05 per unit of time.
  const HybridSystem& system = newton_oscillator();
  const Vector p = parameters(system, {{"b", 0.05}, {"k_r", 1.0}});
  const ParameterGrid grid{{"eta", 0.65, 0.95, 90}, {"r", 1.0 + 15 * (2.0 / 59.0), 1.0 + 15 * (2.0 / 59.0), 1}};
  const std::vector<MapPoint> points = map_rows(system, p, grid, {from_rest(MapDirection::up)}, 0, 1);
  const MapPoint& point = points[83];
  CHECK(point.type == MapType::periodic);
  CHECK(point.period == 2);
  CHECK(point.lambda_1 == Approx(-0.05));
}

TEST_CASE("map: starts inside a barrier and points that were not reached are reported") {
  const HybridSystem& system = newton_oscillator();
  const Vector p = parameters(system, {{"b", 0.05}, {"k_r", 0.7}});
  const ParameterGrid grid{{"eta", 0.7, 0.8, 2}, {"r", 1.0, 3.0, 3}};
  const MapLayer high{[](const Vector&) { return Vector{{2.5, 0.0}}; }, MapDirection::none};
  const std::vector<MapPoint> points = map_rows(system, p, grid, {high}, 0, 3);
  for (int i = 0; i < 4; ++i) CHECK(points[static_cast<std::size_t>(i)].type == MapType::inadmissible);
  CHECK(points[4].type == MapType::periodic);
  CHECK(std::isnan(points[0].lambda_1));
  CHECK(std::isnan(points[0].state[0]));
  std::atomic<int> cancel_checks{0};
  MapOptions options;
  options.cancelled = [&cancel_checks] { return ++cancel_checks > 2; };
  const std::vector<MapPoint> part = map_rows(system, p, grid, {from_rest(MapDirection::up)}, 0, 3, options);
  CHECK(part.back().type == MapType::not_run);
}

TEST_CASE("map: wrong inputs") {
  const Vector p = hertz_parameters();
  const ParameterGrid good{{"eta", 0.7, 0.8, 3}, {"r", 1.0, 2.0, 2}};
  const auto refused = [&](const ParameterGrid& grid, const std::vector<MapLayer>& layers, int first, int count,
                           const MapOptions& options = {}) -> std::string {
    try {
      map_rows(damped_hertz(), p, grid, layers, first, count, options);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "nothing was refused";
  };
  CHECK_THAT(refused({{"eta", 0.7, 0.8, 3}, {"eta", 0.7, 0.8, 3}}, {from_rest()}, 0, 1), Contains("both parameters"));
  CHECK_THAT(refused({{"eta", 0.7, 0.8, 3}, {"k_r", 0.7, 0.8, 3}}, {from_rest()}, 0, 1), Contains("k_r"));
  CHECK_THAT(refused({{"eta", 0.0, 0.8, 3}, {"r", 1.0, 2.0, 2}}, {from_rest()}, 0, 1), Contains("eta") && Contains("0"));
  CHECK_THAT(refused({{"eta", 0.8, 0.7, 3}, {"r", 1.0, 2.0, 2}}, {from_rest()}, 0, 1), Contains("the first below the last"));
  CHECK_THAT(refused(good, {}, 0, 1), Contains("no start"));
  CHECK_THAT(refused(good, {from_rest()}, 1, 2), Contains("rows 1 to 2 were asked for; the map has 2"));
  MapOptions options;
  options.periods = 0;
  CHECK_THAT(refused(good, {from_rest()}, 0, 1, options), Contains("periods is 0"));
  options = {};
  options.standard_error = 0.0;
  CHECK_THAT(refused(good, {from_rest()}, 0, 1, options), Contains("standard_error is 0"));
}
