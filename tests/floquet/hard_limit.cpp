// SPDX-License-Identifier: GPL-3.0-or-later
// The hard limit of Hertz contact: restitution against quadrature in extended precision, orbits against the closed form of
// Newton's law, orders of convergence.
#include <graze/floquet/attractor/settle.hpp>
#include <graze/floquet/verify/hard_limit.hpp>

#include "support/checks.hpp"
#include "support/extrapolation.hpp"
#include "support/one_impact_orbit.hpp"

#include <catch2/catch.hpp>

#include <cmath>

using namespace graze;
using namespace graze::support;
using Catch::Matchers::Contains;

namespace {

Vector hertz(double eta, double b_H) {
  Vector p = default_parameters(make_oscillator("linear", "hertz").parameters);
  p[oscillator_parameter::eta] = eta;
  p[oscillator_parameter::law + 1] = b_H;
  return p;
}

PeriodicOrbit settled_orbit(const HybridSystem& system, const Vector& p, int period) {
  const Settled settled = settle(system, p, Vector::Zero(2), {.periods = 2000});
  PeriodicOrbit orbit = shoot(system, p, settled.state, period);
  REQUIRE(orbit.converged());
  REQUIRE(orbit.period == period);
  return orbit;
}

/// The orbit of the limit, against the closed form with this k_r.
void compare_with_closed_form(const HardLimit& hard, double eta, double k_r) {
  OneImpactParameters q;
  q.eta = eta;
  q.r = 2.0;
  q.k_r = k_r;
  double nearest = 1.0;
  for (const OneImpactOrbit& candidate : one_impact_orbits(q, hard.limit.period))
    for (const Vector& state : candidate.states()) nearest = std::min(nearest, (state - hard.limit.state).norm());
  CHECK(nearest < 1e-11);  // the error of Newton's method is 1e-13
}

}  // namespace

TEST_CASE("restitution in the limit satisfies the energy balance of the contact") {
  // v dv = -(1 + w v) dY from v = 1 to -e; Y is the potential of the contact. It must end at its initial value, Y = 0. This
  // check has no logarithm.
  for (const double w : {1e-6, 1e-3, 0.05, 0.099, 0.101, 0.5, 1.0, 3.0, 10.0, 19.0}) {
    const double e = limit_restitution(w);
    const auto field = [w](long double v, const LongState<1>&, LongState<1>& dY) { dY[0] = -v / (1.0L + w * v); };
    const long double Y = extrapolate<1>(field, 1.0L, -static_cast<long double>(e), {0.0L})[0];
    INFO(w << " " << e);
    // dY/de at the end is e / (1 - e w): the check bounds the error of e itself. The logarithm in the equation of e loses a
    // digit at w = 0.1.
    CHECK(std::abs(Y) * (1.0L - e * w) / e < 2e-15L * e);
    const double h = 1e-4 * std::min(w, 1.0);
    const auto u = [](double x) { return limit_restitution(x) * x; };
    // Central differences have a truncation error of 1e-8, and some rounding (of u, below 1) over h.
    CHECK(limit_restitution_slope(w) == Approx((u(w + h) - u(w - h)) / (2.0 * h)).epsilon(1e-7).margin(1e-15 / h));
  }
  CHECK(limit_restitution(0.0) == 1.0);
  CHECK(limit_restitution_slope(0.0) == 1.0);
  CHECK(limit_restitution(1e-5) == Approx(1.0 - 2.0 / 3.0 * 1e-5).epsilon(1e-9));
  CHECK(limit_restitution(21.0) * 21.0 < 1.0);
  CHECK(limit_restitution(20.0 + 1e-9) == Approx(limit_restitution(20.0 - 1e-9)).epsilon(1e-9));
  CHECK_THROWS_WITH(limit_restitution(-0.1), Contains("-0.1; allowed is a finite number >= 0"));
}

TEST_CASE("the rigid stop of the limit has correct derivatives") {
  const HybridSystem system = make_hard_limit(oscillator_kind("linear"));
  for (const double b_H : {1e-3, 0.1, 2.0}) {
    const Vector p = parameters(system, {{"b_H", b_H}, {"eta", 0.9}});
    CHECK_THAT(check_event(system, 0, 0.7, Vector{{2.0, 1.3}}, p), all_agree());
  }
}

TEST_CASE("extrapolation removes powers of epsilon and estimates its remaining error") {
  const double ratio = std::pow(10.0, -0.4);
  std::vector<Vector> cubic, rough;
  for (int j = 0; j < 5; ++j) {
    const double eps = std::pow(ratio, j);
    cubic.push_back(Vector{{1.0 + 2.0 * eps - 3.0 * eps * eps + eps * eps * eps, 4.0 - eps}});
    rough.push_back(Vector{{1.0 + std::exp(eps)}});
  }
  const Extrapolated exact = extrapolate(cubic, ratio);
  CHECK((exact.value - Vector{{1.0, 4.0}}).norm() < 1e-13);
  CHECK(exact.error < 1e-13);
  const Extrapolated near = extrapolate(rough, ratio);
  CHECK(std::abs(near.value[0] - 2.0) > 1e-6);
  CHECK(std::abs(near.value[0] - 2.0) < near.error);
}

TEST_CASE("undamped Hertz contact tends to Newton's law with k_r = 1 with order 2/5") {
  const OscillatorKind& kind = oscillator_kind("linear");
  const Vector p = hertz(0.95, 0.0);
  const HardLimit hard = hard_limit(kind, p, settled_orbit(make_oscillator("linear", "hertz"), p, 1));
  REQUIRE(hard.stop == HardLimitStop::done);
  REQUIRE(hard.steps.size() == 7);
  CHECK(hard.newton_restitution == 1.0);
  CHECK(hard.restitution.empty());
  compare_with_closed_form(hard, 0.95, 1.0);
  // Per decade of stiffness the distance of the orders from 2/5 falls by a factor 2.5; the test requires less.
  for (std::size_t k = 2; k < hard.steps.size(); ++k)
    CHECK(std::abs(hard.steps[k].order - 0.4) < 0.6 * std::abs(hard.steps[k - 1].order - 0.4));
  for (const OrbitCheck& check : hard.checks) {
    INFO(check.name << " " << check.disagreement << " " << check.limit);
    CHECK(check.applicable());
    CHECK(check.passes());
    CHECK(check.limit < (check.name == "hard limit: order" ? 2e-3 : 1e-9));
  }
  // The same limit, computed with Newton's law.
  const HybridSystem newton = make_oscillator("linear", "newton");
  Vector rigid = default_parameters(newton.parameters);
  rigid[oscillator_parameter::eta] = 0.95;
  const HardLimit back = hard_limit(kind, p, shoot(newton, rigid, hard.limit.states, 1));
  REQUIRE(back.stop == HardLimitStop::done);
  CHECK(back.steps.size() == 7);
  CHECK((back.limit.state - hard.limit.state).norm() < 1e-12);
}

TEST_CASE("damped Hertz contact tends to a rigid stop of restitution e(b_H v)") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  for (const auto& [eta, period] : {std::pair{0.95, 1}, {0.85, 2}}) {
    const Vector p = hertz(eta, 0.1);
    const PeriodicOrbit orbit = settled_orbit(system, p, period);
    const HardLimit hard = hard_limit(oscillator_kind("linear"), p, orbit);
    REQUIRE(hard.stop == HardLimitStop::done);
    for (const OrbitCheck& check : hard.checks) {
      INFO(check.name << " " << check.disagreement << " " << check.limit);
      CHECK(check.applicable());
      CHECK(check.passes());
    }
    CHECK(hard.newton_restitution < 0.95);
    compare_with_closed_form(hard, eta, hard.newton_restitution);
    REQUIRE(hard.restitution.size() == 48);
    for (const RestitutionPoint& point : hard.restitution) {
      INFO(point.speed);
      // b_H v (1 + e) = ln((1 + b_H v) / (1 - b_H e v)).
      const double w = 0.1 * point.speed, e = point.closed_form;
      CHECK(w * (1.0 + e) == Approx(std::log((1.0 + w) / (1.0 - e * w))).epsilon(1e-11));
      CHECK(point.extrapolated == Approx(e).epsilon(1e-9));
      CHECK(std::abs(point.stiff - e) < 1e-5);
      CHECK(std::abs(point.computed - e) > 1e-4);  // at k_H = 100 the limit is not reached
    }
    // The contact of the orbit itself lies on the curve.
    const auto leave =
        std::find_if(orbit.events.begin(), orbit.events.end(), [](const auto& e) { return e.kind == EventKind::leave; });
    const auto enter =
        std::find_if(orbit.events.begin(), orbit.events.end(), [](const auto& e) { return e.kind == EventKind::enter; });
    const double e = contact_restitution(system, p, enter->t, enter->normal_speed);
    CHECK(e == Approx(leave->normal_speed / enter->normal_speed).epsilon(1e-11));
  }
}

TEST_CASE("an orbit that cannot be continued to the stiff contact is reported as lost") {
  // Near k_H = 9000 a free maximum of this 1/2 orbit reaches the barrier. At this stiffness the orbit ends there.
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector p = hertz(0.8247, 0.1);
  const HardLimit hard = hard_limit(oscillator_kind("linear"), p, settled_orbit(system, p, 2));
  CHECK(hard.stop == HardLimitStop::lost_stiff);
  CHECK(hard.checks.empty());
  CHECK_THAT(std::string(hard_limit_stop_text(hard.stop)), Contains("could not be followed"));
}

TEST_CASE("hard limit: options and speeds out of range") {
  const Vector p = hertz(0.95, 0.1);
  const HybridSystem system = make_oscillator("linear", "hertz");
  const PeriodicOrbit orbit = shoot(system, p, Vector{{2.0, 1.5}}, 1);
  CHECK_THROWS_WITH(hard_limit(oscillator_kind("linear"), p, orbit, {.softest = 1e3, .stiffest = 1e5}),
                    Contains("four decades at least"));
  CHECK_THROWS_WITH(hard_limit(oscillator_kind("linear"), p, orbit, {.speeds = 0}), Contains("speeds is 0"));
  CHECK_THROWS_WITH(contact_restitution(system, p, 0.0, 0.0), Contains("speed of entry is 0"));
  // A barrier far on the other side of the equilibrium: the mass is pressed into a soft contact and stays there.
  Vector soft = p;
  soft[oscillator_parameter::b] = 0.3;
  soft[oscillator_parameter::r] = -2.0;
  soft[oscillator_parameter::law] = 1e-3;
  CHECK(std::isnan(contact_restitution(system, soft, 0.0, 0.1)));
}
