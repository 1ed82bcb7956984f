// SPDX-License-Identifier: GPL-3.0-or-later
// The tape against plain recursion in long double, and its parts. Each common subexpression is computed once.
#include "support/expressions.hpp"

#include <graze/lib/equations/tape.hpp>

#include <catch2/catch.hpp>

#include <thread>

using namespace graze::equations;
using namespace graze::support;

TEST_CASE("tapes of random expressions and their derivatives agree with recursion in double and in long double") {
  double worst = 0.0, worst_long = 0.0;
  for (unsigned seed = 1; seed <= 300; ++seed) {
    Graph g;
    RandomExpressions make(g, seed);
    std::vector<Expression> outputs = {make(4), make(3), g.constant(0.5)};
    outputs.push_back(g.derivative(outputs[0], g.state(0)));
    outputs.push_back(g.derivative(outputs[3], g.parameter(1)));
    const Tape tape(g, outputs);
    const Point at = make.point();
    const std::vector<double> x(at.x.begin(), at.x.end()), p(at.p.begin(), at.p.end());
    std::vector<double> workspace(tape.workspace()), out(tape.outputs());
    tape.evaluate<double>(static_cast<double>(at.t), x.data(), p.data(), workspace.data(), out.data());
    std::vector<long double> long_workspace(tape.workspace()), long_out(tape.outputs());
    tape.evaluate<long double>(at.t, at.x.data(), at.p.data(), long_workspace.data(), long_out.data());
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      const long double wanted = value(g, outputs[i], at), scale = 1.0L + std::fabs(wanted);
      worst = std::max(worst, static_cast<double>(std::fabs(out[i] - wanted) / scale));
      worst_long = std::max(worst_long, static_cast<double>(std::fabs(long_out[i] - wanted) / scale));
    }
  }
  INFO(worst << ", in long double " << worst_long);
  // Conditioning: a few operations amplify rounding errors (1.1e-16 and 5.4e-20).
  REQUIRE(worst < 1e-13);
  REQUIRE(worst_long < 5e-17);
}

TEST_CASE("a tape computes each common part once, sine and cosine together, and its parts by their dependence") {
  Graph g;
  const std::vector<Expression> outputs = {read(g, "a/b*cos(a*t)*x + sin(a*t)"), read(g, "sin(a*t)*(a/b) + v^2")};
  const Tape tape(g, outputs);
  // a, b, a/b, t, a t, sin and cos, (a/b) cos, (a/b) sin, x, v, v^2, (...) x, two sums.
  REQUIRE(tape.workspace() == 15);
  REQUIRE(tape.length(Tape::of_parameters) == 1);
  REQUIRE(tape.length(Tape::of_time) == 5);
  REQUIRE(tape.length(Tape::of_states) == 4);
  // Unrequested parts are not computed.
  const Expression only = read(g, "x + 1");
  REQUIRE(Tape(g, std::span(&only, 1)).workspace() == 3);
  // The parts can run one by one.
  std::vector<double> workspace(tape.workspace());
  const double p[2] = {0.7, 1.3};
  tape.run<double>(Tape::of_parameters, 0.0, nullptr, p, workspace.data());
  tape.run<double>(Tape::of_time, 2.0, nullptr, nullptr, workspace.data());
  for (const double v : {0.5, 1.5}) {
    const double x[2] = {0.3, v};
    tape.run<double>(Tape::of_states, 0.0, x, nullptr, workspace.data());
    REQUIRE(tape.output(0, workspace.data()) == 0.7 / 1.3 * std::cos(0.7 * 2.0) * 0.3 + std::sin(0.7 * 2.0));
    REQUIRE(tape.output(1, workspace.data()) == std::sin(0.7 * 2.0) * (0.7 / 1.3) + v * v);
  }
}

TEST_CASE("integer powers are products and contact powers vanish outside their contact") {
  // Nine products, each rounded once.
  for (int n = -9; n <= 9; ++n) REQUIRE(integer_power(1.7, n) == Approx(std::pow(1.7, n)).epsilon(2e-15));
  REQUIRE(integer_power(-3.0, 3) == -27.0);
  REQUIRE(contact_power(-0.1, 1.5) == 0.0);
  REQUIRE(contact_power(0.0, 0.5) == 0.0);
  REQUIRE(contact_power(4.0, 1.5) == 8.0);
  REQUIRE(contact_power(2.0, 1.3) == std::pow(2.0, 1.3));
}

TEST_CASE("several threads share one tape, each with its own workspace") {
  Graph g;
  RandomExpressions make(g, 3);
  const Expression e = make(6);
  const Tape tape(g, std::span(&e, 1));
  const Point at = make.point();
  const auto sum = [&] {
    std::vector<double> workspace(tape.workspace());
    double total = 0.0, out = 0.0;
    for (int i = 0; i < 2000; ++i) {
      const double x[2] = {0.2 + i / 4000.0, 0.4}, p[2] = {0.5, 0.6};
      tape.evaluate<double>(static_cast<double>(at.t), x, p, workspace.data(), &out);
      total += out;
    }
    return total;
  };
  const double alone = sum();
  double first = 0.0, second = 0.0;
  std::thread one([&] { first = sum(); }), two([&] { second = sum(); });
  one.join();
  two.join();
  REQUIRE(first == alone);
  REQUIRE(second == alone);
}

TEST_CASE("a tape refuses a rate that no mode has resolved") {
  Graph g;
  const Expression e = read(g, "x' + 1");
  REQUIRE_THROWS_WITH(Tape(g, std::span(&e, 1)), "a rate was evaluated before its mode was known");
}
