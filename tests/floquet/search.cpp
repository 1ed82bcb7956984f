// SPDX-License-Identifier: GPL-3.0-or-later
// The benchmark of the global search: with two seeds it finds every orbit of period 1 to 4 that Newton's method finds from a
// dense grid of starts, at three parameter sets. Also tested: its options.
//
// Recorded numbers of orbits of period 1, 2, 3, 4. They were found on grids of 60 x 60, 150 x 150 and 40 x 40 starts; the
// grids here are smaller to save time.
// damped Hertz, eta = 0.711 (chaos beside a stable 1/1 orbit)    1, 2, 0, 1
// Newton's law, eta = 0.744 (4/4 and 2/3 orbits coexist)         1, 1, 2, 1
// beam with Hertz contact, beta = 0, eta = 0.554                 1, 1, 2, 1
#include <graze/floquet/attractor/search.hpp>
#include <graze/floquet/orbit/search_box.hpp>
#include <graze/lib/models/oscillator.hpp>

#include "support/checks.hpp"
#include "support/one_impact_orbit.hpp"
#include "support/two_mass_oscillator.hpp"
#include "support/van_der_pol_stop.hpp"

#include <catch2/catch.hpp>
#include <oneapi/tbb/task_arena.h>

#include <set>
#include <utility>

using namespace graze;
using namespace graze::support;

namespace {

struct Known {
  HybridSystem system;
  Vector p;
  std::array<std::size_t, 4> orbits;
};

Known dense_grid_of_damped_hertz() {
  HybridSystem system = make_oscillator("linear", "hertz");
  Vector p = parameters(system, {{"eta", 0.711}, {"b_H", 0.1}});
  return {std::move(system), std::move(p), {1, 2, 0, 1}};
}
Known elastic_newton() {
  HybridSystem system = make_oscillator("linear", "newton");
  Vector p = parameters(system, {{"eta", 0.744}});
  return {std::move(system), std::move(p), {1, 1, 2, 1}};
}
Known beam() {
  HybridSystem system = make_oscillator("cantilever", "hertz");
  Vector p = parameters(system, {{"eta", 0.554}, {"b", 0.026}, {"r", 0.079}, {"xi", 0.08}, {"beta", 0.0}});
  return {std::move(system), std::move(p), {1, 1, 2, 1}};
}

bool holds(const std::vector<PeriodicOrbit>& list, const PeriodicOrbit& orbit) {
  return std::any_of(list.begin(), list.end(), [&](const PeriodicOrbit& known) { return same_orbit(orbit, known, 1e-7); });
}

/// All orbits of least period n that Newton's method (40 iterations, 12 halvings) finds from the centres of side x side cells
/// of the box, alternately by single and by multiple shooting.
std::vector<PeriodicOrbit> from_grid(const Known& known, int n, int side) {
  const SearchBox box = search_box(known.system, known.p);
  const Vector &lower = box.lower, &upper = box.upper;
  std::vector<PeriodicOrbit> found;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      const Vector x = lower + (upper - lower).cwiseProduct(vector({(i + 0.5) / side, (j + 0.5) / side}));
      if (!mode_at(known.system, 0.0, x, known.p)) continue;
      const PeriodicOrbit orbit = shoot(known.system, known.p, x, n, {.nodes = (i + j) % 2 == 0 ? 1 : n});
      if (orbit.converged() && orbit.period == n && !holds(found, orbit)) found.push_back(orbit);
    }
  }
  return found;
}

void measure(const Known& known, int side) {
  for (int n = 1; n <= 4; ++n) {
    const std::vector<PeriodicOrbit> grid = from_grid(known, n, side);
    for (const unsigned seed : {1u, 2u}) {
      INFO(known.system.name << " period " << n << " seed " << seed);
      const SearchResult result = search_orbits(known.system, known.p, n, {.seed = seed});
      CHECK(result.complete);
      for (const PeriodicOrbit& orbit : grid) {
        INFO("orbit at " << orbit.state.transpose());
        CHECK(holds(result.orbits, orbit));
      }
      CHECK(result.orbits.size() == known.orbits[static_cast<std::size_t>(n - 1)]);
      for (const PeriodicOrbit& orbit : result.orbits) {
        CHECK(orbit.period == n);
        CHECK(orbit.checks.residual < 1e-12);
        CHECK(orbit.admissible != Admissibility::not_checked);
      }
    }
  }
}

}  // namespace

TEST_CASE("the search finds all orbits of a dense grid: damped Hertz in chaos") { measure(dense_grid_of_damped_hertz(), 16); }
TEST_CASE("the search finds all orbits of a dense grid: Newton's law with coexistence") { measure(elastic_newton(), 60); }
TEST_CASE("the search finds all orbits of a dense grid: a beam") { measure(beam(), 12); }

TEST_CASE("the search finds the orbits with one impact of the closed form") {
  // These include unstable orbits and pairs from folds. Both orbits of a pair are sought where they are admissible.
  const HybridSystem system = make_oscillator("linear", "newton");
  int looked_for = 0, unstable = 0;
  for (const double r : {0.7, 0.0, -0.4}) {
    for (const double k_r : {0.8, 0.95}) {
      for (const double eta : {1.3, 2.2, 2.9}) {
        const OneImpactParameters q{0.05, 1.0, eta, r, k_r};
        const Vector p = parameters(system, {{"eta", eta}, {"r", r}, {"k_r", k_r}});
        const SearchBox box = search_box(system, p);
        const Vector &lower = box.lower, &upper = box.upper;
        for (int n = 1; n <= 3; ++n) {
          std::vector<PeriodicOrbit> found;
          bool searched = false;
          for (const OneImpactOrbit& closed : one_impact_orbits(q, n)) {
            const Vector x = closed.states().front();
            const bool in_box = (x.array() > lower.array()).all() && (x.array() < upper.array()).all();
            if (!closed.admissible() || !in_box) continue;
            if (!searched) found = search_orbits(system, p, n).orbits;
            searched = true;
            ++looked_for;
            unstable += closed.stable() ? 0 : 1;
            INFO("eta " << eta << " r " << r << " k_r " << k_r << " n " << n << " speed " << closed.speed << " multiplier "
                        << closed.multipliers[0]);
            CHECK(std::any_of(found.begin(), found.end(), [&](const PeriodicOrbit& orbit) {
              return std::any_of(orbit.states.begin(), orbit.states.end(),
                                 [&](const Vector& state) { return (state - x).lpNorm<Eigen::Infinity>() < 1e-8; });
            }));
          }
        }
      }
    }
  }
  CHECK(looked_for > 15);
  CHECK(unstable > 6);
}

TEST_CASE("orbits have no duplicates and no multiples of shorter ones and the most stable is first") {
  const Known known = elastic_newton();
  for (int n = 2; n <= 4; ++n) {
    const std::vector<PeriodicOrbit> orbits = search_orbits(known.system, known.p, n).orbits;
    for (std::size_t i = 0; i < orbits.size(); ++i) {
      for (std::size_t j = i + 1; j < orbits.size(); ++j) {
        CHECK_FALSE(same_orbit(orbits[i], orbits[j], 1e-6));
        CHECK(std::abs(orbits[i].multipliers.values[0]) <= std::abs(orbits[j].multipliers.values[0]));
      }
      for (std::size_t k = 1; k < orbits[i].states.size(); ++k)
        CHECK((orbits[i].states[k] - orbits[i].state).lpNorm<Eigen::Infinity>() > 1e-6);
    }
  }
}

TEST_CASE("the same seed gives the same search on any number of threads") {
  const Known known = elastic_newton();
  const SearchResult first = search_orbits(known.system, known.p, 3, {.seed = 7, .patience = 300});
  SearchResult second;
  oneapi::tbb::task_arena(3).execute(
      [&] { second = search_orbits(known.system, known.p, 3, {.seed = 7, .patience = 300, .all_threads = true}); });
  CHECK(first.starts == second.starts);
  CHECK(first.converged == second.converged);
  REQUIRE(first.orbits.size() == second.orbits.size());
  for (std::size_t i = 0; i < first.orbits.size(); ++i) CHECK(first.orbits[i].state == second.orbits[i].state);
}

TEST_CASE("the search reports its end: patience, largest number of starts, or cancellation") {
  const Known known = elastic_newton();
  const SearchResult patient = search_orbits(known.system, known.p, 1, {.patience = 100});
  CHECK(patient.complete);
  CHECK(patient.starts >= 100);
  const SearchResult limited = search_orbits(known.system, known.p, 1, {.max_starts = 50});
  CHECK_FALSE(limited.complete);
  CHECK(limited.starts == 50);
  // Cancelled after the first of the settled runs, which has found the stable 1/1 orbit.
  const HybridSystem hertz = make_oscillator("linear", "hertz");
  int cancel_checks = 0;
  SearchOptions options;
  options.cancelled = [&] { return ++cancel_checks > 2000; };
  const SearchResult cancelled = search_orbits(hertz, parameters(hertz, {{"eta", 0.925}, {"b_H", 0.1}}), 1, options);
  CHECK_FALSE(cancelled.complete);
  CHECK(cancelled.starts < 2000);
  CHECK(cancelled.orbits.size() == 1);
}

TEST_CASE("progress of a search is reported with every start") {
  const Known known = elastic_newton();
  SearchOptions options;
  options.patience = 50;
  int calls = 0, last_starts = 0, last_orbits = 0;
  options.progress = [&](int starts, int orbits) {
    ++calls;
    CHECK(starts > last_starts);
    CHECK(orbits >= last_orbits);
    last_starts = starts;
    last_orbits = orbits;
  };
  const SearchResult result = search_orbits(known.system, known.p, 1, options);
  CHECK(calls == result.starts);
  CHECK(last_starts == result.starts);
  CHECK(last_orbits == 1);
}

TEST_CASE("a user-defined box is searched") {
  const Known known = elastic_newton();
  // The 2/3 orbit at (1.488, 1.730) and the 3/3 orbit at (1.604, 1.094), each with its own box.
  for (const auto& [x, impacts] : {std::pair{vector({1.488, 1.730}), 2}, {vector({1.604, 1.094}), 3}}) {
    SearchOptions options;
    options.lower = x - Vector(vector({0.05, 0.05}));
    options.upper = x + Vector(vector({0.05, 0.05}));
    options.patience = 300;
    const SearchResult result = search_orbits(known.system, known.p, 3, options);
    CHECK(std::any_of(result.orbits.begin(), result.orbits.end(),
                      [&, p = impacts](const PeriodicOrbit& o) { return o.impacts == p; }));
  }
}

TEST_CASE("the search box contains the motion even if the barrier leaves no room near the origin") {
  const HybridSystem rigid = make_oscillator("linear", "newton");
  for (const double r : {2.0, 0.0, -0.5, -3.0}) {
    INFO("r " << r);
    const SearchBox box = search_box(rigid, parameters(rigid, {{"eta", 1.6}, {"r", r}, {"k_r", 0.8}}));
    const Vector &lower = box.lower, &upper = box.upper;
    CHECK(lower[0] < r);
    CHECK(lower[0] < -0.5);
    CHECK(upper[0] > 0.0);
    CHECK(lower[1] < -0.5);
    CHECK(upper[1] > 0.5);
  }
}

TEST_CASE("orbits with impacts are found where the motion from rest stays far from the barrier") {
  const HybridSystem rigid = make_oscillator("linear", "newton"), hertz = make_oscillator("linear", "hertz");
  const std::vector<std::pair<const HybridSystem*, Vector>> systems = {
      {&rigid, parameters(rigid, {{"eta", 2.56}, {"b", 0.04687}, {"k_r", 0.84487}, {"r", 0.9758}})},
      {&rigid, parameters(rigid, {{"eta", 2.72}, {"b", 0.01475}, {"k_r", 0.97879}, {"r", 2.42999}})},
      {&rigid, parameters(rigid, {{"eta", 2.28}, {"b", 0.01282}, {"k_r", 0.71357}, {"r", 2.62466}})},
      {&hertz, parameters(hertz, {{"eta", 2.56}, {"b", 0.04687}, {"b_H", 0.05}, {"r", 0.9758}})}};
  for (const auto& [system, p] : systems) {
    INFO("eta " << p.transpose());
    // Closed form: without impact |x| <= 1/|1 - eta^2| (b is small), at most a quarter of the clearance.
    const SearchResult result = search_orbits(*system, p, 2, {.patience = 300});
    const bool found = std::any_of(result.orbits.begin(), result.orbits.end(), [](const PeriodicOrbit& orbit) {
      return orbit.impacts == 1 && orbit.stable() && orbit.admissible == Admissibility::admissible;
    });
    CHECK(found);
  }
}

TEST_CASE("orbits of a system with four states are searched through the same call") {
  const HybridSystem system = two_mass_oscillator();
  const SearchResult result = search_orbits(system, parameters(system), 1, {.patience = 60});
  REQUIRE(result.orbits.size() >= 1);
  CHECK(result.orbits[0].multipliers.values.size() == 4);
  CHECK(result.orbits[0].checks.residual < 1e-12);
}

TEST_CASE("misuse of the search is refused in a sentence") {
  const Known known = elastic_newton();
  CHECK_THROWS_WITH(search_orbits(known.system, known.p, 0), "period n is 0; allowed is a whole number from 1");
  const std::string box = "the search box needs a finite lower and a larger upper bound for each state";
  const double infinity = std::numeric_limits<double>::infinity();
  for (const auto& [lower, upper] : std::vector<std::pair<Vector, Vector>>{{vector({0.0, 0.0}), vector({1.0, 0.0})},
                                                                           {vector({0.0}), vector({1.0})},
                                                                           {vector({0.0, 0.0}), {}},
                                                                           {vector({0.0, 0.0}), vector({1.0, infinity})},
                                                                           {vector({0.0, std::nan("")}), vector({1.0, 1.0})}}) {
    SearchOptions options;
    options.lower = lower;
    options.upper = upper;
    CHECK_THROWS_WITH(search_orbits(known.system, known.p, 1, options), box);
  }
  const HybridSystem autonomous = van_der_pol_stop();
  CHECK_THROWS_WITH(search_orbits(autonomous, parameters(autonomous), 1),
                    "system van-der-pol-stop is autonomous; it has no forcing period");
  CHECK_THROWS_WITH(search_orbits(known.system, parameters(known.system, {{"k_r", 1.5}}), 1),
                    "parameter k_r is 1.5; allowed is [0, 1]");
}

TEST_CASE("the search finds orbits in a stiff contact at phase 0 where the map is strongly curved") {
  // The 2/2 orbit just beyond the period doubling of the 1/1 orbit, in contact at phase 0 in one of its two periods.
  const HybridSystem system = make_oscillator("linear", "linear");
  const Vector p = parameters(system, {{"b", 0.0112}, {"k_S", 5338.0}, {"eta", 1.0254}, {"r", 0.8234}});
  const SearchResult simple = search_orbits(system, p, 1), doubled = search_orbits(system, p, 2);
  REQUIRE(simple.orbits.size() == 1);
  CHECK(simple.orbits[0].impacts == 1);
  CHECK_FALSE(simple.orbits[0].stable());
  CHECK(simple.orbits[0].state[0] > 0.8234);
  REQUIRE_FALSE(doubled.orbits.empty());
  const PeriodicOrbit& orbit = doubled.orbits.front();
  CHECK(orbit.period == 2);
  CHECK(orbit.impacts == 2);
  CHECK(orbit.stable());
  CHECK(orbit.admissible == Admissibility::admissible);
}

TEST_CASE("stable orbits are found from many starts, each once, at each of several values") {
  const HybridSystem system = make_oscillator("linear", "newton");
  std::vector<Vector> values;
  for (const double eta : {2.3, 2.5, 2.7}) values.push_back(parameters(system, {{"r", 1.0}, {"k_r", 0.8}, {"eta", eta}}));
  const std::vector<PeriodicOrbit> found = search_stable_orbits(system, values);
  // The impactless orbit, and one of an isola.
  REQUIRE(found.size() == 6);
  for (const Vector& p : values) {
    std::multiset<std::pair<int, int>> kinds;
    for (const PeriodicOrbit& orbit : found) {
      if (orbit.parameters != p) continue;
      CHECK(orbit.converged());
      CHECK(orbit.stable());
      CHECK(orbit.events.size() == static_cast<std::size_t>(orbit.impacts));
      kinds.insert({orbit.impacts, orbit.period});
    }
    CHECK(kinds == std::multiset<std::pair<int, int>>{{0, 1}, {1, 2}});
    // The full search finds the same stable orbits.
    for (const int period : {1, 2})
      for (const PeriodicOrbit& orbit : search_orbits(system, p, period, {.patience = 500}).orbits) {
        if (!orbit.stable() || orbit.admissible != Admissibility::admissible) continue;
        CHECK(std::any_of(found.begin(), found.end(),
                          [&](const PeriodicOrbit& other) { return other.parameters == p && same_orbit(other, orbit); }));
      }
  }
  StableSearchOptions on_threads;
  on_threads.settling.all_threads = true;
  std::vector<PeriodicOrbit> again;
  oneapi::tbb::task_arena(3).execute([&] { again = search_stable_orbits(system, values, on_threads); });
  REQUIRE(again.size() == found.size());
  for (std::size_t i = 0; i < found.size(); ++i) CHECK(again[i].state == found[i].state);
  CHECK(search_stable_orbits(system, {}).empty());
  StableSearchOptions empty_box;
  empty_box.lower = empty_box.upper = Vector::Zero(2);
  CHECK_THROWS_AS(search_stable_orbits(system, values, empty_box), std::invalid_argument);
}
