// SPDX-License-Identifier: GPL-3.0-or-later
// Parameters: names, ranges and the error messages for values out of range.
#include "support/bouncing_ball.hpp"
#include "support/checks.hpp"
#include "support/two_mass_oscillator.hpp"

#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/motion/trajectory.hpp>

using namespace graze;
using namespace graze::support;

namespace {

const double not_a_number = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();

/// Runs `system` with parameter `name` set to `value`.
Trajectory run_with(const HybridSystem& system, const char* name, double value) {
  return simulate(system, parameters(system, {{name, value}}), 0.0, Vector::Zero(2), {.t_end = 1.0});
}

}  // namespace

TEST_CASE("a parameter out of range is refused with its name, value and range") {
  const HybridSystem newton = make_oscillator("linear", "newton"), hertz = make_oscillator("linear", "hertz");
  REQUIRE_THROWS_WITH(run_with(newton, "k_r", 1.2), "parameter k_r is 1.2; allowed is [0, 1]");
  REQUIRE_THROWS_WITH(run_with(newton, "k_r", -0.1), "parameter k_r is -0.1; allowed is [0, 1]");
  REQUIRE_THROWS_WITH(run_with(hertz, "b", -0.05), "parameter b is -0.05; allowed is >= 0");
  REQUIRE_THROWS_WITH(run_with(hertz, "eta", 0.0), "parameter eta is 0; allowed is > 0");
  REQUIRE_THROWS_WITH(run_with(hertz, "k_H", 0.0), "parameter k_H is 0; allowed is > 0");
  REQUIRE_THROWS_WITH(run_with(hertz, "r", not_a_number), "parameter r is nan; allowed is any finite number");
  REQUIRE_THROWS_WITH(run_with(hertz, "r", infinity), "parameter r is inf; allowed is any finite number");
  REQUIRE_THROWS_WITH(run_with(hertz, "b", infinity), "parameter b is inf; allowed is a finite number >= 0");
  REQUIRE_THROWS_AS(run_with(hertz, "b", not_a_number), std::invalid_argument);
  // The closed ends of a range are allowed.
  REQUIRE_NOTHROW(run_with(newton, "k_r", 0.0));
  REQUIRE_NOTHROW(run_with(newton, "k_r", 1.0));
  REQUIRE_NOTHROW(run_with(hertz, "b", 0.0));
  REQUIRE_NOTHROW(run_with(hertz, "b_H", 0.0));
}

TEST_CASE("a wrong number of parameter values is refused") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  REQUIRE_THROWS_WITH(simulate(system, Vector::Ones(3), 0.0, Vector::Zero(2), {.t_end = 1.0}),
                      "3 parameter values were given; this model has 7");
}

TEST_CASE("an unknown parameter is refused with the nearest name") {
  const HybridSystem newton = make_oscillator("linear", "newton");
  REQUIRE_THROWS_WITH(parameter_index(newton.parameters, "k_R"),
                      "there is no parameter \"k_R\" (did you mean \"k_r\"?); choose one of b, beta, xi, eta, r, k_r");
  REQUIRE_THROWS_WITH(parameter_index(newton.parameters, "omega"),
                      "there is no parameter \"omega\"; choose one of b, beta, xi, eta, r, k_r");
  REQUIRE(parameter_index(newton.parameters, "k_r") == oscillator_parameter::law);
}

TEST_CASE("the nearest name is one typing error away") {
  const std::vector<std::string> names = {"eta", "beta", "xi", "k_H", "b_H"};
  REQUIRE(nearest_name("etta", names) == "eta");
  REQUIRE(nearest_name("bta", names) == "eta");  // one letter changed, as is one left out of "beta": the first listed
  REQUIRE(nearest_name("K_H", names) == "k_H");
  REQUIRE(nearest_name("ix", names) == "xi");  // two letters swapped
  REQUIRE(nearest_name("stiffness", names).empty());
  REQUIRE(nearest_name("", names).empty());
  REQUIRE(nearest_name("x", names).empty());  // one letter
  REQUIRE(nearest_name("ξ", {"x"}).empty());
  REQUIRE(nearest_name("eta", {}).empty());
}

TEST_CASE("ranges are described in words") {
  const auto text = [](double lower, double upper, bool lower_open = false) {
    ParameterInfo parameter;
    parameter.lower = lower;
    parameter.upper = upper;
    parameter.lower_open = lower_open;
    return range_text(parameter);
  };
  REQUIRE(text(-infinity, infinity) == "any finite number");
  REQUIRE(text(0.0, infinity) == ">= 0");
  REQUIRE(text(0.0, infinity, true) == "> 0");
  REQUIRE(text(-infinity, 2.5) == "<= 2.5");
  REQUIRE(text(0.0, 1.0) == "[0, 1]");
  REQUIRE(text(0.0, 1.0, true) == "(0, 1]");
}

TEST_CASE("defaults follow the order of the parameters") {
  const HybridSystem system = make_oscillator("cantilever", "linear");
  REQUIRE(default_parameters(system.parameters) == vector({0.05, 36.0 / 35.0, 1.0, 0.95, 2.0, 25.0}));
}

TEST_CASE("an invalid start, time or flow option is refused in one sentence") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector p = default_parameters(system.parameters);
  const auto run = [&](double t0, const Vector& x0, double t_end, const FlowOptions& options = {}) {
    return simulate(system, p, t0, x0, {.t_end = t_end}, options);
  };
  REQUIRE_THROWS_WITH(run(0.0, Vector::Zero(3), 1.0), "the state has 3 entries; system linear-hertz has 2");
  REQUIRE_THROWS_WITH(run(0.0, vector({0.0, not_a_number}), 1.0), "the state holds a value that is not a finite number");
  REQUIRE_THROWS_WITH(run(not_a_number, Vector::Zero(2), 1.0), "a run from t = nan to 1; both must be finite numbers");
  REQUIRE_THROWS_WITH(run(0.0, Vector::Zero(2), infinity), "a run from t = 0 to inf; both must be finite numbers");
  REQUIRE_THROWS_WITH(run(0.0, Vector::Zero(2), 1.0, {.tolerance = 0.0}), "flow option tolerance is 0; allowed is > 0");
  REQUIRE_THROWS_WITH(run(0.0, Vector::Zero(2), 1.0, {.tolerance = not_a_number}),
                      "flow option tolerance is nan; allowed is > 0");
  REQUIRE_THROWS_WITH(run(0.0, Vector::Zero(2), 1.0, {.max_step = -1.0}), "flow option max_step is -1; allowed is >= 0");
  REQUIRE_THROWS_WITH(run(0.0, Vector::Zero(2), 1.0, {.accumulation_window = -1.0}),
                      "flow option accumulation_window is -1; allowed is >= 0");
  REQUIRE_THROWS_WITH(Propagator(system, p, {7}),
                      "sensitivity in parameter number 7 was asked for; system linear-hertz has 7 (counted from 0)");
}

TEST_CASE("a system with inconsistent parts is refused in one sentence") {
  const HybridSystem good = two_mass_oscillator();
  const auto refusal = [&](const auto& spoil) {
    HybridSystem system = good;
    spoil(system);
    try {
      simulate(system, default_parameters(system.parameters), 0.0, Vector::Zero(4), {.t_end = 0.1});
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  REQUIRE(refusal([](HybridSystem&) {}) == "accepted");
  REQUIRE(refusal([](HybridSystem& s) { s.states = 0; }) == "system two-mass: it has no states");
  REQUIRE(refusal([](HybridSystem& s) { s.modes.clear(); }) == "system two-mass: it has no modes");
  REQUIRE(refusal([](HybridSystem& s) { s.forcing_frequency = 8; }) ==
          "system two-mass: the forcing frequency is not one of its parameters");
  REQUIRE(refusal([](HybridSystem& s) { s.modes[0].field = {}; }) == "system two-mass: mode free has no field");
  REQUIRE(refusal([](HybridSystem& s) { s.modes[0].field_dx = {}; }) ==
          "system two-mass: mode free has no derivative of the field in x");
  REQUIRE(refusal([](HybridSystem& s) { s.modes[0].field_dp = {}; }) ==
          "system two-mass: mode free has no derivative of the field in p");
  REQUIRE(refusal([](HybridSystem& s) { s.events[1].to = 1; }) ==
          "system two-mass: event impact-2 leads from or to a mode that does not exist");
  REQUIRE(refusal([](HybridSystem& s) { s.events[0].guard.value = {}; }) == "system two-mass: event impact-1 has no guard");
  REQUIRE(refusal([](HybridSystem& s) { s.events[0].guard.dx = {}; }) ==
          "system two-mass: event impact-1 has no derivative of the guard in x");
  REQUIRE(refusal([](HybridSystem& s) { s.events[0].reset.dx = {}; }) ==
          "system two-mass: event impact-1 has no derivative of the reset in x");
  REQUIRE(refusal([](HybridSystem& s) { s.events[0].guard.level->coordinate = 4; }) ==
          "system two-mass: event impact-1 watches a coordinate that does not exist");
  REQUIRE(refusal([](HybridSystem& s) { s.events[0].guard.level->level = 8; }) ==
          "system two-mass: event impact-1 watches a level that is not a parameter");
  REQUIRE(refusal([](HybridSystem& s) { s.events[0].accumulation = Accumulation{.sticking_mode = 3, .reset = {}}; }) ==
          "system two-mass: event impact-1 accumulates in a mode that does not exist");
  REQUIRE(refusal([](HybridSystem& s) { s.events[0].accumulation = Accumulation{}; }) ==
          "system two-mass: event impact-1 has no reset (or no derivative of it) for its accumulation point");
}

TEST_CASE("the forcing period and its derivative follow from the forcing frequency and an autonomous system has none") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = parameters(system, {{"eta", 0.8}});
  REQUIRE(forcing_period(system, p) == Approx(2.0 * 3.141592653589793 / 0.8).epsilon(1e-15));
  const auto period = [&](const Vector& q) { return Vector::Constant(1, forcing_period(system, q)).eval(); };
  REQUIRE(check_jacobian(period, p, forcing_period_dp(system, p).transpose()).agrees(1e-10));
  const HybridSystem ball = bouncing_ball();
  REQUIRE_THROWS_WITH(forcing_period(ball, default_parameters(ball.parameters)),
                      "system bouncing-ball is autonomous; it has no forcing period");
}
