// SPDX-License-Identifier: GPL-3.0-or-later
// Orbits in the coordinates of their signature: the same orbits as by shooting, and smooth where shooting is not.
#include <graze/floquet/orbit/shooting.hpp>
#include <graze/floquet/orbit/shooting_equations.hpp>
#include <graze/floquet/orbit/signature_equations.hpp>
#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/system/jacobian_check.hpp>

#include "support/checks.hpp"
#include "support/reference.hpp"

#include <catch2/catch.hpp>

using namespace graze;
using namespace graze::support;

namespace {

Vector unknowns_of(const PeriodicOrbit& orbit) {
  const Eigen::Index block = orbit.state.size() + 1;
  Vector u(block * std::ssize(orbit.events));
  for (Eigen::Index k = 0; k < std::ssize(orbit.events); ++k) {
    u[k * block] = orbit.events[static_cast<std::size_t>(k)].t;
    u.segment(k * block + 1, block - 1) = orbit.events[static_cast<std::size_t>(k)].x_minus;
  }
  return u;
}

/// Jacobian in all unknowns and the parameter, against central differences.
JacobianCheck check(SignatureEquations& equations, const Vector& u, std::size_t parameter) {
  const Vector p = equations.parameters();
  const auto index = static_cast<Eigen::Index>(parameter);
  Vector residual, all(u.size() + 1);
  Matrix jacobian;
  REQUIRE(equations.evaluate(u, residual, &jacobian));
  all << u, p[index];
  const auto f = [&](const Vector& at) {
    Vector moved = p, out;
    moved[index] = at[u.size()];
    equations.set_parameters(moved);
    equations.evaluate(at.head(u.size()), out, nullptr);
    return out;
  };
  const JacobianCheck result = check_jacobian(f, all, jacobian, 1e-4);
  equations.set_parameters(p);
  return result;
}

/// The impactless orbit at its grazing (DESIGN section 2), with its touch as an event of zero speed.
struct AtGrazing {
  HybridSystem system = make_oscillator("linear", "newton");
  Vector p = parameters(system, {{"b", 0.05}, {"xi", 1.0}, {"r", 2.0}, {"k_r", 0.8}});
  Vector u;
  AtGrazing() {
    using namespace oscillator_parameter;
    p[eta] = std::sqrt((1.99 - std::sqrt(1.99 * 1.99 - 3.0)) / 2.0);
    const Vector start = steady_response(p);
    // x = A cos(eta tau - phase): the touch is where the cosine is 1.
    const double phase = std::atan2(start[1] / p[eta], start[0]);
    u = Vector{{phase / p[eta], 2.0, 0.0}};
  }
};

}  // namespace

TEST_CASE("signature equations: the reference orbits with hard impacts are roots with the same multipliers") {
  int seen = 0;
  for (const ReferenceOrbit& reference : reference_orbits()) {
    if (reference.system.events.front().kind != EventKind::impact || reference.period_doubling) continue;
    INFO(reference.name);
    ++seen;
    const PeriodicOrbit orbit = shoot(reference.system, reference.parameters, reference.state, reference.period);
    REQUIRE(orbit.converged());
    for (std::size_t parameter = 0; parameter < reference.system.parameters.size(); ++parameter) {
      INFO(reference.system.parameters[parameter].name);
      const ParameterInfo& info = reference.system.parameters[parameter];
      const double value = reference.parameters[static_cast<Eigen::Index>(parameter)];
      if (value + 1e-3 > info.upper || value - 1e-3 < info.lower) continue;  // no room for differences
      SignatureEquations equations(reference.system, reference.parameters, orbit.period, orbit.signature.events, {parameter});
      const Vector u = unknowns_of(orbit);
      Vector residual;
      REQUIRE(equations.evaluate(u, residual, nullptr));
      CHECK(residual.lpNorm<Eigen::Infinity>() < 1e-11);  // the error of the flows is 1e-13, amplified by long flights
      CHECK_FALSE(equations.violation(u));
      const JacobianCheck jacobian = check(equations, u, parameter);
      INFO(jacobian.message);
      CHECK(jacobian.agrees(1e-8));
      double liouville = -1.0;
      const FloquetMultipliers mu = multipliers(equations.monodromy(u, &liouville), equations.duration());
      CHECK(liouville < 1e-11);
      CHECK(liouville >= 0.0);
      REQUIRE(mu.values.size() == orbit.multipliers.values.size());
      for (std::size_t i = 0; i < mu.values.size(); ++i)
        CHECK(std::abs(mu.values[i] - orbit.multipliers.values[i]) < 1e-9 * (1.0 + std::abs(mu.values[i])));
      const std::vector<Vector> states = equations.states_at(u, {0.0, 0.3 * equations.duration()});
      CHECK((states[0] - orbit.state).norm() < 1e-11);
    }
  }
  CHECK(seen >= 8);
}

TEST_CASE("orbit equations with several free parameters have the columns of each") {
  const ReferenceOrbit& reference = reference_orbit("newton-elastic-4/4-0.744");
  const PeriodicOrbit orbit = shoot(reference.system, reference.parameters, reference.state, reference.period);
  const std::vector<std::size_t> free{oscillator_parameter::r, oscillator_parameter::eta, oscillator_parameter::law};
  const auto by_events = [&](const std::vector<std::size_t>& list) {
    SignatureEquations equations(reference.system, reference.parameters, orbit.period, orbit.signature.events, list);
    Vector residual;
    Matrix jacobian;
    REQUIRE(equations.evaluate(unknowns_of(orbit), residual, &jacobian));
    return jacobian;
  };
  const auto in_states = [&](const std::vector<std::size_t>& list) {
    ShootingEquations equations(reference.system, reference.parameters, orbit.period, 0, list);
    Vector u(equations.unknowns());
    for (int j = 0; j < equations.nodes(); ++j) u.segment(2 * j, 2) = orbit.states[static_cast<std::size_t>(j)];
    REQUIRE(equations.evaluate(u, {.sensitivity = Sensitivity::state_and_parameters}));
    Matrix jacobian;
    equations.jacobian(jacobian);
    return jacobian;
  };
  const auto compare = [&](const auto& jacobian_for) {
    const Matrix all = jacobian_for(free);
    REQUIRE(all.cols() == all.rows() + 3);
    for (std::size_t k = 0; k < free.size(); ++k) {
      const Matrix one = jacobian_for(std::vector<std::size_t>{free[k]});
      CHECK((all.leftCols(all.rows()) - one.leftCols(all.rows())).lpNorm<Eigen::Infinity>() == 0.0);
      CHECK((all.col(all.rows() + static_cast<Eigen::Index>(k)) - one.col(all.rows())).lpNorm<Eigen::Infinity>() < 1e-12);
    }
  };
  compare(by_events);
  compare(in_states);
}

TEST_CASE("signature equations: smooth through zero speed") {
  AtGrazing at;
  const std::size_t impact = 0;
  REQUIRE(at.system.events[impact].kind == EventKind::impact);
  for (const std::size_t parameter :
       {std::size_t(oscillator_parameter::eta), std::size_t(oscillator_parameter::r), std::size_t(oscillator_parameter::law)}) {
    SignatureEquations equations(at.system, at.p, 1, {impact}, {parameter});
    Vector residual;
    REQUIRE(equations.evaluate(at.u, residual, nullptr));
    CHECK(residual.lpNorm<Eigen::Infinity>() < 1e-13);
    CHECK(std::abs(equations.speed(at.u, 0)) < 1e-14);
    const JacobianCheck jacobian = check(equations, at.u, parameter);
    INFO(jacobian.message);
    CHECK(jacobian.agrees(1e-9));
  }
  SignatureEquations equations(at.system, at.p, 1, {impact}, {oscillator_parameter::eta});
  const auto lost = equations.violation(at.u);
  REQUIRE(lost);
  CHECK(lost->lost);
  // The gradient of the speed: one along the velocity, and along the time the change of the acceleration.
  const Vector gradient = equations.speed_gradient(at.u, 0);
  CHECK(gradient[2] == Approx(1.0));
}

TEST_CASE("signature equations: a flight through the barrier is reported") {
  // Newton's 2/2 orbit with one of its impacts missing from the signature: it passes through the barrier there.
  const ReferenceOrbit& reference = reference_orbit("newton-elastic-4/4-0.744");
  const PeriodicOrbit orbit = shoot(reference.system, reference.parameters, reference.state, reference.period);
  REQUIRE(orbit.events.size() == 4);
  SignatureEquations equations(reference.system, reference.parameters, orbit.period,
                               {orbit.signature.events[0], orbit.signature.events[1]}, {oscillator_parameter::eta});
  const auto gained = equations.violation(unknowns_of(orbit).head(6));
  REQUIRE(gained);
  CHECK_FALSE(gained->lost);
  CHECK(gained->event == 1);
}

TEST_CASE("signature equations: misuse is refused in one sentence") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = default_parameters(system.parameters);
  CHECK_THROWS_WITH(SignatureEquations(system, p, 1, {}, {0}), Catch::Contains("without events"));
  CHECK_THROWS_WITH(SignatureEquations(system, p, 1, {0}, {}), Catch::Contains("at least one"));
  const HybridSystem soft = make_oscillator("linear", "hertz");
  CHECK_THROWS_WITH(SignatureEquations(soft, default_parameters(soft.parameters), 1, {0, 0}, {0}),
                    Catch::Contains("does not lead to the mode"));
}
