// SPDX-License-Identifier: GPL-3.0-or-later
// Recognition of an attractor before the motion has settled on it: trapping regions of orbits, and the cells visited by chaos.
#include <graze/floquet/attractor/settle.hpp>
#include <graze/floquet/basins/trapping_region.hpp>
#include <graze/floquet/basins/visited_cells.hpp>
#include <graze/floquet/orbit/shooting.hpp>
#include <graze/lib/models/oscillator.hpp>

#include "support/checks.hpp"
#include "support/two_mass_oscillator.hpp"

#include <catch2/catch.hpp>

#include <Eigen/Cholesky>

#include <random>

using namespace graze;
using namespace graze::support;

namespace {

PeriodicOrbit settled_orbit(const HybridSystem& system, const Vector& p, const Vector& start) {
  const Settled settled = settle(system, p, start, {.periods = 3000});
  REQUIRE(settled.suspected_period > 0);
  PeriodicOrbit orbit = shoot(system, p, settled.state, settled.suspected_period);
  REQUIRE(orbit.stable());
  return orbit;
}

/// Points spread over the region around state k.
std::vector<Vector> inside(const TrappingRegion& region, std::size_t k, int count) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> radius(0.0, 1.0);
  std::vector<Vector> points;
  const Matrix upper = Eigen::LLT<Matrix>(region.metrics[k]).matrixU();
  for (int i = 0; i < count; ++i) {
    Vector u(upper.rows());
    for (double& entry : u) entry = normal(random);
    u *= 0.999 * region.size * radius(random) / u.norm();
    points.push_back(region.centres[k] + upper.triangularView<Eigen::Upper>().solve(u));
  }
  return points;
}

/// From every point in the region the motion never leaves it and converges to the orbit at the rate of its multipliers.
void check_trap(const HybridSystem& system, const Vector& p, const PeriodicOrbit& orbit) {
  const TrappingRegion region = trapping_region(system, p, orbit.state, orbit.period);
  REQUIRE(region.size > 0.0);
  REQUIRE(region.centres.size() == static_cast<std::size_t>(orbit.period));
  Propagator propagator(system, p);
  Transition transition;
  const double T = forcing_period(system, p);
  const double rate = -orbit.multipliers.exponents.front() * T;  // per period
  const int periods = static_cast<int>(std::ceil(std::log(1e4) / rate)) + 20;
  for (std::size_t k = 0; k < region.centres.size(); ++k)
    for (Vector x : inside(region, k, 40)) {
      bool stays = true;
      for (int i = 0; i < periods; ++i) {
        stays = stays && region.holds(x);
        carry(propagator, 0.0, T, x, {.sensitivity = Sensitivity::none}, transition);
        REQUIRE(transition.termination == Termination::time);
        x = transition.x1;
      }
      CHECK(stays);
      // Ten thousand times smaller by the slowest multiplier; the eccentricity of the region may cost a part of it.
      CHECK(region.distance(x) < 1e-2 * region.size + 1e-11);
    }
}

}  // namespace

TEST_CASE("from every point of a trapping region the motion converges to its orbit") {
  const HybridSystem hertz = make_oscillator("linear", "hertz"), newton = make_oscillator("linear", "newton");
  const Vector rest = Vector::Zero(2);
  SECTION("impactless") {
    const Vector p = parameters(hertz, {{"eta", 0.66}, {"b_H", 0.1}});
    check_trap(hertz, p, settled_orbit(hertz, p, steady_response(p)));
  }
  SECTION("damped Hertz 1/1") {
    const Vector p = parameters(hertz, {{"eta", 0.925}, {"b_H", 0.1}});
    check_trap(hertz, p, settled_orbit(hertz, p, rest));
  }
  SECTION("damped Hertz, weak impacts") {
    const Vector p = parameters(hertz, {{"eta", 0.711}, {"b_H", 0.1}});
    check_trap(hertz, p, settled_orbit(hertz, p, vector({0.575, -1.363})));
  }
  SECTION("Newton, period 4") {
    const Vector p = parameters(newton, {{"eta", 0.744}});
    check_trap(newton, p, settled_orbit(newton, p, vector({-0.169, -0.962})));
  }
  SECTION("sticking: the orbit's matrix has no inverse") {
    const Vector p = parameters(newton, {{"eta", 0.9}, {"k_r", 0.0}, {"r", 1.0}});
    check_trap(newton, p, settled_orbit(newton, p, rest));
  }
  SECTION("four states") {
    const HybridSystem two = two_mass_oscillator();
    const Vector p = parameters(two, {{"k_r", 0.6}, {"eta", 0.9}});
    check_trap(two, p, settled_orbit(two, p, Vector::Zero(4)));
  }
}

TEST_CASE("the ellipses of a trapping region enclose it closely") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = parameters(system, {{"eta", 0.95}, {"r", 2.0}, {"k_r", 1.0}, {"b", 0.05}});
  const PeriodicOrbit orbit = settled_orbit(system, p, vector({0.0, 0.0}));
  const TrappingRegion region = trapping_region(system, p, orbit.state, orbit.period);
  const std::vector<StateEllipse> ellipses = region.ellipses();
  REQUIRE(ellipses.size() == region.centres.size());
  const auto measure = [](const StateEllipse& e, const Vector& x) {
    const double d = x[0] - e.x0, d_v = x[1] - e.v0;
    return e.xx * d * d + e.xv * d * d_v + e.vv * d_v * d_v;
  };
  for (std::size_t k = 0; k < ellipses.size(); ++k)
    for (const Vector& x : inside(region, k, 200)) {
      const Vector d = x - region.centres[k];
      const double exact = d.dot(region.metrics[k] * d) / (region.size * region.size);  // <= 1 inside
      CHECK(region.holds(x));
      CHECK(measure(ellipses[k], x) <= 1.0);
      CHECK(measure(ellipses[k], x) == Approx(exact).epsilon(2e-3));
    }
  CHECK(TrappingRegion{}.ellipses().empty());
}

TEST_CASE("the trapping region of the impactless orbit is free of impacts and not needlessly small") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = parameters(system, {{"eta", 0.66}});
  const Vector state = steady_response(p);
  const double gap = p[oscillator_parameter::r] - std::hypot(state[0], state[1] / p[oscillator_parameter::eta]);
  const TrappingRegion region = trapping_region(system, p, state, 1);
  // All tested states of the shell, of size 2 size, are within 2 size of the orbit. A free displacement grows at most by (1 +
  // b) / (1 - b) = 1.1. A size below gap / 2.2 must therefore pass, and the search halves.
  CHECK(region.size > gap / 4.5);
  for (const Vector& x : inside(region, 0, 200))
    CHECK(simulate(system, p, 0.0, x, {.t_end = 3.0 * forcing_period(system, p)}).events.empty());
}

TEST_CASE("an unstable orbit has no trapping region") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector p = parameters(system, {{"eta", 0.9}, {"b_H", 0.1}});  // below the period doubling at 0.9195
  const PeriodicOrbit orbit = shoot(system, p, vector({2.05, 1.35}), 1);
  REQUIRE(orbit.converged());
  REQUIRE_FALSE(orbit.stable());
  const TrappingRegion region = trapping_region(system, p, orbit.state, 1);
  CHECK(region.size == 0.0);
  CHECK_FALSE(region.holds(orbit.state));
}

TEST_CASE("chaos is recognised by its visited cells and a periodic motion among them is not taken for it") {
  // Henon's map; its attractor has dimension 1.26.
  const auto henon = [](Vector x, int count, int skip) {
    std::vector<Vector> states;
    for (int i = 0; i < count + skip; ++i) {
      x = Vector{{1.0 - 1.4 * x[0] * x[0] + x[1], 0.3 * x[0]}};
      if (i >= skip) states.push_back(x);
    }
    return states;
  };
  const VisitedCells cells(henon(Vector{{0.1, 0.1}}, 20000, 100));
  const std::vector<Vector> other = henon(Vector{{-0.3, 0.2}}, 2000, 20);
  CHECK(cells.share(other) > 0.99);  // 0.999 for its own second half
  CHECK(cells.count() > 100);        // 64 cells across would be 64^1.26 = 190 of them, 32 across 80
  CellResidence strand;
  int recognised = 0;
  for (const Vector& x : other) recognised += strand.add(cells, x) ? 1 : 0;
  CHECK(recognised > 10);
  CHECK(recognised <= 2000 / VisitedCells::window);
  CellResidence still;
  const Vector fixed_point{{0.6313544770895048, 0.18940634312685142}};  // lies on the attractor
  REQUIRE(cells.holds(fixed_point));
  bool taken = false;
  for (int i = 0; i < 1000; ++i) taken = taken || still.add(cells, fixed_point);
  CHECK_FALSE(taken);
  CHECK_FALSE(cells.holds(Vector{{5.0, 5.0}}));
  CHECK_FALSE(cells.holds(Vector{{-5.0, -5.0}}));
}
