// SPDX-License-Identifier: GPL-3.0-or-later
// A further command, `resonances`: conditions that graze does not have, along a branch of an undamped oscillator, and the
// branch that is born at one of them.
#include <graze/apps/commands/command.hpp>
#include <graze/apps/console/arguments.hpp>
#include <graze/apps/problem/problem.hpp>
#include <graze/continuation/conditions/multiplier_equations.hpp>
#include <graze/continuation/graph/branch_graph.hpp>
#include <graze/continuation/problems/orbit_problem.hpp>

#include <CLI/CLI.hpp>
#include <Eigen/SVD>
#include <fmt/format.h>

#include <memory>
#include <numbers>

using namespace graze;
using namespace graze::apps;

namespace {

/// A multiplier passes -1. The point is located by Newton's method.
TestFunction flip_test() {
  TestFunction test;
  test.type = PointType::UZ;
  test.condition = "multiplier -1";
  test.summary = "a multiplier passes -1";
  test.value = [](const TestPoint& point) {
    std::complex<double> product = 1.0;
    for (const auto& mu : nontrivial(point.branch.multipliers)) product *= 1.0 + mu;
    return product.real();
  };
  test.confirm = [](const TestPoint&, const TestPoint&) { return true; };
  test.distance = [](const BranchPoint& point) { return nearest_multiplier(point, -1.0); };
  test.equations = [](const TestPoint&) { return multiplier_equations({.theta = std::numbers::pi}); };
  return test;
}

/// The first orbit of three times the period: the orbit traversed three times, displaced along the eigenvector v of
/// sigma = e^(2 pi i/3). The motion is reversible, and the first node of a symmetric orbit is at rest: i conj(v_1) v, with v_1
/// the velocity, displaces its position only.
std::optional<BranchStart> tripled_start(const SpecialPoint& point, const Branch&, OrbitProblem& single, int side,
                                         const TraceOptions& options) {
  constexpr double push = 1e-2;
  const std::complex<double> i(0.0, 1.0), sigma = std::polar(1.0, 2.0 * std::numbers::pi / 3.0);
  const Vector u = single.pack(point.orbit.nodes, point.orbit.duration, point.value);
  if (!single.evaluate(u, {})) return std::nullopt;
  const Eigen::JacobiSVD<Eigen::MatrixXcd> svd(single.cyclic(u, sigma), Eigen::ComputeFullV);
  Eigen::VectorXcd v = svd.matrixV().rightCols(1);
  v *= i * std::conj(v[1]);
  OrbitProblem tripled = single.repeated(3);
  const Vector there = single.repeat(u, 3);
  Vector direction = Vector::Zero(there.size());
  direction.head(3 * v.size()) << v.real(), (sigma * v).real(), (sigma * sigma * v).real();
  direction *= side / direction.norm();
  BranchStart start;
  start.u = there + push * direction;
  if (!correct(tripled.zero_problem(), direction, start.u, options).converged()) return std::nullopt;
  start.orientation = start.u - there;
  start.states = tripled.branch_point(start.u, 0.0).states;
  start.step = push;
  return start;
}

/// The multipliers of an oscillator without damping pass e^(+-2 pi i/3), where their sum is -1.
TestFunction tripling_test() {
  TestFunction test = zero_test("multiplier e^(2 pi i/3)", [](const BranchPoint& point) {
    return 1.0 + (point.multipliers.values[0] + point.multipliers.values[1]).real();
  });
  test.born = Birth{.multiple = 3, .sides = {1, -1}, .missing = "no orbit of three times the period was found"};
  test.born->start = tripled_start;
  return test;
}

int run(const std::string& file, double to, const Console& console) {
  const Problem problem = load_problem(file);
  const PeriodicOrbit orbit = shoot(problem.system, problem.parameters, problem.start.value(), 1);
  ContinuationOptions options;
  options.parameter = "eta";
  options.to = to;
  options.further_tests = {flip_test(), tripling_test()};
  for (const Branch& branch : continue_orbit(problem.system, orbit, options)) {
    for (const SpecialPoint& point : branch.special_points)
      if (const auto name = point.details.find("condition"); name != point.details.end())
        console.out << fmt::format("{} {}: eta = {:.11g}\n", point.label, std::get<std::string>(name->second), point.value);
    if (!branch.parent) continue;
    const BranchPoint& end = branch.points.back();
    console.out << fmt::format("from {}: period {}, eta = {:.11g}, multiplier {:.8g}\n", branch.parent->label, branch.period,
                               end.value, end.multipliers.values[0].real());
  }
  return 0;
}

}  // namespace

Command resonances_command() {
  return {.name = "resonances",
          .summary = "resonances of an undamped oscillator",
          .details = "Follows an orbit in eta, and the branches that are born at its resonances.",
          .examples = {"own_program resonances undamped.toml --to 2.8"},
          .setup = [](CLI::App& app) -> std::function<int(const Console&)> {
            const auto file = std::make_shared<std::string>();
            const auto to = std::make_shared<std::optional<double>>();
            add_text(app, "PROBLEM", *file, "FILE", "the problem file", Need::required);
            add_number(app, "--to", *to, "last value of eta", Need::required);
            return [file, to](const Console& console) { return run(*file, to->value(), console); };
          }};
}
