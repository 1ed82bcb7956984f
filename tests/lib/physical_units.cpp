// SPDX-License-Identifier: GPL-3.0-or-later
// Conversion from physical to dimensionless quantities: the formulas of DESIGN, and the motion itself in both units.
#include "support/checks.hpp"
#include "support/extrapolation.hpp"

#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/models/physical_units.hpp>
#include <graze/lib/motion/trajectory.hpp>

using namespace graze;
using namespace graze::support;

namespace {

/// The parameters of a model from a conversion, as in a problem file.
Vector fill(const HybridSystem& system, const Values& values) {
  Vector p = default_parameters(system.parameters);
  for (std::size_t i = 0; i < system.parameters.size(); ++i)
    if (const auto found = values.find(system.parameters[i].name); found != values.end())
      p[static_cast<Eigen::Index>(i)] = found->second;
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

/// Up to a few rounding errors.
Approx exactly(double value) { return Approx(value).epsilon(1e-14).margin(0.0); }

}  // namespace

TEST_CASE("kinematic excitation is converted") {
  // K = 30 + 70 = 100 N/m, alpha = sqrt(100/4) = 5 rad/s, x = X / 0.04 m.
  const Values d = to_dimensionless(excitation_kind("kinematic"), {{"m", 4.0},
                                                                   {"k", 30.0},
                                                                   {"k_e", 70.0},
                                                                   {"c", 2.0},
                                                                   {"a", 0.04},
                                                                   {"omega", 4.75},
                                                                   {"rho", 0.08},
                                                                   {"k_3", 5000.0},
                                                                   {"k_h", 50000.0},
                                                                   {"b_h", 0.5},
                                                                   {"k_s", 2500.0}});
  CHECK(d.at("alpha") == exactly(5.0));
  CHECK(d.at("length") == exactly(0.04));
  CHECK(d.at("xi") == exactly(0.7));
  CHECK(d.at("b") == exactly(0.05));     // 2 / (2 sqrt(400))
  CHECK(d.at("eta") == exactly(0.95));   // 4.75 / 5
  CHECK(d.at("r") == exactly(2.0));      // 0.08 / 0.04
  CHECK(d.at("k_H") == exactly(100.0));  // 50000 * 0.2 / 100
  CHECK(d.at("b_H") == exactly(0.1));    // 0.5 * 0.04 * 5
  CHECK(d.at("k_S") == exactly(25.0));   // 2500 / 100
  CHECK(d.at("beta") == exactly(0.08));  // 5000 * 0.0016 / 100
}

TEST_CASE("force excitation is converted") {
  // alpha = sqrt(100/4) = 5 rad/s, x_st = 4/100 = 0.04 m.
  const Values d = to_dimensionless(excitation_kind("force"), {{"m", 4.0},
                                                               {"k", 100.0},
                                                               {"c", 2.0},
                                                               {"F0", 4.0},
                                                               {"omega", 4.75},
                                                               {"rho", 0.08},
                                                               {"k_3", 0.0},
                                                               {"k_h", 50000.0},
                                                               {"b_h", 0.5},
                                                               {"k_s", 2500.0}});
  CHECK(d.at("alpha") == exactly(5.0));
  CHECK(d.at("length") == exactly(0.04));
  CHECK(d.at("xi") == 1.0);
  CHECK(d.at("b") == exactly(0.05));
  CHECK(d.at("eta") == exactly(0.95));
  CHECK(d.at("r") == exactly(2.0));
  CHECK(d.at("k_H") == exactly(100.0));
  CHECK(d.at("b_H") == exactly(0.1));
  CHECK(d.at("k_S") == exactly(25.0));
  CHECK(d.at("beta") == 0.0);
}

TEST_CASE("beam excitation is converted") {
  // k_1 = 12 * 0.0675 / 0.027 = 30 N/m, alpha = sqrt(30/1.2) = 5 rad/s, x = X / 0.3 m.
  const Values d = to_dimensionless(excitation_kind("beam"), {{"M", 1.2},
                                                              {"L", 0.3},
                                                              {"EI", 0.0675},
                                                              {"c", 0.312},
                                                              {"F0", 0.72},
                                                              {"omega", 2.77},
                                                              {"rho", 0.0237},
                                                              {"k_h", 0.0},
                                                              {"b_h", 0.2},
                                                              {"k_s", 750.0}});
  CHECK(d.at("alpha") == exactly(5.0));
  CHECK(d.at("length") == exactly(0.3));
  CHECK(d.at("stiffness") == exactly(30.0));
  CHECK(d.at("b") == exactly(0.026));  // 0.312 / (2 sqrt(36))
  CHECK(d.at("xi") == exactly(0.08));  // 0.72 / (25 * 1.2 * 0.3)
  CHECK(d.at("eta") == exactly(0.554));
  CHECK(d.at("r") == exactly(0.079));
  CHECK(d.at("beta") == exactly(36.0 / 35.0));
  CHECK(d.at("b_H") == exactly(0.3));  // 0.2 * 0.3 * 5
  CHECK(d.at("k_S") == exactly(25.0));
}

TEST_CASE("physical quantities follow from the dimensionless parameters") {
  for (const ExcitationKind& kind : excitation_kinds()) {
    Values given;
    double value = 1.5;
    for (const ParameterInfo& info : kind.quantities) given.emplace(info.name, value += 0.25);
    for (const ContactQuantity& contact : contact_quantities()) given.emplace(contact.info.name, value += 0.25);
    const Values dimensionless = to_dimensionless(kind, given), found = from_dimensionless(kind, dimensionless);
    for (const auto& [name, expected] : given) {
      INFO(kind.name << ": " << name);
      CHECK(found.at(name) == Approx(expected).epsilon(1e-14));
    }
    // kinetic energy of the mass at the velocity length * alpha
    const double mass = given.at(kind.name == "beam" ? "M" : "m");
    CHECK(found.at("energy") ==
          Approx(mass * std::pow(dimensionless.at("length") * dimensionless.at("alpha"), 2)).epsilon(1e-14));
  }
}

TEST_CASE("Hertz stiffness of a beam scales with the root of its length") {
  // ell = 0.25 m, k_1 = 12 * 0.01 / 0.015625 = 7.68 N/m: k_H = 1536 * 0.5 / 7.68 = 100.
  const Values d = to_dimensionless(
      excitation_kind("beam"),
      {{"M", 1.0}, {"L", 0.25}, {"EI", 0.01}, {"c", 0.0}, {"F0", 1.0}, {"omega", 1.0}, {"rho", 0.1}, {"k_h", 1536.0}});
  CHECK(d.at("k_H") == exactly(100.0));
}

TEST_CASE("the dimensionless motion agrees with the physical one in its own units") {
  // Free flight of all three kinds: position scaled by the length, time by alpha.
  const HybridSystem system = make_oscillator("cantilever", "hertz");
  const auto same = [&](const Values& d, const PhysicalMotion& motion, double X0, double V0, double t) {
    const Vector p = fill(system, d);
    const Trajectory run = simulate(system, p, 0.0, vector({X0 / d.at("length"), V0 / (d.at("length") * d.at("alpha"))}),
                                    {.t_end = d.at("alpha") * t});
    REQUIRE(run.events.empty());
    const LongState<2> end = motion.at(t, X0, V0);
    REQUIRE(run.x[0] * d.at("length") == Approx(static_cast<double>(end[0])).epsilon(1e-11));
    REQUIRE(run.x[1] * d.at("length") * d.at("alpha") == Approx(static_cast<double>(end[1])).epsilon(1e-11));
  };
  same(to_dimensionless(excitation_kind("kinematic"), {{"m", 2.0},
                                                       {"k", 300.0},
                                                       {"k_e", 500.0},
                                                       {"c", 4.0},
                                                       {"a", 0.01},
                                                       {"omega", 18.0},
                                                       {"rho", 0.5},
                                                       {"k_3", 1e5},
                                                       {"k_h", 1e6}}),
       {2.0, 4.0, 800.0, 1e5, 500.0 * 0.01, 18.0}, 0.004, -0.1, 0.7);
  same(to_dimensionless(
           excitation_kind("force"),
           {{"m", 0.5}, {"k", 50.0}, {"c", 0.3}, {"F0", 4.0}, {"omega", 9.0}, {"rho", 5.0}, {"k_3", 100.0}, {"k_h", 1e4}}),
       {0.5, 0.3, 50.0, 100.0, 4.0, 9.0}, 0.1, 0.4, 1.1);
  const double k_1 = 12.0 * 0.8 / 0.064;
  same(to_dimensionless(
           excitation_kind("beam"),
           {{"M", 1.5}, {"L", 0.4}, {"EI", 0.8}, {"c", 0.7}, {"F0", 3.0}, {"omega", 5.0}, {"rho", 5.0}, {"k_h", 1e4}}),
       {1.5, 0.7, k_1, 36.0 / 35.0 * k_1 / 0.16, 3.0, 5.0}, 0.05, 0.1, 0.9);
}

TEST_CASE("a conversion gives every parameter of every law except k_r and sets the missing one to 0") {
  REQUIRE(excitation_kinds().size() == 3);
  for (const ExcitationKind& kind : excitation_kinds()) {
    INFO(kind.name);
    Values ones;
    for (const ParameterInfo& quantity : kind.quantities) {
      REQUIRE_FALSE(quantity.unit.empty());
      ones[quantity.name] = 1.0;
    }
    const Values d = to_dimensionless(kind, ones);
    REQUIRE(d.at("alpha") > 0.0);
    REQUIRE(std::isfinite(d.at("eta")));
    REQUIRE(d.at("k_H") == 0.0);
    for (const ContactLaw& law : contact_laws())
      for (const ParameterInfo& parameter : law.parameters) REQUIRE(d.contains(parameter.name) == (parameter.name != "k_r"));
    for (const ParameterInfo& parameter : oscillator_parameters()) REQUIRE(d.contains(parameter.name));
    for (const ContactQuantity& quantity : contact_quantities()) REQUIRE(d.contains(quantity.parameter));
  }
  REQUIRE_THROWS_WITH(excitation_kind("kinematik"),
                      "there is no excitation \"kinematik\" (did you mean \"kinematic\"?); choose one of "
                      "kinematic, force, beam");
}

TEST_CASE("an oscillator with physical parameters moves as the dimensionless one and has derivatives in them") {
  for (const ExcitationKind& kind : excitation_kinds())
    for (const OscillatorKind& oscillator : oscillator_kinds())
      for (const ContactLaw& law : contact_laws()) {
        Values quantities = {{"k_h", 60.0}, {"b_h", 0.04}, {"k_s", 30.0}};
        double value = 1.1;
        for (const ParameterInfo& info : kind.quantities) quantities[info.name] = value += 0.07;
        quantities["rho"] = 0.3;
        const Values d = to_dimensionless(kind, quantities);
        const HybridSystem plain = make_oscillator(oscillator, law);
        Vector p = default_parameters(plain.parameters);
        if (law.name == "newton") p[oscillator_parameter::law] = 0.8;
        for (std::size_t i = 0; i < plain.parameters.size(); ++i) {
          const std::string& name = plain.parameters[i].name;
          if (d.contains(name) && (name != "beta" || oscillator.beta != 0.0)) p[static_cast<Eigen::Index>(i)] = d.at(name);
        }
        const double T = forcing_period(plain, p);
        const Vector x0 = vector({0.1 * p[oscillator_parameter::r], 0.6});
        Propagator direct(plain, p);
        Transition a;
        carry(direct, 0.0, T, x0, {}, a);
        std::vector<std::string> names;
        for (const ParameterInfo& info : kind.quantities) names.push_back(info.name);
        if (law.name == "hertz") names.insert(names.end(), {"k_h", "b_h"});
        for (const std::string& name : names) {
          INFO(kind.name << " " << oscillator.name << " " << law.name << " " << name);
          const equations::TextSystem varied = read_oscillator(oscillator, law, kind, quantities, {name});
          Vector q = default_parameters(varied.system.parameters);
          for (std::size_t i = 0; i < varied.system.parameters.size(); ++i)
            for (std::size_t k = 0; k < plain.parameters.size(); ++k)
              if (plain.parameters[k].name == varied.system.parameters[i].name)
                q[static_cast<Eigen::Index>(i)] = p[static_cast<Eigen::Index>(k)];
          REQUIRE(forcing_period(varied.system, q) == Approx(T).epsilon(1e-14));
          Propagator other(varied.system, q);
          Transition b;
          carry(other, 0.0, T, x0, {}, b);
          REQUIRE(b.event_sequence == a.event_sequence);
          REQUIRE((a.x1 - b.x1).norm() < 1e-11 * (1.0 + a.x1.norm()));
          REQUIRE((a.Phi - b.Phi).norm() < 1e-9 * (1.0 + a.Phi.norm()));
          REQUIRE_THAT(check_transition(varied.system, q, 0.0, T, x0, 1e-6, 1e-5), all_agree());
        }
      }
}
