// SPDX-License-Identifier: GPL-3.0-or-later
// A branch of symmetric orbits, and the loops of broken symmetry that begin and end on it: the cantilever's cubic oscillator
// with strong forcing, far from its barrier (xi = 20, r = 10). x(t + T/2) = -x(t) along the symmetric branch.
#include <graze/continuation/branch/branch_step.hpp>
#include <graze/continuation/graph/continuation.hpp>
#include <graze/lib/models/oscillator.hpp>

#include "support/branches.hpp"
#include "support/checks.hpp"
#include "support/rigid_stop.hpp"

#include <catch2/catch.hpp>

#include <cmath>
#include <complex>

using namespace graze;
using namespace graze::support;

namespace {

const HybridSystem& cantilever() {
  static const HybridSystem system = make_oscillator("cantilever", "newton");
  return system;
}

Vector driven_hard(double eta) { return parameters(cantilever(), {{"eta", eta}, {"xi", 20.0}, {"r", 10.0}, {"b", 0.05}}); }

/// The motion over half a period from phase 0.
Transition half_period(const Vector& p, const Vector& x) {
  Propagator propagator(cantilever(), p);
  Transition half;
  carry(propagator, 0.0, 0.5 * forcing_period(cantilever(), p), x, {.sensitivity = Sensitivity::state}, half);
  return half;
}

/// The same oscillator with a displaced origin of x: its symmetry is not a change of sign, so that it is not detected.
HybridSystem displaced(double by) {
  enum : Eigen::Index { b, xi, eta };
  HybridSystem system;
  system.name = "displaced";
  system.states = 2;
  system.parameters = {detail::parameter("b", 0.05, 0.0), detail::parameter("xi", 20.0),
                       detail::parameter("eta", 3.0, 0.0, true)};
  system.forcing_frequency = eta;
  Mode mode;
  mode.name = "free";
  mode.field = [by](double t, const Vector& x, const Vector& p, Vector& f) {
    const double z = x[0] - by;
    f[0] = x[1];
    f[1] = p[xi] * std::cos(p[eta] * t) - 2.0 * p[b] * x[1] - z - 36.0 / 35.0 * z * z * z;
  };
  mode.field_dx = [by](double, const Vector& x, const Vector& p, Matrix& J) {
    const double z = x[0] - by;
    J << 0.0, 1.0, -1.0 - 3.0 * 36.0 / 35.0 * z * z, -2.0 * p[b];
  };
  mode.field_dp = [](double t, const Vector& x, const Vector& p, Matrix& J) {
    J.setZero();
    J(1, b) = -2.0 * x[1];
    J(1, xi) = std::cos(p[eta] * t);
    J(1, eta) = -p[xi] * t * std::sin(p[eta] * t);
  };
  mode.field_dt = [](double t, const Vector&, const Vector& p, Vector& f) {
    f.setZero();
    f[1] = -p[xi] * p[eta] * std::sin(p[eta] * t);
  };
  system.modes = {mode};
  return system;
}

}  // namespace

TEST_CASE("a symmetric branch does not switch to the broken one at a branch point inside a step") {
  const PeriodicOrbit orbit = shoot(cantilever(), driven_hard(3.0), Vector{{4.2459, 1.2658}}, 1);
  REQUIRE(orbit.converged());
  // The usual steps and longer ones: steps of 0.1 and 0.2 passed a branch point and ended on a broken branch.
  for (const double step : {0.05, 0.1, 0.2, 0.3}) {
    INFO("steps up to " << step);
    ContinuationOptions options;
    options.to = 0.5;
    options.switch_generations = 0;
    options.trace.max_step = step;
    const std::vector<Branch> branches = continue_orbit(cantilever(), orbit, options);
    REQUIRE(branches.size() == 1);
    CHECK(branches[0].stop == BranchStop::reached_bound);
    for (const BranchPoint& point : branches[0].points) {
      const Transition half = half_period(driven_hard(point.value), point.state());
      INFO("eta " << point.value);
      CHECK((half.x1 + point.state()).lpNorm<Eigen::Infinity>() < 1e-8);  // residual 1e-12, multipliers up to 10
    }
    // Each loop begins and ends in a branch point. The mirror image of the orbit, half a period later, is the orbit. Symmetry
    // is lost where -Phi(T/2) has the multiplier -1, which the library does not use.
    const auto points = points_of(branches[0], PointType::BP);
    CHECK(points.size() == 6);
    for (const SpecialPoint& point : points) {
      CHECK(point.status == PointStatus::converged);
      const Matrix H = -half_period(driven_hard(point.value), point.orbit.state).Phi;
      CHECK(std::abs((H + Matrix::Identity(2, 2)).determinant()) < 1e-8);
    }
    CHECK(points_of(branches[0], PointType::PD).empty());  // squares of real numbers are not -1
    CHECK(check_branch(cantilever(), branches[0]) == std::vector<std::string>{});
  }
}

TEST_CASE("a branch that returns to one of its points is closed even if this is not its first point") {
  // The broken branch is entered from the symmetric one, next to a branch point. It returns to the point of entry, and not to
  // its first point.
  const HybridSystem system = displaced(1.0);
  const PeriodicOrbit orbit = shoot(system, parameters(system), Vector{{5.2459, 1.2658}}, 1);
  REQUIRE(orbit.converged());
  ContinuationOptions options;
  options.to = 0.5;
  options.switch_generations = 0;
  options.trace.max_step = 0.3;  // passes the branch point at eta = 0.6368 and ends on the broken branch
  options.trace.max_points = 1000;
  const std::vector<Branch> branches = continue_orbit(system, orbit, options);
  REQUIRE(branches.size() == 1);
  const Branch& branch = branches[0];
  CHECK(branch.stop == BranchStop::returned);
  CHECK(branch.message.find("the branch is closed") != std::string::npos);
  const auto same_states = [](const BranchPoint& a, const BranchPoint& b) {
    return (a.state() - b.state()).lpNorm<Eigen::Infinity>() < 1e-8 * (1.0 + a.state().lpNorm<Eigen::Infinity>());
  };
  const BranchPoint& last = branch.points.back();
  const auto met = std::find_if(branch.points.begin(), branch.points.end() - 1,
                                [&](const BranchPoint& point) { return same_states(point, last); });
  REQUIRE(met != branch.points.end() - 1);
  CHECK(met != branch.points.begin());
  // Exactly one turn: no other orbit occurs twice.
  int twice = 0;
  for (std::size_t i = 0; i + 1 < branch.points.size(); ++i)
    for (std::size_t j = i + 1; j + 1 < branch.points.size(); ++j)
      twice += same_states(branch.points[i], branch.points[j]) ? 1 : 0;
  CHECK(twice == 0);
}

TEST_CASE("a branch respects its largest number of points in states and in coordinates of the events") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const PeriodicOrbit struck = shoot(system, parameters(system), Vector{{1.0, 1.0}}, 1);
  const PeriodicOrbit free = shoot(cantilever(), driven_hard(3.0), Vector{{4.2459, 1.2658}}, 1);
  REQUIRE(free.converged());
  REQUIRE(struck.converged());
  REQUIRE(struck.impacts == 1);
  ContinuationOptions options;
  options.switch_generations = 0;
  for (const int most : {2, 7, 100}) {
    options.trace.max_points = most;
    options.to = 0.5;
    const Branch in_states = continue_orbit(cantilever(), free, options).front();
    CHECK(in_states.stop == BranchStop::point_limit);
    CHECK(std::ssize(in_states.points) == most);
    options.trace.max_points = std::min(most, 7);
    options.to = 0.9;
    const Branch by_impacts = continue_orbit(system, struck, options).front();
    CHECK(by_impacts.stop == BranchStop::point_limit);
    CHECK(std::ssize(by_impacts.points) == std::min(most, 7));
  }
}
