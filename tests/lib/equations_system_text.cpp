// SPDX-License-Identifier: GPL-3.0-or-later
// Systems as text: parameters, periods, rates, contact powers, the initial mode, and every mistake with its exact message.
#include "support/checks.hpp"
#include "support/system_texts.hpp"

#include <numbers>

using namespace graze;
using namespace graze::support;

namespace {

/// A system with one state more than the mistake needs: x' = v, v' = the force.
SystemWriter with_force(const std::string& force) {
  SystemWriter writer;
  writer.system.name = "test";
  writer.states({"x", "v"}).parameter("k", "2").parameter("r", "0.5").mode("free", "x' = v; v' = " + force);
  return writer;
}

std::string force_mistake(const std::string& force) { return mistake(with_force(force).start("x", "0").start("v", "1").system); }

std::string parameter_mistake(const std::string& value) { return mistake(with_force("-x").parameter("q", value).system); }

}  // namespace

TEST_CASE("the rimless wheel as text: autonomous, a reset of both states, a fraction of pi") {
  SystemWriter writer;
  writer.system.name = "wheel";
  writer.states({"theta", "w"}).parameter("alpha", "pi/8").parameter("gamma", "0.08");
  writer.mode("stance", "theta' = w\nw' = sin(theta)");
  writer.event({"heel strike", "impact", "theta - gamma - alpha", "theta = gamma - alpha; w = cos(2*alpha)*w", "", ""});
  writer.system.events[0].count = 1;
  writer.start("theta", "gamma - alpha").start("w", "0.5");
  const equations::TextSystem read = equations::make_system(writer.system);
  const HybridSystem& system = read.system;
  REQUIRE(!is_forced(system));
  const Vector p = default_parameters(system.parameters);
  REQUIRE(p[0] == std::numbers::pi / 8);
  REQUIRE(read.events[0].count == 1);
  REQUIRE(read.start->isApprox(vector({0.08 - std::numbers::pi / 8, 0.5})));
  REQUIRE_THAT(check_mode(system, 0, 0.0, *read.start, p), all_agree());
  REQUIRE_THAT(check_event(system, 0, 0.0, *read.start, p), all_agree());
  // The walking cycle: w+ = cos(2 alpha) w-, and conservation of energy in between:
  // w-^2 (1 - cos^2) = 2 (cos(gamma - alpha) - cos(gamma + alpha)).
  const double drop = 2.0 * (std::cos(p[1] - p[0]) - std::cos(p[1] + p[0])), c = std::cos(2.0 * p[0]);
  const double before = std::sqrt(drop / (1.0 - c * c));
  const Trajectory run = simulate(system, p, 0.0, vector({p[1] - p[0], c * before}), {.t_end = 8.0});
  REQUIRE(run.events.size() >= 2);
  for (const EventRecord& event : run.events) REQUIRE(event.x_minus[1] == Approx(before).epsilon(1e-11));
}

TEST_CASE("second derivatives of a field follow from its expressions") {
  const equations::TextSystem read = equations::make_system(duffing_text());
  equations::Graph& graph = *read.graph;
  const equations::Expression f = read.modes[0].field[1], x = graph.state(0);
  const equations::Expression twice = graph.derivative(graph.derivative(f, x), x);
  REQUIRE(equations::to_text(graph, twice, {{"x", "v"}, {"b", "A", "eta", "beta", "r", "k_r"}}) == "-(beta*(3*(2*x)))");
}

TEST_CASE("an explicit period: T(p) and its derivative replace the forcing frequency") {
  SystemWriter writer;
  writer.system.name = "timed";
  writer.states({"x", "v"}).parameter("T", "3").parameter("xi", "1.5").parameter("r", "0.5").parameter("k_r", "0.8");
  writer.system.period = writer.write("2*T");
  writer.mode("free", "x' = v; v' = xi*cos(pi*t/T) - 0.1*v - x");
  writer.event({"wall", "impact", "x - r", "v = -k_r*v", "", ""});
  const HybridSystem system = equations::make_system(writer.system).system;
  REQUIRE(is_forced(system));
  REQUIRE(!system.forcing_frequency);
  const Vector p = default_parameters(system.parameters);
  REQUIRE(forcing_period(system, p) == 6.0);
  REQUIRE(forcing_period_dp(system, p) == vector({2.0, 0.0, 0.0, 0.0}));
  REQUIRE_THAT(check_transition(system, p, 0.0, 12.0, vector({0.1, 0.6}), 1e-7, 1e-5), all_agree());
  HybridSystem both = system;
  both.forcing_frequency = 0;
  REQUIRE_THROWS_WITH(validate(both), "system timed: it has both a forcing frequency and a period of its own");

  // 2 pi/eta is recognised as the frequency eta; a tied frequency makes a period.
  SystemWriter plain = with_force("cos(w*t) - x");
  plain.parameter("w", "0.9");
  plain.system.period = plain.write("2*pi/w");
  REQUIRE(equations::make_system(plain.system).system.forcing_frequency == 2);
  SystemWriter tied = with_force("cos(w*t) - x");
  tied.parameter("w", "k/3").forcing("w");
  const HybridSystem by_tied = equations::make_system(tied.system).system;
  const Vector q = default_parameters(by_tied.parameters);
  REQUIRE(forcing_period(by_tied, q) == Approx(3.0 * std::numbers::pi).epsilon(1e-15));
  REQUIRE(forcing_period_dp(by_tied, q)[0] == Approx(-1.5 * std::numbers::pi).epsilon(1e-14));
}

TEST_CASE("rates: d' of a definition along the field of its mode, x' of a state") {
  SystemWriter writer;
  writer.system.name = "rates";
  writer.states({"x", "v"}).forcing("w").parameter("w", "1.3").parameter("c", "0.2").parameter("k", "9");
  writer.definition("d", "x - 0.3*sin(w*t)").definition("force", "k*d + c*d' + 0*x'").definition("twice", "force'");
  writer.mode("free", "x' = v\nv' = -x");
  writer.mode("contact", "x' = v\nv' = -x - force");
  writer.event({"enter", "enter", "d", "", "free", "contact"});
  writer.event({"leave", "leave", "-force", "", "contact", "free"});
  writer.output("rate", "twice");
  const equations::TextSystem read = equations::make_system(writer.system);
  const Vector p = default_parameters(read.system.parameters), x = vector({0.4, -0.7});
  Vector f(2);
  const double t = 0.9, d = 0.4 - 0.3 * std::sin(1.3 * t), rate = -0.7 - 0.39 * std::cos(1.3 * t);
  read.system.modes[1].field(t, x, p, f);
  REQUIRE(f[1] == Approx(-0.4 - 9.0 * d - 0.2 * rate).epsilon(1e-14));
  for (const std::size_t mode : {0, 1}) {
    REQUIRE_THAT(check_mode(read.system, mode, t, x, p), all_agree());
    REQUIRE_THAT(check_event(read.system, mode, t, x, p), all_agree());
    // twice = k d' + c d'', d'' = v' + 0.3 w^2 sin(w t)
    read.system.modes[mode].field(t, x, p, f);
    const double wanted = 9.0 * rate + 0.2 * (f[1] + 0.3 * 1.69 * std::sin(1.3 * t));
    REQUIRE(read.outputs[0].value(mode, t, x, p) == Approx(wanted).epsilon(1e-13));
  }
  // On entry with a damping force the field jumps. On exit the force vanishes and the field is continuous.
  REQUIRE(!read.system.events[0].continuous);
  REQUIRE(read.system.events[1].continuous);
}

TEST_CASE("a contact power in any number of states and on either side is zero outside its contact and continuous") {
  SystemWriter writer;
  writer.system.name = "chain";
  writer.states({"x1", "v1", "x2", "v2"}).parameter("k", "50").parameter("r", "0.2");
  writer.definition("depth", "x1 - x2 - r");
  writer.mode("free", "x1' = v1; v1' = -x1; x2' = v2; v2' = -2*x2");
  writer.mode("touch", "x1' = v1; v1' = -x1 - k*depth^(3/2); x2' = v2; v2' = -2*x2 + k*(x1 - (x2 + r))^1.5");
  writer.event({"enter", "enter", "depth", "", "free", "touch"});
  writer.event({"leave", "leave", "-depth", "", "touch", "free"});
  writer.output("pressure", "k*depth^(3/2)");
  const equations::TextSystem read = equations::make_system(writer.system);
  const HybridSystem& system = read.system;
  REQUIRE(system.events[0].continuous);
  REQUIRE(system.events[1].continuous);
  const Vector p = default_parameters(system.parameters), inside = vector({0.5, 0.1, 0.1, 0.2}),
               outside = vector({0.1, 0.1, 0.2, 0.3});
  REQUIRE_THAT(check_mode(system, 1, 0.0, inside, p), all_agree());
  REQUIRE(mode_at(system, 0.0, inside, p) == 1);
  REQUIRE(mode_at(system, 0.0, outside, p) == 0);
  REQUIRE(read.outputs[0].value(1, 0.0, inside, p) == Approx(50.0 * std::pow(0.2, 1.5)));
  REQUIRE(read.outputs[0].value(0, 0.0, outside, p) == 0.0);
  REQUIRE_THAT(check_transition(system, p, 0.0, 6.0, vector({0.5, 1.0, -0.1, 0.2}), 1e-6, 1e-5), all_agree());
  // Powers of an expression that cannot be negative need no guard: an orbit in a central field.
  SystemWriter central;
  central.system.name = "central";
  central.states({"x", "y", "u", "v"}).mode("all", "x' = u; y' = v; u' = -x/(x^2 + y^2)^(3/2); v' = -y/(x^2 + y^2)^(3/2)");
  central.start("x", "1").start("y", "0").start("u", "0").start("v", "1");
  const equations::TextSystem orbit = equations::make_system(central.system);
  const Trajectory run = simulate(orbit.system, Vector(0), 0.0, *orbit.start, {.t_end = 2.0 * std::numbers::pi});
  REQUIRE((run.x - *orbit.start).norm() < 1e-10);
}

TEST_CASE("the initial mode: the first without a positive guard and no start beyond an impact guard") {
  const HybridSystem system = equations::make_system(duffing_text()).system;
  const Vector p = default_parameters(system.parameters);
  REQUIRE(mode_at(system, 0.0, vector({0.1, 3.0}), p) == 0);
  REQUIRE(mode_at(system, 0.0, vector({0.6, 3.0}), p) == 0);
  REQUIRE(mode_at(system, 0.0, vector({-0.6 - 1e-14, 3.0}), p) == 0);
  REQUIRE(!mode_at(system, 0.0, vector({0.61, 0.0}), p).has_value());
  REQUIRE(!mode_at(system, 0.0, vector({-0.61, 0.0}), p).has_value());
}

TEST_CASE("an event without from belongs to every mode") {
  SystemWriter writer = with_force("-x");
  writer.mode("other", "x' = v; v' = -2*x");
  writer.event({"wall", "impact", "x - r", "v = -v", "", ""}).event({"change", "other", "-v - 1", "", "free", "other"});
  const equations::TextSystem read = equations::make_system(writer.system);
  REQUIRE(read.system.events.size() == 3);
  REQUIRE(read.system.events[1].from == 1);
  REQUIRE(read.system.events[1].to == 1);
  REQUIRE(read.events[1].text == 0);
  REQUIRE(read.events[2].text == 1);
}

TEST_CASE("splines from tables may appear in equations") {
  SystemWriter writer = with_force("-spline(track, x) - k*spline(track', x)");
  writer.system.tables = {{"track", {-4.0, -1.0, 0.0, 1.0, 4.0}, {-3.0, -1.0, 0.0, 1.5, 3.0}}};
  const HybridSystem system = equations::make_system(writer.system).system;
  REQUIRE_THAT(check_mode(system, 0, 0.0, vector({0.4, 0.1}), default_parameters(system.parameters)), all_agree());
  const std::string unknown = mistake(with_force("-spline(track, x)").system);
  REQUIRE(unknown == "system.toml:8:22: unknown table 'track' in the equation of v");
}

TEST_CASE("each mistake in names and parameters gives one sentence with its place") {
  REQUIRE(force_mistake("-x + etaa") == "system.toml:8:19: unknown name 'etaa' in the equation of v");
  REQUIRE(force_mistake("-x*") == "system.toml:8:17: an operand is missing at the end in the equation of v");
  REQUIRE(mistake(with_force("-x").definition("k", "2").system) ==
          "system.toml:9:1: the name 'k' of a definition is that of a parameter already");
  REQUIRE(mistake(with_force("-x").definition("x", "2").system) ==
          "system.toml:9:1: the name 'x' of a definition is that of a state already");
  REQUIRE(mistake(with_force("-x").parameter("sin", "2").system) ==
          "system.toml:9:1: a parameter cannot be called 'sin', which is a function");
  REQUIRE(mistake(with_force("-x").definition("t", "2").system) ==
          "system.toml:9:1: a definition cannot be called 't', which is the time");
  REQUIRE(mistake(with_force("-x").output("pi", "2").system) ==
          "system.toml:9:1: an output cannot be called 'pi', which is the number pi");
  REQUIRE(mistake(with_force("-x").parameter("2a", "2").system) ==
          "system.toml:9:1: '2a' is no name for a parameter: letters, digits and _ are, beginning with a letter");
  REQUIRE(mistake(with_force("-x").mode("free", "x' = v; v' = 1").system) ==
          "system.toml:9:1: a mode called 'free' exists already");
  REQUIRE(parameter_mistake("") == "system.toml:10:1: nothing stands in the parameter q");
  REQUIRE(parameter_mistake("2*x") == "system.toml:10:3: the state x cannot be used in the parameter q");
  REQUIRE(parameter_mistake("k*t") == "system.toml:10:3: the time t cannot be used in the parameter q");
  REQUIRE(parameter_mistake("kk*2") == "system.toml:10:1: unknown name 'kk' in the parameter q; did you mean 'k'?");
  REQUIRE(parameter_mistake("2*q") == "system.toml:10:3: the parameter q depends on itself: q -> q");
  REQUIRE(parameter_mistake("1/(3 - 3)") == "system.toml:10:3: a division by zero in the parameter q");
  REQUIRE(parameter_mistake("log(0)") == "system.toml:10:1: the number in the parameter q is not finite");
  SystemWriter ranged = with_force("-x");
  ranged.system.parameters[0].max = ranged.write("3/2");
  REQUIRE(mistake(ranged.system) == "system.toml:4:1: parameter k is 2; allowed is <= 1.5");
  ranged.system.parameters[0].below = ranged.write("3");
  REQUIRE(mistake(ranged.system) == "system.toml:10:1: the parameter k has both max and below");
  ranged.system.parameters[0].max.reset();
  const ParameterInfo below = equations::make_system(ranged.system).system.parameters[0];
  REQUIRE_THROWS(check_parameters({below}, Vector::Constant(1, 3.0)));
  REQUIRE_NOTHROW(check_parameters({below}, Vector::Constant(1, std::nextafter(3.0, 0.0))));
}

TEST_CASE("each mistake in modes and events gives one sentence with its place") {
  const auto mode = [](const std::string& equations) {
    SystemWriter writer;
    writer.states({"x", "v"}).parameter("k", "2").mode("free", equations);
    return mistake(writer.system);
  };
  REQUIRE(mode("x' = v") == "system.toml:5:1: the state v has no equation in mode free");
  REQUIRE(mode("x' = v; v' = -x; y' = 1") == "system.toml:6:18: an equation of 'y', which is no state, in mode free");
  REQUIRE(mode("x' = v; v = -x") == "system.toml:6:9: an equation of mode free begins with v' =");
  REQUIRE(mode("x' = v; v' = -x; x' = 1") == "system.toml:6:18: a second equation of x in mode free");
  REQUIRE(mode("x' = v; v' = v'") == "system.toml:6:14: the rate of v in mode free depends on itself");
  REQUIRE(mode("x' = v; v' = cos(k*t)") ==
          "system.toml:6:14: the equation of v depends on the time, but neither a forcing frequency nor a period is given");
  const auto event = [](const EventStrings& strings) { return mistake(with_force("-x").event(strings).system); };
  REQUIRE(event({"wall", "impact", "r - k", "v = -v", "", ""}) ==
          "system.toml:11:1: the guard of wall does not depend on the motion: no state stands in it");
  REQUIRE(event({"wall", "impct", "x - r", "v = -v", "", ""}) ==
          "system.toml:10:1: the event wall has an unknown kind 'impct'; did you mean 'impact'?");
  REQUIRE(event({"wall", "impact", "x - r", "w = -v", "", ""}) ==
          "system.toml:12:1: the reset of wall sets 'w', which is no state; choose one of x, v");
  REQUIRE(event({"wall", "impact", "x - r", "v' = -v", "", ""}) ==
          "system.toml:12:1: the reset of wall sets a rate; write v = ...");
  REQUIRE(event({"wall", "impact", "x - r", "v = -v; v = 0", "", ""}) == "system.toml:12:9: the reset of wall sets v twice");
  REQUIRE(event({"wall", "impact", "x - r", "v = -v", "fre", ""}) ==
          "system.toml:11:1: the event wall names an unknown mode 'fre'; did you mean 'free'?");
  REQUIRE(event({"wall", "impact", "", "v = -v", "", ""}) == "system.toml:11:1: nothing stands in the guard of wall");
  REQUIRE(event({"wall", "impact", "x - r", "v = k*v", "", ""})
              .starts_with("system.toml:12:1: the reset of wall leaves the state beyond its guard in mode free: the guard is 0 "
                           "and rises at the rate"));
  REQUIRE(event({"wall", "impact", "x - r", "x = r + 1; v = -v", "", ""})
              .starts_with("system.toml:12:1: the reset of wall leaves the state beyond its guard in mode free: the guard is 1 "
                           "and rises at the rate"));
  REQUIRE(event({"wall", "impact", "x - r", "", "", ""})
              .starts_with(
                  "system.toml:11:1: wall has no reset and leaves the state beyond its guard in mode free: the guard is 0 and"));
  REQUIRE(event({"wall", "impact", "x - r", "v = 0", "", ""}) == "none");
  REQUIRE(
      mistake(
          with_force("-x").event({"wall", "", "x - r", "v = -v", "", ""}).event({"wall", "", "-x", "v = -v", "", ""}).system) ==
      "system.toml:12:1: an event called 'wall' exists already");
}

TEST_CASE("each mistake in values at the start gives one sentence with its place") {
  REQUIRE(force_mistake("-1/x") == "system.toml:8:17: the divisor x is zero at the start");
  REQUIRE(force_mistake("-x^-2") == "system.toml:8:16: the divisor x is zero at the start");
  REQUIRE(force_mistake("-1/(k - 4*r)") == "system.toml:8:17: the divisor k - 4*r is zero at the default parameters");
  REQUIRE(force_mistake("sqrt(x - 1)") == "system.toml:8:14: no real root: x - 1 is -1 at the start");
  REQUIRE(force_mistake("log(x)") == "system.toml:8:14: no finite logarithm: x is 0 at the start");
  REQUIRE(force_mistake("-(x - r)^(3/2)") ==
          "system.toml:8:22: x - r may become negative under an exponent that is no integer, in "
          "mode free, which is not entered through it as a guard");
  REQUIRE(mistake(with_force("-1/x").system) == "none");
  const auto start = [](const std::vector<std::pair<std::string, std::string>>& values) {
    SystemWriter writer = with_force("-x");
    writer.event({"wall", "impact", "x - r", "v = -v", "", ""});
    for (const auto& [state, value] : values) writer.start(state, value);
    return mistake(writer.system);
  };
  REQUIRE(start({{"x", "1"}, {"v", "0"}}) == "system.toml:13:1: the start lies beyond a guard of every mode (wall)");
  REQUIRE(start({{"x", "-1"}}) == "none");
  REQUIRE(start({{"x", "0"}, {"x", "1"}}) == "system.toml:15:1: the start gives x twice");
  REQUIRE(start({{"w", "0"}}) == "system.toml:13:1: the start gives 'w', which is no state; choose one of x, v");
  REQUIRE(start({{"x", "-r"}, {"v", "k/2"}}) == "none");
  SystemWriter root = with_force("-x");
  root.mode("touch", "x' = v; v' = -x - k*sqrt(x - r)").event({"enter", "enter", "x - r", "", "free", "touch"});
  REQUIRE(mistake(root.system) ==
          "system.toml:10:21: the power of x - r has an infinite derivative at the guard through which mode touch is entered");
}

TEST_CASE("each mistake in the forcing gives one sentence with its place") {
  const auto forced = [](const std::string& force, const std::string& frequency, const std::string& period) {
    SystemWriter writer = with_force(force);
    if (!frequency.empty()) writer.forcing(frequency);
    if (!period.empty()) writer.system.period = writer.write(period);
    return mistake(writer.system);
  };
  REQUIRE(forced("cos(k*t) - x", "kk", "") == "system.toml:9:1: the forcing frequency 'kk' is no parameter; did you mean 'k'?");
  REQUIRE(forced("cos(k*t) - x", "k", "3") == "system.toml:10:1: both a forcing frequency and a period are given");
  REQUIRE(forced("cos(k*t) - x", "", "-3") == "system.toml:9:1: the period is -3 by default; allowed is > 0");
  REQUIRE(forced("cos(r*t) - x", "k", "") ==
          "system.toml:8:14: the equation of v does not repeat with the period 3.141592653589793");
  REQUIRE(forced("cos(k*t)^3 + sin(2*k*t) - x", "k", "") == "none");
  REQUIRE(forced("cos(k*t) - x", "", "x") == "system.toml:9:1: the state x cannot be used in the period");
}

TEST_CASE("a system of ten thousand lines is read in seconds at most") {
  SystemWriter writer;
  writer.system.name = "long";
  writer.states({"x", "v"}).parameter("a", "0.5");
  writer.system.definitions.reserve(10000);
  std::string& text = writer.system.source.text;
  for (std::size_t i = 0; i < 10000; ++i) {
    const std::string name = fmt::format("d{}", i), value = i == 0 ? "x" : fmt::format("a*d{} + sin(v)/(1 + x^2)", i - 1);
    text += name + " = " + value + "\n";
    writer.system.definitions.push_back({{name, {i + 4, 1, name.size()}}, {value, {i + 4, 9, value.size()}}});
  }
  writer.mode("free", "x' = v; v' = -x - d9999");
  const equations::TextSystem read = equations::make_system(writer.system);
  Vector f(2);
  read.system.modes[0].field(0.0, vector({0.3, 0.2}), vector({0.5}), f);
  REQUIRE(f[1] == Approx(-0.3 - 2.0 * std::sin(0.2) / 1.09).epsilon(1e-12));
}
