// SPDX-License-Identifier: GPL-3.0-or-later
// Derivatives along a family. The tangent of the continuation problem is compared with the quadruple-precision derivatives of
// data/reference.toml. The Jacobians of the defining equations are compared with central differences.
#include <graze/continuation/problems/orbit_problem.hpp>
#include <graze/continuation/trace/trace.hpp>

#include "support/checks.hpp"
#include "support/reference.hpp"
#include "support/two_mass_oscillator.hpp"
#include "support/van_der_pol_stop.hpp"

#include <catch2/catch.hpp>

using namespace graze;
using namespace graze::support;

namespace {

struct AtOrbit {
  PeriodicOrbit orbit;
  OrbitProblem problem;
  Vector u;
};

AtOrbit at_reference(const ReferenceOrbit& reference, std::size_t parameter, int nodes) {
  PeriodicOrbit orbit = shoot(reference.system, reference.parameters, reference.state, reference.period, {.nodes = nodes});
  REQUIRE(orbit.converged());
  OrbitProblem problem(reference.system, reference.parameters, reference.period, nodes, parameter, 1.0);
  Vector u = problem.pack(orbit.nodes, orbit.duration, reference.parameters[static_cast<Eigen::Index>(parameter)]);
  return {std::move(orbit), std::move(problem), std::move(u)};
}

}  // namespace

TEST_CASE("the tangent of every family agrees with the reference derivatives of the state") {
  for (const ReferenceDerivative& derivative : reference_derivatives()) {
    const ReferenceOrbit& reference = reference_orbit(derivative.orbit);
    const std::size_t parameter = parameter_index(reference.system.parameters, derivative.parameter);
    for (const int nodes : {1, reference.period, 6 * reference.period}) {
      INFO(derivative.orbit << " in " << derivative.parameter << ", " << nodes << " nodes");
      AtOrbit at = at_reference(reference, parameter, nodes);
      Vector residual;
      Matrix jacobian;
      REQUIRE(at.problem.residual(at.u, residual, &jacobian));
      const Eigen::Index size = residual.size();
      const Vector du = jacobian.leftCols(size).partialPivLu().solve(-jacobian.col(size));
      // The relative error of the Jacobian is 1e-13 (the tolerance of the flows); its inverse amplifies it some 10 times.
      const double scale = 1.0 + derivative.state_derivative.lpNorm<Eigen::Infinity>();
      CHECK((du.head(2) - derivative.state_derivative).lpNorm<Eigen::Infinity>() < 1e-10 * scale);
      // The tangent of the tracer has the same direction.
      const Vector tangent = tangent_at(at.problem.zero_problem(), at.u, at.problem.parameter_direction());
      REQUIRE(tangent.size() == at.u.size());
      CHECK((tangent.head(2) / tangent[size] - derivative.state_derivative).lpNorm<Eigen::Infinity>() < 1e-10 * scale);
      CHECK(tangent[size] > 0.0);
    }
  }
}

TEST_CASE("a section at another forcing phase gives the same family") {
  // Newton's law with nodes away from the impact; a simulation carries the state derivative back to phase 0.
  const ReferenceOrbit& reference = reference_orbit("newton-other-1/1-0.8");
  const std::size_t eta = parameter_index(reference.system.parameters, "eta");
  AtOrbit at = at_reference(reference, eta, 1);
  for (const double phase : {0.1, 0.4, 0.77}) {
    OrbitProblem moved = at.problem.with_section(phase);
    const auto u = at.problem.to_section(moved, at.u);
    INFO("section at " << phase);
    REQUIRE(u.has_value());
    Vector residual;
    REQUIRE(moved.residual(*u, residual, nullptr));
    CHECK(residual.lpNorm<Eigen::Infinity>() < 1e-13);
    const PeriodicOrbit orbit = moved.orbit(*u, {});
    CHECK((orbit.state - reference.state).lpNorm<Eigen::Infinity>() < 1e-13);
    CHECK(orbit.section_phase == phase);
    for (std::size_t i = 0; i < 2; ++i) CHECK(std::abs(orbit.multipliers.values[i] - reference.multipliers[i]) < 1e-12);
    REQUIRE(orbit.events.size() == 1);
    CHECK(orbit.events[0].t == Approx(reference.impact_times[0]).epsilon(1e-13));
    // Back to the original section.
    const auto back = moved.to_section(at.problem, *u);
    REQUIRE(back.has_value());
    CHECK((*back - at.u).lpNorm<Eigen::Infinity>() < 1e-13);
  }
}

TEST_CASE("the Jacobian of the orbit problem agrees with central differences for forced and autonomous systems") {
  const HybridSystem limit_cycle = van_der_pol_stop(), forced = two_mass_oscillator();
  const auto check = [](OrbitProblem problem, const Vector& u, const char* name) {
    const auto value = [&](const Vector& z) {
      Vector residual;
      REQUIRE(problem.residual(z, residual, nullptr));
      return residual;
    };
    Vector residual;
    Matrix jacobian;
    REQUIRE(problem.residual(u, residual, &jacobian));
    const JacobianCheck result = check_jacobian(value, u, jacobian, 1e-4);
    INFO(name << ": " << result.message);
    CHECK(result.agrees(1e-8));  // differences of the general flow: 1e-13 / 1e-4, amplified by the motion
  };
  for (std::size_t parameter = 0; parameter < limit_cycle.parameters.size(); ++parameter) {
    const Vector p = parameters(limit_cycle, {{"k_r", 0.8}});
    const Trajectory run = simulate(limit_cycle, p, 0.0, Vector{{0.1, 0.0}}, {.t_end = 40.0});
    const double duration = run.events.back().t - run.events[run.events.size() - 2].t;
    const PeriodicOrbit orbit = shoot(limit_cycle, p, std::vector<Vector>{run.x}, 1, {.nodes = 2}, duration);
    REQUIRE(orbit.converged());
    OrbitProblem problem(limit_cycle, p, 1, 2, parameter, 1.0);
    problem.equations().set_phase_reference(orbit.state);
    const Vector u = problem.pack(orbit.nodes, orbit.duration, p[static_cast<Eigen::Index>(parameter)]);
    check(std::move(problem), u, limit_cycle.parameters[parameter].name.c_str());
  }
  for (std::size_t parameter = 0; parameter < forced.parameters.size(); ++parameter) {
    const Vector p = parameters(forced, {{"xi", 2.0}, {"eta", 0.7}, {"k_r", 0.7}});
    OrbitProblem problem(forced, p, 1, 1, parameter, 1.0);
    // Any state is suitable if its period is not close to grazing.
    const Vector u = problem.pack({Vector{{0.2, 1.0, 0.1, 0.3}}}, 0.0, p[static_cast<Eigen::Index>(parameter)]);
    check(std::move(problem), u, forced.parameters[parameter].name.c_str());
  }
}

TEST_CASE("the cyclic matrix is singular at each multiplier and nowhere else") {
  for (const char* name : {"hertz-damped-1/2-0.91", "newton-elastic-4/4-0.744", "beam-linear-cubic-2/1-0.6"}) {
    const ReferenceOrbit& reference = reference_orbit(name);
    for (const int nodes : {1, reference.period, 3 * reference.period}) {
      AtOrbit at = at_reference(reference, 3, nodes);
      REQUIRE(at.problem.evaluate(at.u, {.sensitivity = Sensitivity::state}));
      const auto smallest = [&](std::complex<double> sigma) {
        // The smallest singular value, up to the square root of the size.
        return 1.0 / at.problem.cyclic(at.u, sigma).inverse().norm();
      };
      INFO(name << ", " << nodes << " nodes");
      for (const auto& mu : reference.multipliers) {
        CHECK(smallest(mu) < 1e-10);
        CHECK(smallest(mu + 0.01) > 1e-6);
      }
      CHECK(smallest({0.3, 0.9}) > 1e-3);
    }
  }
}
