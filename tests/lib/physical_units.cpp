// SPDX-License-Identifier: GPL-3.0-or-later
// From physical to dimensionless: the formulas of DESIGN, and the motion itself in both units.
#include "support/checks.hpp"
#include "support/extrapolation.hpp"

#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/models/physical_units.hpp>
#include <graze/lib/motion/trajectory.hpp>

using namespace graze;
using namespace graze::support;

namespace {

/// The parameters of a model filled from a conversion, as a problem file is.
Vector fill(const HybridSystem& system, const Dimensionless& values) {
  Vector p = default_parameters(system.parameters);
  for (std::size_t i = 0; i < system.parameters.size(); ++i)
    if (const double* value = find_value(values, system.parameters[i].name)) p[static_cast<Eigen::Index>(i)] = *value;
  return p;
}

/// m X'' + c X' + K X + k_3 X^3 + [X > rho] (k_h (X - rho)^(3/2) (1 + b_h X')) = F cos(omega t), in seconds and metres.
struct PhysicalMotion {
  double m, c, K, k_3, F, omega;
  LongState<2> at(double t, double X0, double V0) const {
    const auto field = [this](long double s, const LongState<2>& z, LongState<2>& dz) {
      dz = {z[1], (F * std::cos(static_cast<long double>(omega) * s) - c * z[1] - K * z[0] - k_3 * z[0] * z[0] * z[0]) / m};
    };
    return extrapolate<2>(field, 0.0L, t, {X0, V0});
  }
};

}  // namespace

TEST_CASE("kinematic excitation is converted by the formulas of the source") {
  const Dimensionless d = to_dimensionless(
      KinematicExcitation{.m = 2.0, .k = 300.0, .k_e = 500.0, .c = 4.0, .a = 0.01, .omega = 18.0, .rho = 0.02, .k_3 = 1e5},
      {.k_h = 1e6, .b_h = 0.5, .k_s = 2e4});
  REQUIRE(d.alpha == Approx(20.0));
  REQUIRE(d.length == 0.01);
  REQUIRE(d.stiffness == 800.0);
  REQUIRE(d.xi == Approx(0.625));
  REQUIRE(d.b == Approx(4.0 / (2.0 * std::sqrt(1600.0))));
  REQUIRE(d.eta == Approx(0.9));
  REQUIRE(d.r == Approx(2.0));
  REQUIRE(d.beta == Approx(1e5 * 1e-4 / 800.0));
  REQUIRE(d.k_H == Approx(1e6 * 0.1 / 800.0));
  REQUIRE(d.b_H == Approx(0.5 * 0.01 * 20.0));
  REQUIRE(d.k_S == Approx(25.0));
}

TEST_CASE("force excitation is converted by the formulas of the source") {
  const Dimensionless d = to_dimensionless(ForceExcitation{.m = 0.5, .k = 50.0, .c = 0.3, .F0 = 4.0, .omega = 9.0, .rho = 0.1},
                                           {.k_h = 1e4, .b_h = 0.2, .k_s = 500.0});
  const double alpha = 10.0, x_st = 0.08;
  REQUIRE(d.alpha == Approx(alpha));
  REQUIRE(d.xi == 1.0);
  REQUIRE(d.b == Approx(0.3 / (2.0 * std::sqrt(25.0))));
  REQUIRE(d.eta == Approx(0.9));
  REQUIRE(d.r == Approx(0.1 / x_st));
  REQUIRE(d.beta == 0.0);
  REQUIRE(d.k_H == Approx(1e4 * std::sqrt(x_st) / 50.0));
  REQUIRE(d.b_H == Approx(0.2 * x_st * alpha));
  REQUIRE(d.k_S == Approx(10.0));
}

TEST_CASE("a beam on two leaf springs is converted by the formulas of the source") {
  const Dimensionless d =
      to_dimensionless(BeamExcitation{.M = 1.5, .L = 0.4, .EI = 0.8, .c = 0.7, .F0 = 3.0, .omega = 5.0, .rho = 0.05},
                       {.k_h = 1e4, .b_h = 0.2, .k_s = 500.0});
  const double k_1 = 12.0 * 0.8 / 0.064, alpha = std::sqrt(k_1 / 1.5);
  REQUIRE(d.alpha == Approx(alpha));
  REQUIRE(d.xi == Approx(3.0 / (alpha * alpha * 1.5 * 0.4)));
  REQUIRE(d.b == Approx(0.7 / (2.0 * std::sqrt(k_1 * 1.5))));
  REQUIRE(d.beta == 36.0 / 35.0);
  REQUIRE(d.eta == Approx(5.0 / alpha));
  REQUIRE(d.r == Approx(0.125));
  REQUIRE(d.k_H == Approx(1e4 * std::sqrt(0.4) / k_1));
  REQUIRE(d.b_H == Approx(0.2 * 0.4 * alpha));
  REQUIRE(d.k_S == Approx(500.0 / k_1));
}

TEST_CASE("the dimensionless motion is the physical one in its own units") {
  // Free flight of all three kinds; position by the length, time by alpha.
  const HybridSystem system = make_oscillator("cantilever", "hertz");
  const auto same = [&](const Dimensionless& d, const PhysicalMotion& motion, double X0, double V0, double t) {
    const Vector p = fill(system, d);
    const Trajectory run = simulate(system, p, 0.0, vector({X0 / d.length, V0 / (d.length * d.alpha)}), {.t_end = d.alpha * t});
    REQUIRE(run.events.empty());
    const LongState<2> end = motion.at(t, X0, V0);
    REQUIRE(run.x[0] * d.length == Approx(static_cast<double>(end[0])).epsilon(1e-11));
    REQUIRE(run.x[1] * d.length * d.alpha == Approx(static_cast<double>(end[1])).epsilon(1e-11));
  };
  same(to_dimensionless(
           KinematicExcitation{.m = 2.0, .k = 300.0, .k_e = 500.0, .c = 4.0, .a = 0.01, .omega = 18.0, .rho = 0.5, .k_3 = 1e5},
           {.k_h = 1e6}),
       {2.0, 4.0, 800.0, 1e5, 500.0 * 0.01, 18.0}, 0.004, -0.1, 0.7);
  same(to_dimensionless(ForceExcitation{.m = 0.5, .k = 50.0, .c = 0.3, .F0 = 4.0, .omega = 9.0, .rho = 5.0, .k_3 = 100.0},
                        {.k_h = 1e4}),
       {0.5, 0.3, 50.0, 100.0, 4.0, 9.0}, 0.1, 0.4, 1.1);
  const double k_1 = 12.0 * 0.8 / 0.064;
  same(to_dimensionless(BeamExcitation{.M = 1.5, .L = 0.4, .EI = 0.8, .c = 0.7, .F0 = 3.0, .omega = 5.0, .rho = 5.0},
                        {.k_h = 1e4}),
       {1.5, 0.7, k_1, 36.0 / 35.0 * k_1 / 0.16, 3.0, 5.0}, 0.05, 0.1, 0.9);
}

TEST_CASE("conversions by name give what the structs give, and cover every parameter of every law but k_r") {
  const ExcitationKind& kind = excitation_kind("kinematic");
  const Dimensionless d = kind.convert(
      {{"m", 2.0}, {"k", 300.0}, {"k_e", 500.0}, {"c", 4.0}, {"a", 0.01}, {"omega", 18.0}, {"rho", 0.02}, {"k_s", 2e4}});
  REQUIRE(d.eta == Approx(0.9));
  REQUIRE(d.k_S == Approx(25.0));
  REQUIRE(d.k_H == 0.0);
  REQUIRE(excitation_kinds().size() == 3);
  for (const ExcitationKind& each : excitation_kinds()) {
    std::map<std::string, double> ones;
    for (const ParameterInfo& quantity : each.quantities) {
      REQUIRE_FALSE(quantity.unit.empty());
      ones[quantity.name] = 1.0;
    }
    const Dimensionless unit = each.convert(ones);
    REQUIRE(unit.alpha > 0.0);
    REQUIRE(std::isfinite(unit.eta));
  }
  for (const ContactLaw& law : contact_laws())
    for (const ParameterInfo& parameter : law.parameters)
      REQUIRE((find_value(d, parameter.name) != nullptr) == (parameter.name != "k_r"));
  for (const ParameterInfo& parameter : oscillator_parameters()) REQUIRE(find_value(d, parameter.name) != nullptr);
  for (const ContactQuantity& quantity : contact_quantities()) REQUIRE(find_value(d, quantity.parameter) != nullptr);
  REQUIRE_THROWS_WITH(excitation_kind("kinematik"),
                      "there is no excitation \"kinematik\" (did you mean \"kinematic\"?); choose one of "
                      "kinematic, force, beam");
}
