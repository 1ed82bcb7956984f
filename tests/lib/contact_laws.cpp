// SPDX-License-Identifier: GPL-3.0-or-later
// Every contact law on every oscillator. The lists contact_laws() and oscillator_kinds() drive these tests, so that a new law
// is tested once it is listed.
#include "support/checks.hpp"

#include <graze/lib/models/oscillator.hpp>

#include <algorithm>
#include <set>

using namespace graze;
using namespace graze::support;

namespace {

template <class Test> void for_each_system(const Test& test) {
  for (const OscillatorKind& kind : oscillator_kinds())
    for (const ContactLaw& law : contact_laws()) test(make_oscillator(kind, law), law);
}

/// Parameter values drawn within their ranges, away from the ends: differences need room on both sides.
Vector drawn_within_range(const HybridSystem& system, Random& random) {
  Vector p = default_parameters(system.parameters);
  for (std::size_t i = 0; i < system.parameters.size(); ++i) {
    const ParameterInfo& info = system.parameters[i];
    const double lower = std::isfinite(info.lower) ? info.lower : info.default_value - 1.0;
    const double upper = std::isfinite(info.upper) ? info.upper : std::max(info.default_value, lower) + 1.0;
    if (info.name != "beta" || info.default_value != 0.0)
      p[static_cast<Eigen::Index>(i)] = random(lower + 0.1 * (upper - lower), upper - 0.1 * (upper - lower));
  }
  return p;
}

}  // namespace

TEST_CASE("derivatives of fields, guards, resets and coefficients agree with differences for every law") {
  for_each_system([](const HybridSystem& system, const ContactLaw&) {
    Random random(4);
    for (int i = 0; i < 20; ++i) {
      const Vector p = drawn_within_range(system, random);
      const double t = random(-3.0, 6.0), r = p[oscillator_parameter::r];
      for (std::size_t mode = 0; mode < system.modes.size(); ++mode) {
        // Inside the mode: short of the barrier in flight, beyond it in contact. The depth keeps sqrt smooth over the
        // difference steps.
        const double x = mode == 0 ? r - random(0.1, 2.0) : r + random(0.2, 0.8);
        REQUIRE_THAT(check_mode(system, mode, t, vector({x, random(-2.0, 2.0)}), p), all_agree());
      }
      for (std::size_t event = 0; event < system.events.size(); ++event)
        REQUIRE_THAT(check_event(system, event, t, vector({r, random(-2.0, 2.0)}), p), all_agree());
    }
  });
}

TEST_CASE("every system is valid and has ranges, meanings and unique names") {
  std::set<std::string> names;
  for_each_system([&](const HybridSystem& system, const ContactLaw& law) {
    INFO(system.name);
    REQUIRE_NOTHROW(validate(system));
    REQUIRE_NOTHROW(check_parameters(system.parameters, default_parameters(system.parameters)));
    REQUIRE(names.insert(system.name).second);
    REQUIRE(system.states == 2);
    REQUIRE(system.forcing_frequency.has_value());
    std::set<std::string> parameters;
    for (const ParameterInfo& info : system.parameters) {
      REQUIRE(parameters.insert(info.name).second);
      REQUIRE_FALSE(info.meaning.empty());
    }
    REQUIRE_FALSE(law.formula.empty());
    REQUIRE(&contact_law(law.name) == &law);
  });
}

TEST_CASE("every flow returns the field of its mode") {
  for_each_system([](const HybridSystem& system, const ContactLaw&) {
    Random random(5);
    for (int i = 0; i < 10; ++i) {
      const Vector p = drawn_within_range(system, random);
      const double t = random(0.0, 9.0), r = p[oscillator_parameter::r];
      for (std::size_t mode = 0; mode < system.modes.size(); ++mode) {
        const Vector x = vector({mode == 0 ? r - random(0.0, 2.0) : r + random(0.0, 1.0), random(-2.0, 2.0)});
        Vector expected(2), given(2);
        system.modes[mode].field(t, x, p, expected);
        for (const FlowKind kind : {FlowKind::automatic, FlowKind::general}) {
          make_flow(system, mode, p, {}, {.kind = kind}).field(t, x, given);
          // The same terms, added in another order.
          REQUIRE((given - expected).norm() <= 1e-15 * (1.0 + expected.norm()) * 10.0);
        }
      }
    }
  });
}

TEST_CASE("soft laws are continuous at the barrier in state and field and declared so") {
  for_each_system([](const HybridSystem& system, const ContactLaw& law) {
    if (law.hard) return;
    Random random(6);
    for (const Event& event : system.events) {
      REQUIRE(event.continuous);
      REQUIRE_FALSE(event.reset.map);
      for (int i = 0; i < 10; ++i) {
        const Vector p = drawn_within_range(system, random);
        const Vector x = vector({p[oscillator_parameter::r], random(-2.0, 2.0)});
        const double t = random(0.0, 9.0);
        Vector before(2), after(2);
        system.modes[event.from].field(t, x, p, before);
        system.modes[event.to].field(t, x, p, after);
        REQUIRE(before == after);
      }
    }
  });
}

TEST_CASE("contact forces follow the formulas of their laws") {
  const Vector x = vector({2.25, -0.4});
  const auto force = [&](const char* law, std::initializer_list<std::pair<const char*, double>> set) {
    const HybridSystem system = make_oscillator("linear", law);
    const Vector p = parameters(system, set);
    Vector free(2), contact(2);
    system.modes[0].field(0.3, x, p, free);
    system.modes[1].field(0.3, x, p, contact);
    return free[1] - contact[1];
  };
  REQUIRE(force("hertz", {{"k_H", 80.0}}) == Approx(80.0 * 0.125));
  REQUIRE(force("hertz", {{"k_H", 80.0}, {"b_H", 0.5}}) == Approx(80.0 * 0.125 * 0.8));
  REQUIRE(force("linear", {{"k_S", 12.0}}) == Approx(12.0 * 0.25));
  Vector out(2);
  const HybridSystem newton = make_oscillator("linear", "newton");
  newton.events[0].reset.map(0.0, vector({2.0, 3.0}), parameters(newton, {{"k_r", 0.6}}), out);
  REQUIRE(out == vector({2.0, -0.6 * 3.0}));
}

TEST_CASE("the free oscillator follows its source: damping, stiffness, cubic term and forcing") {
  const HybridSystem system = make_oscillator("cantilever", "hertz");
  const Vector p = parameters(system, {{"b", 0.1}, {"xi", 1.5}, {"eta", 0.7}});
  REQUIRE(p[oscillator_parameter::beta] == 36.0 / 35.0);
  Vector f(2);
  system.modes[0].field(2.0, vector({0.5, -0.3}), p, f);
  REQUIRE(f[0] == -0.3);
  REQUIRE(f[1] == Approx(1.5 * std::cos(1.4) + 2.0 * 0.1 * 0.3 - 0.5 - 36.0 / 35.0 * 0.125));
  REQUIRE(barrier_acceleration(2.0, p) == Approx(1.5 * std::cos(1.4) - 2.0 - 36.0 / 35.0 * 8.0));
}

TEST_CASE("an unknown law or oscillator is refused with the nearest name") {
  REQUIRE_THROWS_WITH(contact_law("herz"),
                      "there is no contact law \"herz\" (did you mean \"hertz\"?); choose one of hertz, linear, newton");
  REQUIRE_THROWS_WITH(oscillator_kind("cantilver"), "there is no oscillator \"cantilver\" (did you mean \"cantilever\"?); choose "
                                                    "one of linear, cantilever");
  REQUIRE_THROWS_WITH(contact_law("glue"), "there is no contact law \"glue\"; choose one of hertz, linear, newton");
  REQUIRE_THROWS_AS(make_oscillator("linear", "Newton"), std::invalid_argument);
}
