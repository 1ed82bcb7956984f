// SPDX-License-Identifier: GPL-3.0-or-later
// Folds in xi of soft contacts, computed in two ways. Near a fold the distance between the two orbits is the root of the
// distance in xi. The square of their difference, extrapolated to zero, therefore gives the fold without a condition on
// multipliers. With growing stiffness the fold tends to the hard one in closed form (k_r = 1) like the duration of a contact:
// k_S^(-1/2) (linear elastic), k_H^(-2/5) (Hertz).
#include <graze/continuation/graph/continuation.hpp>
#include <graze/lib/models/oscillator.hpp>

#include "support/branches.hpp"
#include "support/checks.hpp"
#include "support/one_impact_orbit.hpp"

#include <catch2/catch.hpp>

#include <cmath>

using namespace graze;
using namespace graze::support;

namespace {

/// One impact in n periods; b = 0.05.
struct Case {
  double eta, r;
  int n;
};
const Case cases[] = {{1.31, 0.3, 1}, {2.6, 0.3, 2}, {3.4, 0.3, 2}, {4.6, 0.3, 3}};

OneImpactFamily hard_family(const Case& c) { return one_impact_family({.b = 0.05, .eta = c.eta, .r = c.r, .k_r = 1.0}, c.n); }

/// The branch through the fold. It starts from the hard orbit with 1.7 times the speed at the fold, converted to the soft
/// contact.
Branch through_fold(const HybridSystem& system, const char* stiffness, double value, double b_H, const Case& c) {
  const OneImpactFamily family = hard_family(c);
  const double speed = 1.7 * family.fold_speed();
  OneImpactParameters q{.b = 0.05, .xi = family.xi(speed), .eta = c.eta, .r = c.r, .k_r = 1.0};
  Vector p = parameters(system, {{"b", q.b}, {"xi", q.xi}, {"eta", q.eta}, {"r", q.r}, {stiffness, value}});
  if (b_H > 0.0) p[static_cast<Eigen::Index>(parameter_index(system.parameters, "b_H"))] = b_H;
  ContinuationOptions options;
  options.parameter = "xi";
  options.to = 0.5 * family.xi_fold();
  options.from = q.xi;
  options.switch_generations = 0;
  for (const OneImpactOrbit& closed : one_impact_orbits(q, c.n)) {
    if (std::abs(closed.speed - speed) > 1e-6 * speed) continue;
    const PeriodicOrbit orbit = shoot(system, p, closed.states().front(), c.n);
    REQUIRE(orbit.converged());
    REQUIRE(orbit.impacts == 1);
    return continue_orbit(system, orbit, options)[0];
  }
  FAIL("the hard orbit is missing");
  return {};
}

SpecialPoint fold_of(const HybridSystem& system, const char* stiffness, double value, double b_H, const Case& c) {
  const Branch branch = through_fold(system, stiffness, value, b_H, c);
  const auto folds = points_of(branch, PointType::LP);
  REQUIRE(folds.size() == 1);
  CHECK(folds[0].status == PointStatus::converged);
  CHECK(branch.stop == BranchStop::reached_bound);
  CHECK(points_of(branch, PointType::BP).empty());
  CHECK(check_branch(system, branch) == std::vector<std::string>{});
  return folds[0];
}

/// Distance of the fold from the merging point of the two orbits, extrapolated from their difference at 1, 2 and 3 steps from
/// it.
double extrapolated_distance(const HybridSystem& system, const char* stiffness, double value, double b_H, const Case& c) {
  const Branch branch = through_fold(system, stiffness, value, b_H, c);
  const SpecialPoint fold = points_of(branch, PointType::LP).at(0);
  const auto xi = static_cast<Eigen::Index>(parameter_index(system.parameters, "xi"));
  const double h = 1e-4 * fold.value;
  double square[3];
  for (int k = 0; k < 3; ++k) {
    // From the points of the branch on either side of the fold; their distance is scaled like the root of the distance in xi.
    Vector state[2];
    for (const std::size_t side : {0u, 1u}) {
      const BranchPoint& point = branch.points[fold.after_point + side];
      Vector p = fold.orbit.parameters;
      p[xi] = fold.value + (k + 1) * h;
      const double nearer = std::sqrt((k + 1) * h / (point.value - fold.value));
      const PeriodicOrbit orbit =
          shoot(system, p, fold.orbit.state + nearer * (point.state() - fold.orbit.state), c.n, {.nodes = 1});
      REQUIRE(orbit.converged());
      state[side] = orbit.state;
    }
    square[k] = (state[0] - state[1]).squaredNorm();
    REQUIRE(square[k] > 1e-8);
  }
  return std::abs(3.0 * square[0] - 3.0 * square[1] + square[2]) / (square[1] - square[0]) * h;
}

}  // namespace

TEST_CASE("folds of soft contacts lie where the two merging orbits coincide") {
  const HybridSystem linear = make_oscillator("linear", "linear"), hertz = make_oscillator("linear", "hertz");
  for (const Case& c : cases) {
    for (const double value : {1e3, 1e4}) {
      INFO("eta " << c.eta << " n " << c.n << " stiffness " << value);
      // The error of the extrapolation is of third order in a relative step of 1e-4, plus rounding.
      const double tolerance = 1e-10;
      CHECK(extrapolated_distance(linear, "k_S", value, 0.0, c) < tolerance);
      for (const double b_H : {0.0, 0.05}) CHECK(extrapolated_distance(hertz, "k_H", value, b_H, c) < tolerance);
    }
  }
}

TEST_CASE("folds of soft contacts tend to the hard ones with the duration of the contact") {
  const HybridSystem linear = make_oscillator("linear", "linear"), hertz = make_oscillator("linear", "hertz");
  for (const Case& c : cases) {
    INFO("eta " << c.eta << " n " << c.n);
    const double hard = hard_family(c).xi_fold();
    const auto order = [&](const HybridSystem& system, const char* stiffness, double soft, double stiff) {
      const double far = fold_of(system, stiffness, soft, 0.0, c).value - hard;
      const double near = fold_of(system, stiffness, stiff, 0.0, c).value - hard;
      CHECK(near > 0.0);
      return std::log10(far / near) / std::log10(stiff / soft);
    };
    // The next term is smaller by the relative duration of the contact, 0.01 to 0.02.
    CHECK(order(linear, "k_S", 1e4, 1e5) == Approx(0.5).margin(0.03));
    CHECK(order(hertz, "k_H", 1e5, 1e6) == Approx(0.4).margin(0.03));
  }
}
