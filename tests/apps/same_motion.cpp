// SPDX-License-Identifier: GPL-3.0-or-later
// Equivalent descriptions of systems from text: another phase of the forcing, the mirror image, other units of length, another
// order of the states. Orbits and multipliers must be the same.
#include "graze_program.hpp"

#include <graze/apps/problem/problem.hpp>
#include <graze/floquet/orbit/shooting.hpp>
#include <graze/lib/motion/trajectory.hpp>

#include <catch2/catch.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>
#include <vector>

using namespace graze;
using namespace graze::apps;
using namespace graze::support;

namespace {

constexpr double tolerance = 1e-10;

using Replacements = std::vector<std::pair<std::string, std::string>>;
using Settings = std::vector<std::pair<std::string, double>>;

/// A shipped model, with parts of its text replaced.
Problem model(const std::string& name, const Settings& settings, const Replacements& replacements = {}) {
  std::string text = read_file(fmt::format("{}/models/{}.toml", GRAZE_DATA_DIR, name));
  for (const auto& [from, to] : replacements) {
    const std::size_t at = text.find(from);
    INFO(from);
    REQUIRE(at != std::string::npos);
    text.replace(at, from.size(), to);
  }
  Problem problem = parse_problem(text, name);
  set_parameters(problem, settings);
  return problem;
}

/// From a guess close to the orbit.
PeriodicOrbit orbit_near(const Problem& problem, const Vector& guess) {
  const PeriodicOrbit orbit = shoot(problem.system, problem.parameters, guess + Vector::Constant(guess.size(), 1e-4), 1);
  INFO(problem.text);
  REQUIRE(orbit.converged());
  REQUIRE(orbit.admissible == Admissibility::admissible);
  return orbit;
}

void check_same(const PeriodicOrbit& orbit, const PeriodicOrbit& other, const Vector& state) {
  CHECK((other.state - state).norm() < tolerance);
  CHECK(other.impacts == orbit.impacts);
  std::vector<std::complex<double>> left(other.multipliers.values.begin(), other.multipliers.values.end());
  REQUIRE(left.size() == static_cast<std::size_t>(state.size()));
  for (const std::complex<double> one : orbit.multipliers.values) {
    const auto nearest = std::min_element(left.begin(), left.end(),
                                          [&](const auto& a, const auto& b) { return std::abs(a - one) < std::abs(b - one); });
    CHECK(std::abs(*nearest - one) < tolerance);
    left.erase(nearest);
  }
}

/// A model at parameters where it has an orbit with contacts near a state, and the same model in other descriptions.
struct Example {
  std::string name;
  Settings settings;
  Vector guess;
  Replacements mirrored, permuted;
  std::vector<Eigen::Index> order;                              ///< of the states in the permuted one
  Settings (*scaled)(const Problem&, double length) = nullptr;  ///< parameters in units of this length
};

Settings times(const Problem& problem, const std::vector<std::pair<std::string, double>>& factors) {
  Settings out;
  for (const auto& [name, factor] : factors) out.emplace_back(name, factor * parameter(problem, name));
  return out;
}

const std::vector<Example>& examples() {
  static const std::vector<Example> list = {
      {"duffing-two-stops",
       {},
       Vector{{0.596175, 0.435105}},
       {{"xi*cos(eta*t)", "-xi*cos(eta*t)"}},
       {{R"(["x", "v"])", R"(["v", "x"])"}},
       {1, 0},
       [](const Problem& at, double length) {
         return times(at, {{"xi", 1.0 / length}, {"r", 1.0 / length}, {"beta", length * length}});
       }},
      {"chain-hertz-stop",
       {{"eta", 0.9}},
       Vector{{0.463955, -4.319268, 2.035340, 3.363467}},
       {{"xi*cos(eta*t)", "-xi*cos(eta*t)"}, {"r - x2", "r + x2"}},
       {{R"(["x1", "x2"])", R"(["x2", "x1"])"},
        {R"(["v1", "v2"])", R"(["v2", "v1"])"},
        {R"([["m", 0], [0, 1]])", R"([[1, 0], [0, "m"]])"},
        {R"([["2*c", "-c"], ["-c", "c"]])", R"([["c", "-c"], ["-c", "2*c"]])"},
        {R"([["k + kappa", "-kappa"], ["-kappa", "kappa"]])", R"([["kappa", "-kappa"], ["-kappa", "k + kappa"]])"},
        {R"-(["xi*cos(eta*t)", "0"])-", R"-(["0", "xi*cos(eta*t)"])-"}},
       {1, 0, 3, 2},
       [](const Problem& at, double length) {
         return times(at, {{"xi", 1.0 / length}, {"r", 1.0 / length}, {"k_H", std::sqrt(length)}, {"b_H", length}});
       }},
      {"newton-oscillator",
       {{"k_r", 0.8}},
       Vector{{1.770503, 1.623152}},
       {{"xi*cos(eta*t)", "-xi*cos(eta*t)"}, {"r - x", "r + x"}},
       {},
       {0, 1},
       [](const Problem& at, double length) {
         return times(at, {{"xi", 1.0 / length}, {"r", 1.0 / length}});
       }},
  };
  return list;
}

}  // namespace

TEST_CASE("another phase of the forcing moves an orbit along itself") {
  for (const Example& example : examples()) {
    INFO(example.name);
    const Problem plain = model(example.name, example.settings);
    const PeriodicOrbit orbit = orbit_near(plain, example.guess);
    constexpr double phase = 0.7;
    const Problem shifted = model(example.name, example.settings, {{"cos(eta*t)", fmt::format("cos(eta*t + {})", phase)}});
    const Trajectory run = simulate(plain.system, plain.parameters, 0.0, orbit.state, {.t_end = phase / parameter(plain, "eta")});
    REQUIRE(run.termination == Termination::time);
    check_same(orbit, orbit_near(shifted, run.x), run.x);
  }
}

TEST_CASE("the mirror image of a system has the mirror images of its orbits") {
  for (const Example& example : examples()) {
    INFO(example.name);
    const PeriodicOrbit orbit = orbit_near(model(example.name, example.settings), example.guess);
    check_same(orbit, orbit_near(model(example.name, example.settings, example.mirrored), -example.guess), -orbit.state);
  }
}

TEST_CASE("the unit of length changes only the states of an orbit") {
  for (const Example& example : examples())
    for (const double length : {0.3, 7.0}) {
      INFO(example.name << " " << length);
      Problem problem = model(example.name, example.settings);
      const PeriodicOrbit orbit = orbit_near(problem, example.guess);
      set_parameters(problem, example.scaled(problem, length));
      check_same(orbit, orbit_near(problem, example.guess / length), orbit.state / length);
    }
}

TEST_CASE("the order of the states does not matter") {
  int compared = 0;
  for (const Example& example : examples()) {
    if (example.permuted.empty()) continue;
    INFO(example.name);
    const PeriodicOrbit orbit = orbit_near(model(example.name, example.settings), example.guess);
    const auto in_order = [&](const Vector& state) { return Vector(state(example.order)); };
    check_same(orbit, orbit_near(model(example.name, example.settings, example.permuted), in_order(example.guess)),
               in_order(orbit.state));
    ++compared;
  }
  CHECK(compared == 2);
}
