// SPDX-License-Identifier: GPL-3.0-or-later
// The closed form of the linear oscillator, against an independent integration in long double.
#include "support/checks.hpp"
#include "support/extrapolation.hpp"

#include <graze/lib/flow/flow.hpp>
#include <graze/lib/models/oscillator.hpp>

#include <string>

using namespace graze;
using namespace graze::support;

namespace {

/// The oscillator with the elastic stop: mode 0 is the free flight, mode 1 the contact. A distant `r` keeps them apart.
HybridSystem elastic() { return make_oscillator("linear", "linear"); }

Segment carry_alone(const HybridSystem& system, std::size_t mode, const Vector& p, double t0, double t1, const Vector& x0,
                    FlowKind kind = FlowKind::automatic) {
  std::vector<std::size_t> active = all_parameters(system);
  active.erase(active.begin() + 1);  // beta is not in the closed form
  Flow flow = make_flow(system, mode, p, active, {.kind = kind, .max_steps = 1000000});
  Segment segment;
  flow.carry({t0, t1, Sensitivity::state_and_parameters}, x0, segment);
  return segment;
}

Vector by_extrapolation(const Vector& p, bool contact, double t0, double t1, const Vector& x0) {
  enum { b, beta, xi, eta, r, k_S };
  const auto field = [&](long double t, const LongState<2>& z, LongState<2>& dz) {
    dz[0] = z[1];
    dz[1] = p[xi] * std::cos(static_cast<long double>(p[eta]) * t) - 2.0L * p[b] * z[1] - z[0];
    if (contact) dz[1] -= p[k_S] * (z[0] - p[r]);
  };
  const LongState<2> end = extrapolate<2>(field, t0, t1, {x0[0], x0[1]});
  return vector({static_cast<double>(end[0]), static_cast<double>(end[1])});
}

}  // namespace

TEST_CASE("the closed form gives the motion: undamped, underdamped, critical and overdamped, in flight and in contact") {
  const HybridSystem system = elastic();
  Random random(11);
  for (const double b : {0.0, 0.05, 0.3, 0.999999, 1.0, 1.000001, 1.7, 4.0}) {
    for (const bool contact : {false, true}) {
      for (int i = 0; i < 5; ++i) {
        const double t0 = random(-3.0, 10.0), t1 = t0 + random(0.1, 12.0);
        const Vector p = parameters(system, {{"b", b},
                                             {"xi", random(0.2, 2.0)},
                                             {"eta", random(0.3, 0.9)},
                                             {"r", contact ? -100.0 : 100.0},
                                             {"k_S", random(10.0, 40.0)}});
        const double middle = contact ? -100.0 * p[5] / (1.0 + p[5]) : 0.0;
        const Vector x0 = vector({middle + random(-2.0, 2.0), random(-2.0, 2.0)});
        const Segment segment = carry_alone(system, contact, p, t0, t1, x0);
        const Vector exact = by_extrapolation(p, contact, t0, t1, x0);
        INFO("b = " << b << (contact ? " in contact" : " in flight"));
        REQUIRE(segment.end == FlowEnd::time);
        REQUIRE(segment.t1 == t1);
        // A dozen rounding errors of terms of the size of the motion. Contact at r = -100 has terms of size 100.
        REQUIRE((segment.x1 - exact).norm() < 2e-15 * (5.0 + exact.norm() + (contact ? 1000.0 : 0.0)));
      }
    }
  }
}

TEST_CASE("the derivatives of the closed form in the state and in every coefficient agree with differences at any damping") {
  const HybridSystem system = elastic();
  for (const double b : {0.05, 0.6, 0.9995, 1.0, 1.0005, 1.7}) {
    for (const bool contact : {false, true}) {
      const Vector p = parameters(
          system, {{"b", b}, {"xi", 1.1}, {"eta", 0.8}, {"r", contact ? -3.0 : 9.0}, {"k_S", contact ? 0.7 * b * b : 25.0}});
      const Vector x0 = vector({0.4, -0.9});
      const double t0 = 0.7, t1 = 5.2;
      const Segment segment = carry_alone(system, contact, p, t0, t1, x0);
      REQUIRE(segment.end == FlowEnd::time);
      const auto end = [&](const Vector& x) { return carry_alone(system, contact, p, t0, t1, x).x1; };
      const JacobianCheck in_x = check_jacobian(end, x0, segment.Phi);
      INFO("b = " << b << (contact ? " in contact: " : " in flight: ") << in_x.message);
      REQUIRE(in_x.agrees(1e-11));  // linear in x0: the differences are exact up to rounding, 1e-15/1e-3
      const std::vector<Eigen::Index> held = {0, 2, 3, 4, 5};
      const auto end_at = [&](const Vector& q) {
        Vector moved = p;
        for (std::size_t i = 0; i < held.size(); ++i) moved[held[i]] = q[static_cast<Eigen::Index>(i)];
        return carry_alone(system, contact, moved, t0, t1, x0).x1;
      };
      const JacobianCheck in_p = check_jacobian(end_at, p(held), segment.Psi, 5e-4);
      INFO(in_p.message);
      // Truncation h^4 (t1 - t0)^5 / 120 = 1e-12, rounding 1e-15/5e-4, times the size of the motion.
      REQUIRE(in_p.agrees(2e-10));
    }
  }
}

TEST_CASE("a long flight of an overdamped oscillator stays finite") {
  // cosh overflows where exp(-b s) vanishes: their product must be formed without either factor.
  const HybridSystem system = elastic();
  const Vector p = parameters(system, {{"b", 30.0}, {"eta", 0.5}, {"r", 5.0}});
  const Segment segment = carry_alone(system, 0, p, 0.0, 1000.0, vector({1.0, 0.0}));
  REQUIRE(segment.end == FlowEnd::time);
  REQUIRE(segment.x1.allFinite());
  REQUIRE(segment.Phi.allFinite());
  REQUIRE(segment.Psi.allFinite());
  const Segment general = carry_alone(system, 0, p, 0.0, 1000.0, vector({1.0, 0.0}), FlowKind::general);
  REQUIRE((segment.x1 - general.x1).norm() < 1e-11);  // the error of the general integrator: thousands of steps at 1e-13
  REQUIRE((segment.Psi - general.Psi).norm() < 1e-8);
}

TEST_CASE("a flight that takes too many steps to search for events fails") {
  const HybridSystem system = elastic();
  Vector p = default_parameters(system.parameters);
  p[static_cast<Eigen::Index>(parameter_index(system.parameters, "eta"))] = 1e-320;
  Flow flow = make_flow(system, 0, p, {}, {.max_steps = 1000});
  Segment segment;
  flow.carry({0.0, 1e300, Sensitivity::none}, Vector{{0.0, 0.0}}, segment);
  CHECK(segment.end == FlowEnd::failed);
  CHECK(segment.evaluations == 1000);
}

TEST_CASE("an overdamped transient keeps the accuracy of its decayed part") {
  // exp(-b s) cosh(q s) - b exp(-b s) sinh(q s)/q cancels down to the fast mode. Its error is the rounding of the slow mode.
  const HybridSystem system = elastic();
  const Vector p = parameters(system, {{"b", 5.0}, {"xi", 0.0}, {"r", 50.0}});
  const double slow = 5.0 - std::sqrt(24.0), fast = 5.0 + std::sqrt(24.0), s = 3.0;
  const Segment segment = carry_alone(system, 0, p, 0.0, s, vector({1.0, 0.0}));
  const double A = fast / (fast - slow), B = -slow / (fast - slow);
  REQUIRE(segment.x1[0] == Approx(A * std::exp(-slow * s) + B * std::exp(-fast * s)).epsilon(1e-15));
  REQUIRE(segment.x1[1] == Approx(-slow * A * std::exp(-slow * s) - fast * B * std::exp(-fast * s)).epsilon(1e-14));
}

TEST_CASE("the time of a crossing agrees with the closed form to rounding") {
  // Unforced and undamped: x = sin t reaches r at asin r.
  const HybridSystem system = make_oscillator("linear", "newton");
  for (const double r : {1e-9, 0.1, 0.5, 0.9, 0.999999}) {
    const Vector p = parameters(system, {{"b", 0.0}, {"xi", 0.0}, {"r", r}});
    Flow flow = make_flow(system, 0, p, {});
    Segment segment;
    flow.carry({0.0, 3.0, Sensitivity::none}, vector({0.0, 1.0}), segment);
    REQUIRE(segment.end == FlowEnd::event);
    REQUIRE(segment.x1[0] == r);
    // An error of 2e-16 in x moves the time by (error) / (speed).
    REQUIRE(std::abs(segment.t1 - std::asin(r)) < 4e-16 * (1.0 + 1.0 / std::sqrt(1.0 - r * r)));
    REQUIRE(std::abs(segment.x1[1] - std::sqrt(1.0 - r * r)) < 4e-16 * (1.0 + 1.0 / std::sqrt(1.0 - r * r)));
  }
}

TEST_CASE("make_flow returns the closed form or the series where they apply and reports the kind") {
  const HybridSystem linear = elastic(), hertz = make_oscillator("linear", "hertz"),
                     beam = make_oscillator("cantilever", "linear");
  const auto kind = [](const HybridSystem& system, std::size_t mode,
                       std::initializer_list<std::pair<const char*, double>> set = {}, std::vector<std::size_t> active = {},
                       FlowKind wanted = FlowKind::automatic) {
    return std::string(make_flow(system, mode, parameters(system, set), active, {.kind = wanted}).kind());
  };
  REQUIRE(kind(linear, 0) == "closed form");
  REQUIRE(kind(linear, 1) == "closed form");
  REQUIRE(kind(hertz, 0) == "closed form");
  REQUIRE(kind(hertz, 1) == "regularised Hertz contact");
  REQUIRE(kind(beam, 0) == "Taylor series");
  REQUIRE(kind(beam, 1) == "Taylor series");
  REQUIRE(kind(beam, 0, {}, {}, FlowKind::general) == "general");
  REQUIRE(kind(make_oscillator("cantilever", "hertz"), 1) == "regularised Hertz contact");
  REQUIRE(kind(linear, 0, {}, {}, FlowKind::general) == "general");
  // The closed form has no derivative in beta at beta = 0 and no undamped resonance.
  REQUIRE(kind(linear, 0, {}, {oscillator_parameter::beta}) == "general");
  REQUIRE(kind(linear, 0, {{"b", 0.0}, {"eta", 1.0}}) == "general");
  REQUIRE(kind(linear, 0, {{"b", 0.0}, {"eta", 1.0}, {"xi", 0.0}}) == "closed form");
}
