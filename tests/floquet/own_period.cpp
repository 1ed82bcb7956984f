// SPDX-License-Identifier: GPL-3.0-or-later
// A forced system with the period itself as a parameter instead of a frequency. Its orbits are those of the same system with a
// frequency.
#include "support/checks.hpp"
#include "support/system_texts.hpp"

#include <graze/floquet/orbit/shooting.hpp>

#include <numbers>

using namespace graze;
using namespace graze::support;

TEST_CASE("an orbit of a system with an explicit period is forced and the same as with the frequency") {
  SystemWriter writer;
  writer.system.name = "timed";
  writer.states({"x", "v"}).parameter("T", "7").parameter("r", "0.5").parameter("k_r", "0.7");
  writer.system.period = writer.write("T");
  writer.mode("free", "x' = v; v' = cos(2*pi*t/T) - 0.1*v - x");
  writer.event({"wall", "impact", "x - r", "v = -k_r*v", "", ""});
  const HybridSystem timed = equations::make_system(writer.system).system, given = make_oscillator("linear", "newton");
  const Vector p = parameters(given, {{"b", 0.05}, {"xi", 1.0}, {"eta", 0.8}, {"r", 0.5}, {"k_r", 0.7}});
  const double T = 2.0 * std::numbers::pi / 0.8;
  const Vector q = parameters(timed, {{"T", T}});
  const Vector settled = simulate(given, p, 0.0, vector({0.1, 0.2}), {.t_end = 400.0 * T}).x;
  const PeriodicOrbit a = shoot(given, p, settled, 1), b = shoot(timed, q, settled, 1);
  REQUIRE(a.converged());
  REQUIRE(b.converged());
  REQUIRE(a.stable());
  REQUIRE(b.duration == Approx(T).epsilon(1e-15));
  REQUIRE((a.state - b.state).norm() < 1e-11);
  REQUIRE(b.multipliers.values.size() == 2);
  REQUIRE(std::abs(a.multipliers.values[0] - b.multipliers.values[0]) < 1e-10);
  REQUIRE_THAT(check_transition(timed, q, 0.0, T, b.state, 1e-7, 1e-5), all_agree());
}
