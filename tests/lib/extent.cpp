// SPDX-License-Identifier: GPL-3.0-or-later
// Extrema and integrals of functions of the motion, against closed forms, or against samples where there is no closed form.
#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/motion/extent.hpp>

#include "support/bouncing_ball.hpp"
#include "support/checks.hpp"

#include <catch2/catch.hpp>

#include <cmath>
#include <numbers>

using namespace graze;
using namespace graze::support;
using equations::Expression;
using equations::Graph;
using equations::MotionFunctions;
using equations::Operation;

namespace {

std::vector<Extent> measured(const HybridSystem& system, const Vector& p, const Vector& start, double t_end, Graph& graph,
                             const std::vector<Expression>& of) {
  Propagator propagator(system, p);
  const Trajectory run = simulate(system, p, 0.0, start, {.t_end = t_end});
  REQUIRE(run.termination == Termination::time);
  return extents(propagator, run, MotionFunctions(graph, of, system.states), std::vector<bool>(of.size(), true));
}

void set(const HybridSystem& system, Vector& p, const char* name, double value) {
  p[static_cast<Eigen::Index>(parameter_index(system.parameters, name))] = value;
}

}  // namespace

TEST_CASE("extents along a harmonic motion agree with the closed form") {
  // x = R cos(eta t - phi), v = -R eta sin(eta t - phi).
  const HybridSystem system = make_oscillator("linear", "newton");
  Vector p = default_parameters(system.parameters);
  const double b = 0.05, eta = 0.83, R = 1.0 / std::hypot(1.0 - eta * eta, 2.0 * b * eta),
               phi = std::atan2(2.0 * b * eta, 1.0 - eta * eta), T = 2.0 * std::numbers::pi / eta;
  set(system, p, "b", b);
  set(system, p, "xi", 1.0);
  set(system, p, "eta", eta);
  set(system, p, "r", 100.0);
  Graph graph;
  const Expression x = graph.state(0), v = graph.state(1), speed = graph.function(Operation::abs, v);
  const Expression force =
      graph.function(Operation::cos, graph.multiply(graph.parameter(parameter_index(system.parameters, "eta")), graph.time()));
  const auto found =
      measured(system, p, vector({R * std::cos(phi), R * eta * std::sin(phi)}), T, graph,
               {x, v, graph.rate(v), graph.multiply(x, x), speed, graph.multiply(force, v), graph.function(Operation::step, x)});
  const double tolerance = 1e-12 * (1.0 + R);
  CHECK(std::abs(found[0].largest - R) < tolerance);
  CHECK(std::abs(found[0].smallest + R) < tolerance);
  CHECK(std::abs(found[0].integral) < tolerance * T);
  CHECK(std::abs(found[1].largest - R * eta) < tolerance);
  CHECK(std::abs(found[2].largest - R * eta * eta) < tolerance);
  CHECK(std::abs(found[3].integral - R * R / 2.0 * T) < tolerance * R * T);
  CHECK(std::abs(found[3].smallest) < 1e-20);
  // abs(v) has corners where v vanishes; step(x) jumps.
  CHECK(std::abs(found[4].integral - 4.0 * R) < tolerance * T);
  CHECK(std::abs(found[4].smallest) < tolerance);
  CHECK(std::abs(found[6].integral - T / 2.0) < 1e-11 * T);
  // The work of the force is the energy lost in the damper: the integral of 2 b v^2.
  CHECK(std::abs(found[5].integral - b * R * R * eta * eta * T) < tolerance * R * T);
}

TEST_CASE("extents of functions with jumps and corners agree with closed forms for any selection of functions") {
  // The undamped and unforced motion x = cos t: v = -sin t, so that every sign change is known.
  const HybridSystem system = make_oscillator("linear", "newton");
  Vector p = default_parameters(system.parameters);
  set(system, p, "b", 0.0);
  set(system, p, "xi", 0.0);
  set(system, p, "eta", 1.0);
  set(system, p, "r", 100.0);
  const double T = 2.0 * std::numbers::pi, a = 0.3, root = std::sqrt(1.0 - a * a), angle = std::acos(a);
  Graph graph;
  const auto of = [&](Operation operation, Expression first, Expression second = {}) {
    return graph.function(operation, first, second);
  };
  const Expression x = graph.state(0), v = graph.state(1), level = graph.constant(a), beyond = graph.subtract(x, level);
  struct Case {
    Expression function;
    double integral, largest, smallest;
  };
  const std::vector<Case> cases = {
      {of(Operation::step, beyond), 2.0 * angle, 1.0, 0.0},
      {of(Operation::sign, beyond), 4.0 * angle - T, 1.0, -1.0},
      {of(Operation::max, x, level), 2.0 * root + a * (T - 2.0 * angle), 1.0, a},
      {of(Operation::min, x, level), -2.0 * root + a * 2.0 * angle, a, -1.0},
      {of(Operation::abs, beyond), 4.0 * root - 4.0 * a * angle + a * T, 1.0 + a, 0.0},
      {graph.multiply(of(Operation::step, beyond), v), 0.0, root, -root},
      {graph.multiply(of(Operation::step, beyond), of(Operation::abs, v)), 2.0 * (1.0 - a), root, 0.0},
      {graph.multiply(of(Operation::sign, graph.subtract(of(Operation::abs, x), level)), x), 0.0, 1.0, -1.0},
      {of(Operation::sign, graph.subtract(of(Operation::abs, x), level)), 8.0 * angle - T, 1.0, -1.0},
      {of(Operation::step, graph.subtract(of(Operation::max, v, x), graph.constant(0.9))),
       // cos t > 0.9 or -sin t > 0.9: two arcs that do not meet
       4.0 * std::acos(0.9), 1.0, 0.0},
  };
  std::vector<Expression> all;
  for (const Case& one : cases) all.push_back(one.function);
  const Vector start = vector({1.0, 0.0});
  const std::vector<Extent> together = measured(system, p, start, T, graph, all);
  for (std::size_t i = 0; i < cases.size(); ++i) {
    CAPTURE(i);
    const Extent alone = measured(system, p, start, T, graph, {all[i]})[0];
    for (const Extent& found : {alone, together[i]}) {
      CHECK(std::abs(found.integral - cases[i].integral) < 1e-11);
      CHECK(std::abs(found.largest - cases[i].largest) < 1e-11);
      CHECK(std::abs(found.smallest - cases[i].smallest) < 1e-11);
    }
  }
}

TEST_CASE("extents of a ball that comes to rest are the sums over its flights") {
  // A flight that begins with speed u: height u^2/(2 g), distance u^2/g, area 2 u^3/(3 g^2).
  const HybridSystem system = bouncing_ball();
  const double g = 9.81, k_r = 0.8, u = 3.0;
  const Vector p = vector({g, 0.0, k_r});
  Graph graph;
  const Expression x = graph.state(0), v = graph.state(1);
  const double rest = 2.0 * u / g / (1.0 - k_r);
  const auto found = measured(system, p, vector({0.0, u}), 1.3 * rest, graph, {x, graph.function(Operation::abs, v), v});
  CHECK(std::abs(found[0].largest - u * u / (2.0 * g)) < 1e-13);
  CHECK(found[0].smallest >= -1e-15);
  CHECK(std::abs(found[0].integral - 2.0 * u * u * u / (3.0 * g * g) / (1.0 - k_r * k_r * k_r)) < 1e-12);
  CHECK(std::abs(found[1].integral - u * u / g / (1.0 - k_r * k_r)) < 1e-11);
  CHECK(std::abs(found[2].largest - u) < 1e-13);
  CHECK(std::abs(found[2].smallest + u) < 1e-12);  // immediately before the first impact
}

TEST_CASE("extents through a Hertz contact agree with the fundamental theorem and with samples") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector p = default_parameters(system.parameters);
  const Vector start = vector({1.9, 1.2});
  const double T = 3.0 * forcing_period(system, p);
  const Trajectory run = simulate(system, p, 0.0, start, {.t_end = T});
  REQUIRE(run.events.size() >= 4);
  Graph graph;
  const Expression x = graph.state(0), v = graph.state(1);
  const auto found = measured(system, p, start, T, graph, {x, v, graph.rate(v), graph.multiply(x, v)});
  CHECK(std::abs(found[1].integral - (run.x[0] - start[0])) < 1e-11);
  CHECK(std::abs(found[2].integral - (run.x[1] - start[1])) < 1e-10);  // the contact force begins with the power 3/2
  CHECK(std::abs(found[3].integral - 0.5 * (run.x[0] * run.x[0] - start[0] * start[0])) < 1e-11);
  std::vector<double> times(40001);
  for (std::size_t i = 0; i < times.size(); ++i) times[i] = T * static_cast<double>(i) / 40000.0;
  const Matrix samples = sample(system, p, run, times);
  // Samples miss a maximum by at most x'' h^2 / 8.
  const double missed = found[2].largest - found[2].smallest, step = T / 40000.0;
  for (const Eigen::Index i : {0, 1}) {
    CHECK(found[static_cast<std::size_t>(i)].largest >= samples.col(i + 1).maxCoeff() - 1e-13);
    CHECK(found[static_cast<std::size_t>(i)].smallest <= samples.col(i + 1).minCoeff() + 1e-13);
  }
  CHECK(found[0].largest <= samples.col(1).maxCoeff() + missed * step * step / 8.0);
  CHECK(found[0].smallest >= samples.col(1).minCoeff() - missed * step * step / 8.0);
}

TEST_CASE("extents of functions that are not finite are NaN") {
  const HybridSystem system = make_oscillator("linear", "newton");
  Vector p = default_parameters(system.parameters);
  set(system, p, "r", 100.0);
  Graph graph;
  const Expression x = graph.state(0);
  const auto found = measured(system, p, vector({0.5, 0.0}), 2.0, graph, {x, graph.function(Operation::sqrt, graph.negate(x))});
  CHECK(std::isfinite(found[0].largest));
  CHECK(std::isnan(found[1].largest));
  CHECK(std::isnan(found[1].integral));
  CHECK_THROWS_AS(MotionFunctions(graph, {graph.rate(graph.rate(graph.rate(x)))}, 2), std::invalid_argument);
}
