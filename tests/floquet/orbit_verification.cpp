// SPDX-License-Identifier: GPL-3.0-or-later
// verify_orbit: all checks agree for a correct orbit. Each check fails if its own quantity is changed.
#include <graze/floquet/attractor/settle.hpp>
#include <graze/floquet/verify/orbit_verification.hpp>
#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/numerics/decompositions.hpp>

#include "support/van_der_pol_stop.hpp"

#include <catch2/catch.hpp>

#include <cmath>

using namespace graze;
using Catch::Matchers::Contains;

namespace {

struct Case {
  HybridSystem system;
  PeriodicOrbit orbit;
};

Case settled_orbit(const char* law, double eta, double b_H = 0.1) {
  Case out;
  out.system = make_oscillator("linear", law);
  Vector p = default_parameters(out.system.parameters);
  p[oscillator_parameter::eta] = eta;
  if (std::string(law) == "hertz") p[oscillator_parameter::law + 1] = b_H;
  const Settled settled = settle(out.system, p, Vector::Zero(2), {.periods = 2000});
  REQUIRE(settled.suspected_period > 0);
  out.orbit = shoot(out.system, p, settled.state, settled.suspected_period);
  REQUIRE(out.orbit.converged());
  return out;
}

const OrbitCheck& check_of(const VerifiedOrbit& verified, const std::string& name) {
  for (const OrbitCheck& check : verified.checks)
    if (check.name == name) return check;
  FAIL("there is no check " << name);
  return verified.checks.front();
}

}  // namespace

TEST_CASE("eigenvector condition: a rotation, a triangular matrix, a defective one") {
  CHECK(eigenvector_condition((Matrix(2, 2) << 0.6, -0.8, 0.8, 0.6).finished()) == Approx(1.0));
  // Eigenvectors (1, 0) and (1, 1) / sqrt 2, at 45 degrees: cot(22.5 degrees).
  CHECK(eigenvector_condition((Matrix(2, 2) << 1.0, 1.0, 0.0, 2.0).finished()) == Approx(1.0 + std::sqrt(2.0)));
  CHECK(eigenvector_condition((Matrix(2, 2) << 1.0, 1.0, 0.0, 1.0).finished()) > 1e7);
}

TEST_CASE("all checks agree on a node, on a focus, and on an impactless orbit") {
  for (const auto& [law, eta, node] :
       {std::tuple{"hertz", 0.925, true}, {"hertz", 0.85, false}, {"newton", 0.9, false}, {"hertz", 0.68, false}}) {
    const auto [system, orbit] = settled_orbit(law, eta);
    INFO(law << " " << eta);
    CHECK((std::abs(orbit.multipliers.values[0].imag()) < 1e-12) == node);
    const VerifiedOrbit verified = verify_orbit(system, orbit);
    CHECK(verified.agrees());
    CHECK(verified.checks.size() == 9);
    for (const OrbitCheck& check : verified.checks) {
      INFO(check.name << " " << check.disagreement << " " << check.limit);
      CHECK(check.applicable());
      CHECK(check.passes());
      CHECK(check.limit < 1e-3);
    }
    // The aligned tangent vectors of a node no longer rotate: the only error is rounding.
    if (node) CHECK(check_of(verified, "exponents").disagreement < bound::exponent);
  }
}

TEST_CASE("changed values are detected") {
  const Case settled = settled_orbit("hertz", 0.925);
  const HybridSystem& system = settled.system;
  const PeriodicOrbit& orbit = settled.orbit;
  const auto failing = [&](const PeriodicOrbit& changed) {
    std::vector<std::string> names;
    for (const OrbitCheck& check : verify_orbit(system, changed).checks)
      if (!check.passes()) names.push_back(check.name);
    return names;
  };
  CHECK(failing(orbit).empty());
  PeriodicOrbit multiplier = orbit;
  multiplier.multipliers.values[0] *= 1.00001;
  CHECK(failing(multiplier) == std::vector<std::string>{"multipliers: differences", "multipliers: GSL"});
  PeriodicOrbit exponent = orbit;
  exponent.multipliers.exponents[1] += 3e-4;
  CHECK(failing(exponent) == std::vector<std::string>{"exponents"});
  PeriodicOrbit matrix = orbit;
  matrix.monodromy.factors.front() *= 1.0 + 1e-6;
  CHECK_THAT(failing(matrix), Catch::Matchers::VectorContains(std::string("GSL: matrix")));
  PeriodicOrbit node = orbit;
  node.nodes.front()[1] += 1e-9;
  CHECK_THAT(failing(node), Catch::Matchers::VectorContains(std::string("GSL: motion")));
  PeriodicOrbit liouville = orbit;
  liouville.checks.liouville = 1e-9;
  CHECK(failing(liouville) == std::vector<std::string>{"Liouville"});
  PeriodicOrbit nothing = orbit;
  nothing.checks.residual = std::nan("");
  CHECK(failing(nothing) == std::vector<std::string>{"residual"});
}

TEST_CASE("the exponents of an unstable orbit are not averaged") {
  // The parent of the doubled orbit, past the period doubling at 0.9195.
  const HybridSystem system = make_oscillator("linear", "hertz");
  Vector p = default_parameters(system.parameters);
  p[oscillator_parameter::eta] = 0.915;
  p[oscillator_parameter::law + 1] = 0.1;
  const PeriodicOrbit orbit = shoot(system, p, Vector{{2.052, 1.38}}, 1);
  REQUIRE(orbit.converged());
  REQUIRE_FALSE(orbit.stable());
  const VerifiedOrbit verified = verify_orbit(system, orbit);
  CHECK(verified.agrees());
  CHECK_FALSE(check_of(verified, "exponents").applicable());
  CHECK(check_of(verified, "exponents").reason == "the orbit is unstable");
  for (const OrbitCheck& check : verified.checks) CHECK(check.reason.empty() == check.applicable());
  CHECK(verified.average.stop == LyapunovStop::not_run);
}

TEST_CASE("the exponents of an autonomous orbit are averaged from return to return") {
  const HybridSystem system = support::van_der_pol_stop();
  const Vector p = default_parameters(system.parameters);
  PeriodicOrbit orbit = shoot(system, p, std::vector<Vector>{Vector{{-1.5, 0.0}}}, 1, {}, 5.0);
  REQUIRE(orbit.converged());
  const VerifiedOrbit verified = verify_orbit(system, orbit);
  CHECK(verified.agrees());
  const OrbitCheck& exponents = check_of(verified, "exponents");
  INFO(exponents.disagreement << " " << exponents.limit);
  CHECK(exponents.applicable());
  CHECK(exponents.limit < 1e-3);
  CHECK(exponents.disagreement < bound::exponent);
  CHECK(verified.average.periods == 2000);
  CHECK(verified.average.impacts == 2000);
  CHECK(verified.average.duration == Approx(2000.0 * orbit.duration).epsilon(1e-11));
  orbit.multipliers.exponents[0] += 3e-4;
  CHECK_FALSE(check_of(verify_orbit(system, orbit), "exponents").passes());
}

TEST_CASE("aligned tangent vectors: the average at a node needs no long time") {
  const Case settled = settled_orbit("hertz", 0.925);
  const HybridSystem& system = settled.system;
  const PeriodicOrbit& orbit = settled.orbit;
  LyapunovOptions options;
  options.standard_error = 0.0;
  options.max_periods = 20;
  const auto off = [&] {
    const LyapunovSpectrum spectrum = lyapunov_spectrum(system, orbit.parameters, orbit.state, options);
    CHECK(spectrum.periods == 20);
    CHECK(spectrum.impacts == 20);
    return std::abs(spectrum.exponents[0] - orbit.multipliers.exponents[0]);
  };
  CHECK(off() > 1e-4);  // ln kappa over the time is 8e-3
  // |mu_2 / mu_1|^200 is far below rounding; 20 periods average a rounding error of 1e-15 a period.
  options.aligning = 200;
  CHECK(off() < 1e-13);
  options.aligning = -1;
  CHECK_THROWS_WITH(off(), Contains("aligning is -1; allowed is a whole number >= 0"));
}

TEST_CASE("verify_orbit refuses an invalid orbit") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  CHECK_THROWS_WITH(verify_orbit(system, {}), Contains("has no nodes"));
  const auto [same, orbit] = settled_orbit("hertz", 0.925);
  CHECK_THROWS_WITH(verify_orbit(same, orbit, {.average_periods = -1}), Contains("average_periods is -1"));
}
