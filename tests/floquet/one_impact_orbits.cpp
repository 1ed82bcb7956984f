// SPDX-License-Identifier: GPL-3.0-or-later
// Newton's law with one impact in n periods: the library against the closed form, beyond the published parameters.
#include <graze/floquet/attractor/search.hpp>
#include <graze/floquet/orbit/shooting.hpp>
#include <graze/lib/models/oscillator.hpp>

#include "support/checks.hpp"
#include "support/newton_oscillator.hpp"

#include <catch2/catch.hpp>

using namespace graze;
using namespace graze::support;

namespace {

/// Every k_r with every r (including 0 and below), at frequencies that are not simple fractions of each other.
std::vector<OneImpactParameters> grid() {
  std::vector<OneImpactParameters> list;
  for (const double k_r : {1.0, 0.8, 0.45, 0.1, 0.0})
    for (const double r : {2.0, 0.7, 0.0, -0.4, -1.5})
      for (const double eta : {0.63, 0.955, 1.2, 1.71, 2.06, 2.43, 2.75, 3.87}) list.push_back({0.05, 1.0, eta, r, k_r});
  list.push_back({0.02, 0.3, 2.1, 0.05, 0.9});
  list.push_back({0.3, 1.5, 1.9, -0.2, 0.95});
  return list;
}

/// The admissible orbits of the grid for n = 1 ... 5. An impact within 1e-3 of phase 0 is skipped: a start beside it would lie
/// inside the barrier. A flight closer than 1e-4 to a second impact is skipped too.
template <class Check> int for_each_admissible(const Check& check) {
  int count = 0;
  for (const OneImpactParameters& q : grid()) {
    for (int n = 1; n <= 5; ++n) {
      for (const OneImpactOrbit& orbit : one_impact_orbits(q, n)) {
        const double T = q.period();
        if (!orbit.admissible() || orbit.highest > -1e-4 || orbit.time < 1e-3 * T || orbit.time > (1.0 - 1e-3) * T) continue;
        INFO("b " << q.b << " xi " << q.xi << " eta " << q.eta << " r " << q.r << " k_r " << q.k_r << " n " << n << " speed "
                  << orbit.speed << " multiplier " << orbit.multipliers[0]);
        check(orbit);
        ++count;
      }
    }
  }
  return count;
}

PeriodicOrbit shoot_at(const OneImpactOrbit& orbit, double off) {
  const Vector start = orbit.states().front() + off * Vector(vector({-1.0, 0.3}));
  return shoot(newton_oscillator(), parameters_of(orbit.parameters), start, orbit.n);
}

/// Newton's method stops at a residual of about 1e-15, and the error of the orbit is that times |(M - I)^-1|. Near grazing, v
/// = 0, both M and the condition grow like 1/v.
double state_tolerance(const OneImpactOrbit& orbit) {
  const double along = std::abs(1.0 - orbit.multipliers[0]) * std::abs(1.0 - orbit.multipliers[1]);
  return 1e-13 * (1.0 + (1.0 + 1.0 / orbit.speed) / along);
}

}  // namespace

TEST_CASE("shooting agrees with the closed form of orbits with one impact in n periods") {
  const int count = for_each_admissible([](const OneImpactOrbit& closed) {
    const double off = 1e-6 * std::min(1.0, closed.speed);
    const PeriodicOrbit orbit = shoot_at(closed, off);
    CHECK(orbit.newton.status == NewtonStatus::converged);
    if (!orbit.converged()) return;
    CHECK(orbit.period == closed.n);
    CHECK(orbit.impacts == 1);
    CHECK(orbit.admissible == Admissibility::admissible);
    const std::vector<Vector> states = closed.states();
    for (int k = 0; k < closed.n; ++k) {
      const auto index = static_cast<std::size_t>(k);
      CHECK((orbit.states[index] - states[index]).lpNorm<Eigen::Infinity>() < state_tolerance(closed));
    }
    REQUIRE(orbit.events.size() == 1);
    // The impact time of the closed form may be one or more periods after the state at which the orbit begins.
    const double T = closed.parameters.period(), late = std::remainder(orbit.events[0].t - closed.time, T);
    CHECK(std::abs(late) < (1.0 + 1.0 / closed.speed) * state_tolerance(closed));
    CHECK(std::abs(orbit.events[0].normal_speed - closed.speed) < 10.0 * state_tolerance(closed));
    CHECK(std::abs(orbit.events[0].exit_speed - closed.parameters.k_r * closed.speed) < 10.0 * state_tolerance(closed));
  });
  CHECK(count > 90);
}

TEST_CASE("multipliers of orbits with one impact in n periods agree with trace and determinant") {
  for_each_admissible([](const OneImpactOrbit& closed) {
    const PeriodicOrbit orbit = shoot_at(closed, 0.0);
    if (!orbit.converged()) return;  // counted above
    const double size = 1.0 + std::abs(closed.multipliers[0]);
    // The large multiplier changes by 1/v per unit of speed.
    for (std::size_t i = 0; i < 2; ++i)
      CHECK(std::abs(orbit.multipliers.values[i] - closed.multipliers[i]) <
            size * (1e-10 + state_tolerance(closed) / closed.speed));
    CHECK(orbit.stable() == closed.stable());
    CHECK(orbit.checks.residual < 1e-12);
  });
}

TEST_CASE("with k_r 0 one multiplier is exactly zero and its exponent minus infinity") {
  int count = 0;
  for_each_admissible([&](const OneImpactOrbit& closed) {
    if (closed.parameters.k_r != 0.0) return;
    ++count;
    const PeriodicOrbit orbit = shoot_at(closed, 0.0);
    REQUIRE(orbit.converged());
    CHECK(orbit.multipliers.values[1] == 0.0);
    CHECK(orbit.multipliers.exponents[1] == -std::numeric_limits<double>::infinity());
    CHECK(orbit.multipliers.valid);
    CHECK(orbit.checks.liouville == -1.0);  // not applicable
  });
  CHECK(count > 5);
}

TEST_CASE("with k_r above 0 no multiplier is rounded to zero even for a slow impact") {
  // Just below the grazing of the 1/1 orbit, where the barrier lies at the amplitude of the impactless motion. There the
  // saltation matrix has an entry of 1/speed.
  OneImpactParameters q{0.05, 1.0, 0.7, 0.0, 0.8};
  int slow = 0;
  for (const double gap : {1e-2, 1e-4, 1e-6, 1e-8}) {
    q.r = impactless_amplitude(q) * (1.0 - gap);
    for (const OneImpactOrbit& closed : one_impact_orbits(q, 1)) {
      INFO("gap " << gap << " speed " << closed.speed << " multipliers " << closed.multipliers[0] << closed.multipliers[1]);
      const PeriodicOrbit orbit = shoot_at(closed, 0.0);
      REQUIRE(orbit.impacts == 1);
      const double product = std::abs(orbit.multipliers.values[0] * orbit.multipliers.values[1]);
      CHECK(product == Approx(q.k_r * q.k_r * std::exp(-2.0 * q.b * q.period())).epsilon(1e-12));
      CHECK(std::isfinite(orbit.multipliers.exponents[1]));
      slow += closed.speed < 1e-6 ? 1 : 0;
    }
  }
  CHECK(slow > 0);
}
