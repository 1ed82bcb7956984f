// SPDX-License-Identifier: GPL-3.0-or-later
// Every orbit of data/reference.toml, found by shooting from a nearby state.
#include <graze/floquet/orbit/shooting.hpp>

#include "support/checks.hpp"
#include "support/reference.hpp"

#include <catch2/catch.hpp>

#include <cmath>

using namespace graze;
using namespace graze::support;

namespace {

/// The reference has 22 digits, more than a double. Newton's method stops at the rounding of the map, a few 1e-15, and the
/// error of the orbit is that times |(M - I)^-1|, below 100 for all of them.
constexpr double state_margin = 1e-12;
/// Multipliers change with the state, by 4e2 times its error for the period-24 orbit at 0.7116. Newton's error there is up to
/// 3e-13 (rounding 5e-15 of the map over the distance of the multipliers from 1), which gives 1.1e-10.
constexpr double multiplier_tolerance = 3e-10;

/// Displaced by 1e-5 in both entries. The windows of the long orbits are not much wider.
PeriodicOrbit shoot_beside(const ReferenceOrbit& reference, const ShootingOptions& options = {}) {
  const Vector start = reference.state + Vector(vector({-1e-5, 1e-5}));
  return shoot(reference.system, reference.parameters, start, reference.period, options);
}

double distance(const Vector& a, const Vector& b) {
  return (a - b).lpNorm<Eigen::Infinity>() / (1.0 + b.lpNorm<Eigen::Infinity>());
}

double distance(const std::vector<std::complex<double>>& a, const std::vector<std::complex<double>>& b) {
  if (a.size() != b.size()) return std::numeric_limits<double>::infinity();
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

}  // namespace

TEST_CASE("shooting from near every reference orbit finds its state, period and number of impacts") {
  for (const ReferenceOrbit& reference : reference_orbits()) {
    INFO(reference.name);
    const PeriodicOrbit orbit = shoot_beside(reference);
    CHECK(orbit.newton.status == NewtonStatus::converged);
    CHECK(orbit.period == reference.period);
    CHECK(orbit.impacts == reference.impacts);
    CHECK(distance(orbit.state, reference.state) < state_margin);
    CHECK(orbit.admissible == Admissibility::admissible);
    CHECK(orbit.duration == Approx(reference.period * forcing_period(reference.system, reference.parameters)).epsilon(1e-15));
  }
}

TEST_CASE("multipliers and exponents of every reference orbit agree with it") {
  for (const ReferenceOrbit& reference : reference_orbits()) {
    INFO(reference.name);
    const PeriodicOrbit orbit = shoot_beside(reference);
    REQUIRE(orbit.multipliers.valid);
    CHECK(distance(orbit.multipliers.values, reference.multipliers) < multiplier_tolerance);
    CHECK(orbit.multipliers.trivial == 0);
    CHECK(orbit.multipliers.section == Section::stroboscopic);
    for (std::size_t i = 0; i < 2; ++i) CHECK(std::abs(orbit.multipliers.exponents[i] - reference.exponents[i]) < 1e-10);
    // A multiplier on the unit circle to rounding makes an orbit neither stable nor unstable.
    if (!reference.period_doubling) CHECK(orbit.stable() == (std::abs(reference.multipliers[0]) < 1.0));
  }
}

TEST_CASE("the small multiplier of every reference orbit has relative accuracy") {
  for (const ReferenceOrbit& reference : reference_orbits()) {
    const PeriodicOrbit orbit = shoot_beside(reference);
    const std::complex<double> small = reference.multipliers[1];
    INFO(reference.name << ", " << small);
    // ln|mu_2| = ln det - ln|mu_1|: as accurate as the large one, for any size of the small one.
    CHECK(std::abs(orbit.multipliers.values[1] - small) <
          multiplier_tolerance * std::max(1.0, 1.0 / std::abs(reference.multipliers[0])) * std::abs(small));
  }
}

TEST_CASE("the monodromy matrix of every reference orbit agrees with it") {
  for (const ReferenceOrbit& reference : reference_orbits()) {
    INFO(reference.name);
    const PeriodicOrbit orbit = shoot_beside(reference);
    const double scale = 1.0 + reference.monodromy.cwiseAbs().maxCoeff();
    CHECK((orbit.monodromy.product() - reference.monodromy).cwiseAbs().maxCoeff() / scale < multiplier_tolerance);
    double log_det = 0.0;
    for (const Matrix& factor : orbit.monodromy.factors) log_det += std::log(std::abs(factor.determinant()));
    CHECK(std::abs(log_det - reference.log_det) < 1e-10);
  }
}

TEST_CASE("impact times and speeds of every reference orbit agree with it") {
  for (const ReferenceOrbit& reference : reference_orbits()) {
    INFO(reference.name);
    const PeriodicOrbit orbit = shoot_beside(reference);
    std::vector<double> times, speeds;
    for (const EventRecord& event : orbit.events) {
      if (event.kind != EventKind::impact && event.kind != EventKind::enter) continue;
      times.push_back(event.t);
      speeds.push_back(event.normal_speed);
    }
    REQUIRE(times.size() == reference.impact_times.size());
    // The error of an impact time is that of the position over the speed; the weakest impact here has speed 0.0087.
    for (std::size_t i = 0; i < times.size(); ++i) {
      CHECK(std::abs(times[i] - reference.impact_times[i]) < 1e-9);
      CHECK(std::abs(speeds[i] - reference.impact_speeds[i]) < 1e-10);
    }
  }
}

TEST_CASE("every reference orbit has its proofs: residual, Liouville and finite differences") {
  for (const ReferenceOrbit& reference : reference_orbits()) {
    INFO(reference.name);
    const PeriodicOrbit orbit = shoot_beside(reference, {.finite_differences = true});
    CHECK(orbit.checks.residual >= 0.0);
    CHECK(orbit.checks.residual < 1e-12);
    CHECK(orbit.checks.liouville >= 0.0);
    CHECK(orbit.checks.liouville < 1e-10);
    REQUIRE(orbit.checks.finite_difference.has_value());
    const FiniteDifferenceCheck& differences = *orbit.checks.finite_difference;
    REQUIRE(differences.applicable);
    CHECK(differences.disagreement < std::max(1e-8, differences.error_estimate));
    CHECK(differences.error_estimate < 1e-6);  // otherwise the comparison would be meaningless
  }
}

TEST_CASE("single and multiple shooting find the same orbit for any number of nodes") {
  for (const ReferenceOrbit& reference : reference_orbits()) {
    const int n = reference.period;
    for (const int nodes : {1, n, 2 * n, 5 * n, n % 2 == 0 ? n / 2 : n}) {
      INFO(reference.name << " with " << nodes << " nodes");
      const PeriodicOrbit orbit = shoot_beside(reference, {.nodes = nodes});
      REQUIRE(orbit.converged());
      CHECK(orbit.nodes.size() == static_cast<std::size_t>(nodes));
      CHECK(orbit.states.size() == static_cast<std::size_t>(n));
      CHECK(distance(orbit.state, reference.state) < state_margin);
      // Within a stretch of many periods the errors grow like the motion's own: a stretch of 24 periods costs two digits.
      const double grown = nodes * 10 < n ? 100.0 : 1.0;
      CHECK(distance(orbit.multipliers.values, reference.multipliers) < grown * multiplier_tolerance);
      CHECK(orbit.impacts == reference.impacts);
      CHECK(orbit.checks.residual < 1e-12);
      CHECK(orbit.checks.liouville < 1e-10);
    }
  }
}

TEST_CASE("the general integrator finds the same orbits as the closed form and the regularised contact") {
  for (const ReferenceOrbit& reference : reference_orbits()) {
    if (reference.period > 2) continue;
    INFO(reference.name);
    ShootingOptions options;
    options.flow.kind = FlowKind::general;
    const PeriodicOrbit orbit = shoot_beside(reference, options);
    REQUIRE(orbit.converged());
    // At each entry into contact, the kink of (x - r)^(3/2) forces steps that meet the tolerance of 1e-13.
    CHECK(distance(orbit.state, reference.state) < 1e-10);
    CHECK(distance(orbit.multipliers.values, reference.multipliers) < 1e-8);
    CHECK(orbit.impacts == reference.impacts);
  }
}

TEST_CASE("at eta 0.925 the damped Hertz 1/1 orbit has the published state and multipliers") {
  const ReferenceOrbit& reference = reference_orbit("hertz-damped-1/1-0.925");
  const PeriodicOrbit orbit = shoot_beside(reference);
  // As printed in the issue, to half a unit of the last digit.
  CHECK(orbit.state[0] == Approx(2.049196636478).margin(5e-13).epsilon(0));
  CHECK(orbit.state[1] == Approx(1.428407518175).margin(5e-13).epsilon(0));
  CHECK(orbit.multipliers.values[0].real() == Approx(-0.94165004595).margin(5e-12).epsilon(0));
  CHECK(orbit.multipliers.values[1].real() == Approx(-0.42664904189).margin(5e-12).epsilon(0));
  CHECK(orbit.stable());
}
