// SPDX-License-Identifier: GPL-3.0-or-later
// Maps that are computed in pieces: their points against those of whole maps, and the order in which points begin and wait.
#include <graze/floquet/follow/map_work.hpp>

#include "support/checks.hpp"
#include "support/map_points.hpp"
#include "support/newton_oscillator.hpp"

#include <catch2/catch.hpp>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

using namespace graze;
using namespace graze::support;

namespace {

const ParameterGrid small_grid{{"eta", 0.70, 0.76, 12}, {"r", 1.8, 2.1, 6}};

double clearance(const Vector& p) { return p[static_cast<Eigen::Index>(parameter_index(newton_oscillator().parameters, "r"))]; }

Vector elastic() { return parameters(newton_oscillator(), {{"b", 0.05}, {"k_r", 1.0}}); }

/// Finished pieces, by their first rows.
struct Finished {
  std::mutex mutex;
  std::map<int, std::vector<MapPoint>> pieces;
  MapWork::Done taker() {
    return [this](int first, std::vector<MapPoint> points) {
      const std::lock_guard lock(mutex);
      pieces[first] = std::move(points);
    };
  }
};

}  // namespace

TEST_CASE("map work: pieces give the points of the whole map on any number of threads") {
  const MapDirection follow = GENERATE(MapDirection::none, MapDirection::down);
  const int threads = GENERATE(1, 3);
  const std::vector<MapLayer> layers = {from_rest(follow), from_rest(MapDirection::up)};
  const std::vector<MapPoint> whole = map_rows(newton_oscillator(), elastic(), small_grid, layers, 0, 6);
  Finished finished;
  MapWork map(newton_oscillator(), elastic(), small_grid, layers, {}, threads, finished.taker());
  map.give(4, 2);
  map.give(0, 1);
  std::vector<std::thread> workers;
  for (int k = 0; k < threads; ++k) workers.emplace_back([&map] { map.work(); });
  map.give(1, 3);  // to threads that work, or wait
  map.give(2, 0);
  map.close();
  for (std::thread& worker : workers) worker.join();
  std::vector<MapPoint> together;
  REQUIRE(finished.pieces.size() == 3);
  for (const auto& [first, points] : finished.pieces) together.insert(together.end(), points.begin(), points.end());
  REQUIRE(together.size() == whole.size());
  CHECK(std::equal(whole.begin(), whole.end(), together.begin(), [](const auto& a, const auto& b) { return same(a, b); }));
}

TEST_CASE("map work: points after a wrong guess of chaos are recomputed and progress counts each point once") {
  // At r = 2 there is chaos beyond the grazing, with periodic windows in which transients are long.
  const ParameterGrid row{{"eta", 0.70, 0.74, 60}, {"r", 2.0, 2.0, 1}};
  std::atomic<int> reported{0};
  const MapLayer layer{[](const Vector&) { return Vector{{0.0, 0.0}}; }, MapDirection::up};
  MapOptions options;
  options.transient = 1;  // so short that an average finds the orbit
  options.progress = [&reported] { ++reported; };
  const std::vector<MapPoint> points = map_rows(newton_oscillator(), elastic(), row, {layer}, 0, 1, options);
  CHECK(reported == 60);
  const auto of_type = [&](MapType type) {
    return std::count_if(points.begin(), points.end(), [type](const MapPoint& point) { return point.type == type; });
  };
  CHECK(of_type(MapType::chaotic) > 10);
  CHECK(of_type(MapType::periodic) > 10);
  CHECK(of_type(MapType::not_run) == 0);
  // A point after an orbit agrees with the result from that orbit's state.
  int checked = 0;
  for (std::size_t k = 1; k < points.size(); ++k) {
    if (points[k - 1].type != MapType::periodic) continue;
    const Vector from = points[k - 1].state;
    const double eta = row.columns.at(static_cast<int>(k));
    MapOptions alone = options;
    alone.settle = options.transient;
    const MapLayer there{[from](const Vector&) { return from; }, MapDirection::none};
    const MapPoint again =
        map_rows(newton_oscillator(), elastic(), {{"eta", eta, eta, 1}, {"r", 2.0, 2.0, 1}}, {there}, 0, 1, alone).front();
    CHECK(same(again, points[k]));
    ++checked;
  }
  CHECK(checked > 10);
}

TEST_CASE("map work: a long followed row, divided into stretches, follows the attractors of an undivided one") {
  const auto row = [](int count) {
    const double spacing = 2.5e-4, to = 0.85;
    const ParameterGrid line{{"eta", to - (count - 1) * spacing, to, count}, {"r", 2.0, 2.0, 1}};
    return map_rows(newton_oscillator(), elastic(), line, {from_rest(MapDirection::down)}, 0, 1);
  };
  const std::vector<MapPoint> undivided = row(500), divided = row(600);
  int periodic = 0, differ = 0;
  for (std::size_t k = 0; k < undivided.size(); ++k) {
    const MapPoint &one = undivided[k], &other = divided[k + 100];
    if (one.type == MapType::periodic && other.type == MapType::periodic) {
      ++periodic;
      CHECK(one.period == other.period);
      CHECK(one.impacts == other.impacts);
      CHECK(one.lambda_1 == Approx(other.lambda_1).epsilon(1e-6).margin(1e-9));
    } else {
      differ += one.type != other.type;  // in a narrow window, one start may still be on a chaotic transient
    }
  }
  CHECK(periodic > 250);
  CHECK(differ <= 2);
  oneapi::tbb::task_arena alone(1);
  std::vector<MapPoint> again;
  alone.execute([&] { again = row(600); });
  CHECK(std::equal(divided.begin(), divided.end(), again.begin(), [](const auto& a, const auto& b) { return same(a, b); }));
}

TEST_CASE("map work: the next piece begins while the last points of the one before are still running") {
  std::vector<int> rows;  // in which points were begun
  const MapLayer layer{[&rows](const Vector& p) {
                         rows.push_back(static_cast<int>(std::lround((clearance(p) - 1.8) / 0.06)));
                         return Vector{{0.0, 0.0}};
                       },
                       MapDirection::none};
  Finished finished;
  std::vector<std::size_t> begun_at_end;
  MapWork map(newton_oscillator(), elastic(), small_grid, {layer}, {}, 1,
              [&](int, const std::vector<MapPoint>&) { begun_at_end.push_back(rows.size()); });
  CHECK(map.wants_more());
  map.give(0, 1);
  CHECK(map.wants_more());  // few points: it will soon finish them
  map.give(1, 5);
  CHECK_FALSE(map.wants_more());
  map.close();
  map.work();
  REQUIRE(begun_at_end.size() == 2);
  CHECK(begun_at_end[0] > 12);  // points of the second piece before the end of the first
  CHECK(std::is_sorted(rows.begin(), rows.end()));
  CHECK(rows.size() == 72);
}

TEST_CASE("map work: an exception in one computation ends the others and those that wait") {
  const MapLayer thrower{[](const Vector& p) -> Vector {
                           if (clearance(p) > 1.9) throw std::runtime_error("no start");
                           return Vector{{0.0, 0.0}};
                         },
                         MapDirection::none};
  MapWork map(newton_oscillator(), elastic(), small_grid, {thrower}, {}, 2, [](int, const std::vector<MapPoint>&) {});
  std::atomic<int> thrown{0};
  const auto work = [&] {
    try {
      map.work();
    } catch (const std::runtime_error& error) {
      thrown += error.what() == std::string("no start") ? 1 : 0;
    }
  };
  std::thread waits(work), works(work);
  map.give(0, 6);  // it is not closed
  waits.join();
  works.join();
  CHECK(thrown >= 1);
  CHECK_THROWS_AS(map.give(4, 3), std::invalid_argument);
}
