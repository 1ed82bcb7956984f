// SPDX-License-Identifier: GPL-3.0-or-later
// Symmetries, derived from the functions of a system.
#include "support/checks.hpp"
#include "support/system_texts.hpp"

#include <graze/lib/motion/trajectory.hpp>
#include <graze/lib/system/symmetry.hpp>

using namespace graze;
using namespace graze::support;

namespace {

std::vector<std::string> texts(const HybridSystem& system, const Vector& p) {
  std::vector<std::string> out;
  for (const Symmetry& one : symmetries(system, p)) out.push_back(symmetry_text(system, one));
  std::sort(out.begin(), out.end());
  return out;
}

/// Two equal masses, each on its own spring and coupled by a third, in front of stops. Both have the same forcing.
HybridSystem pair(const std::string& law) {
  SystemWriter writer;
  writer.system.name = "pair";
  writer.forcing("w").parameter("w", "0.9").parameter("F", "1.3").parameter("k", "0.4").parameter("m", "1").parameter("r", "0.5");
  writer.parameter("s", "0.5").parameter("e", "0.7");
  writer.mechanics(
      {"x1", "x2"}, {"v1", "v2"},
      {{{"1", "0"}, {"0", "m"}}, {{"0.1", "0"}, {"0", "0.1"}}, {{"1 + k", "-k"}, {"-k", "1 + k"}}, {"F*cos(w*t)", "F*cos(w*t)"}});
  writer.stop("first", "r - x1", law, {"e"}).stop("second", "s - x2", law, {"e"});
  return equations::make_system(writer.system).system;
}

}  // namespace

TEST_CASE("two opposite stops: the symmetry is minus one with half a period if the stops are equally far") {
  const HybridSystem system = equations::make_system(duffing_text()).system;
  CHECK(texts(system, default_parameters(system.parameters)) == std::vector<std::string>{"(x, v)(t) -> (-x, -v)(t + T/2)"});
  SystemWriter writer;
  writer.system = duffing_text();
  writer.system.events[1].when.text = "-x - 1.01*r";
  const HybridSystem other = equations::make_system(writer.system).system;
  CHECK(texts(other, default_parameters(other.parameters)).empty());
  // A force with an even harmonic has no half-period symmetry.
  writer.system = duffing_text();
  writer.system.modes[0].equations.text = "x' = v\nv' = xi*cos(eta*t) + 0.1*cos(2*eta*t) - 2*b*v - spring";
  const HybridSystem uneven = equations::make_system(writer.system).system;
  CHECK(texts(uneven, default_parameters(uneven.parameters)).empty());
}

TEST_CASE("one barrier has no symmetry") {
  for (const ContactLaw& law : contact_laws()) {
    const HybridSystem system = make_oscillator(oscillator_kind("cantilever"), law);
    const Vector p = default_parameters(system.parameters);
    CHECK(symmetries(system, p).empty());
    // Its free flight has one.
    REQUIRE(flight_symmetries(system, p).size() == 1);
    CHECK(symmetry_text(system, flight_symmetries(system, p)[0]) == "(x, v)(t) -> (-x, -v)(t + T/2)");
  }
}

TEST_CASE("equal masses with equal stops may be exchanged and the exchange maps motions to motions") {
  for (const std::string law : {"newton", "linear"}) {
    const HybridSystem system = pair(law);
    const Vector p = default_parameters(system.parameters);
    const std::vector<Symmetry> found = symmetries(system, p);
    REQUIRE(found.size() == 1);
    CHECK(symmetry_text(system, found[0]) == "(x1, x2, v1, v2)(t) -> (x2, x1, v2, v1)(t)");
    CHECK(found[0].shift == 0.0);
    const Vector x0 = vector({0.1, -0.3, 0.2, 0.6});
    const Trajectory run = simulate(system, p, 0.0, x0, {.t_end = 20.0});
    const Trajectory image = simulate(system, p, 0.0, found[0].matrix * x0, {.t_end = 20.0});
    REQUIRE(run.events.size() > 3);
    CHECK((found[0].matrix * run.x - image.x).norm() < 1e-10);
    CHECK(symmetries(system, parameters(system, {{"m", 1.01}})).empty());
    CHECK(symmetries(system, parameters(system, {{"s", 0.51}})).empty());
  }
}

TEST_CASE("an autonomous system has its symmetries without a shift in time, and counted sections need none") {
  SystemWriter writer;
  writer.system.name = "free";
  writer.states({"x", "v"}).parameter("k", "1");
  const std::string equations = "x' = v; v' = -k*x";
  writer.mode("slow", equations).mode("fast", equations);
  writer.event({"reaches", "other", "v - 1", "", "slow", "fast"}).event({"loses", "other", "1 - v", "", "fast", "slow"});
  for (const std::string mode : {"slow", "fast"}) writer.event({"wall " + mode, "impact", "x - 2", "v = -v", mode, mode});
  for (const std::string mode : {"slow", "fast"}) writer.event({"other " + mode, "impact", "-2 - x", "v = -v", mode, mode});
  const HybridSystem system = equations::make_system(writer.system).system;
  CHECK(texts(system, default_parameters(system.parameters)) == std::vector<std::string>{"(x, v)(t) -> (-x, -v)(t)"});
  writer.system.modes[1].equations.text = "x' = v; v' = -1.1*k*x";
  const HybridSystem uneven = equations::make_system(writer.system).system;
  CHECK(symmetries(uneven, default_parameters(uneven.parameters)).empty());
}
