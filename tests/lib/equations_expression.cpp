// SPDX-License-Identifier: GPL-3.0-or-later
// Expressions: simplification by the constructors, derivatives against differences, substitution, dependence, printing.
#include "support/expressions.hpp"

#include <catch2/catch.hpp>

using namespace graze::equations;
using namespace graze::support;

TEST_CASE("equal expressions are one node for any order of the operands of a sum or product") {
  Graph g;
  REQUIRE(read(g, "x*v + a") == read(g, "a + v*x"));
  REQUIRE(read(g, "2*(x + v)") == read(g, "(v + x)*2"));
  const std::size_t size = g.size();
  read(g, "2*(x + v)");
  REQUIRE(g.size() == size);
}

TEST_CASE("constructors simplify only exact cases") {
  Graph g;
  const Expression x = g.state(0);
  for (const char* text : {"0 + x", "x + 0", "x - 0", "1*x", "x*1", "x/1", "x^1", "--x", "x + 0*v", "x*v^0", "-(-x)",
                           "x - (v - v)", "x*(2 - 1)", "x/(6/6)", "x*sqrt(1)"})
    REQUIRE(read(g, text) == x);
  REQUIRE(read(g, "x - x") == g.constant(0.0));
  REQUIRE(read(g, "x/x") == g.constant(1.0));
  REQUIRE(read(g, "0/x") == g.constant(0.0));
  REQUIRE(read(g, "x*x*x") == read(g, "x^3"));
  REQUIRE(read(g, "(x^2)^3") == read(g, "x^6"));
  REQUIRE(read(g, "x^(1/2)") == read(g, "sqrt(x)"));
  REQUIRE(read(g, "sqrt(x)^3") == read(g, "x^(3/2)"));
  REQUIRE(read(g, "sqrt(x)^2") == x);
  REQUIRE(read(g, "sin(-x)") == read(g, "-sin(x)"));
  REQUIRE(read(g, "cos(-x)") == read(g, "cos(x)"));
  REQUIRE(read(g, "(-x)*(-v)") == read(g, "x*v"));
  REQUIRE(read(g, "sin(0) + cos(0) + exp(0) + sqrt(9) + abs(-2)") == g.constant(7.0));
  REQUIRE(read(g, "3*2 - 7/4") == g.constant(4.25));
  // 1/3 and 0.1 + 0.2 are not exact: they stay as written.
  REQUIRE(g.node(read(g, "1/3")).operation == Operation::divide);
  REQUIRE(g.node(read(g, "0.1 + 0.2")).operation == Operation::add);
  REQUIRE(g.node(read(g, "0.1*3")).operation == Operation::multiply);
  // Products keep their order: beta*x*x*x is not beta*x^3.
  REQUIRE(read(g, "a*x*x*x") != read(g, "a*x^3"));
}

TEST_CASE("first and second derivatives of random expressions agree with differences") {
  int compared = 0;
  for (unsigned seed = 1; seed <= 150; ++seed) {
    Graph g;
    RandomExpressions make(g, seed);
    const Expression e = make(4);
    Point at = make.point();
    const std::vector<std::pair<Expression, long double*>> symbols = {{g.state(0), &at.x[0]},
                                                                      {g.state(1), &at.x[1]},
                                                                      {g.parameter(0), &at.p[0]},
                                                                      {g.parameter(1), &at.p[1]},
                                                                      {g.time(), &at.t}};
    for (const auto& [symbol, coordinate] : symbols) {
      const Expression d = g.derivative(e, symbol);
      REQUIRE(g.derivative(e, symbol) == d);
      INFO("seed " << seed << ": " << to_text(g, e, two_and_two()));
      // Differences with one extrapolation; accurate to 1e-12 in long double.
      const auto slope_at = [&](Expression of, long double* where) {
        const long double middle = *where;
        const auto central = [&](long double h) {
          *where = middle + h;
          const long double above = value(g, of, at);
          *where = middle - h;
          const long double below = value(g, of, at);
          *where = middle;
          return (above - below) / (2.0L * h);
        };
        constexpr long double h = 2e-4L;
        return (4.0L * central(h / 2) - central(h)) / 3.0L;
      };
      const long double given = value(g, d, at);
      const long double wanted = slope_at(e, coordinate);
      REQUIRE(static_cast<double>(std::fabs(given - wanted)) < 1e-8 * (1.0 + static_cast<double>(std::fabs(given))));
      ++compared;
      for (const auto& [second, other] : symbols) {
        const long double twice = value(g, g.derivative(d, second), at);
        REQUIRE(static_cast<double>(std::fabs(twice - slope_at(d, other))) <
                1e-6 * (1.0 + static_cast<double>(std::fabs(twice))));
        // Schwarz: the order of differentiation does not matter.
        const long double exchanged = value(g, g.derivative(g.derivative(e, second), symbol), at);
        REQUIRE(static_cast<double>(std::fabs(twice - exchanged)) < 1e-13 * (1.0 + static_cast<double>(std::fabs(twice))));
      }
    }
  }
  REQUIRE(compared == 750);
}

TEST_CASE("nonsmooth functions and splines have the derivatives of their pieces") {
  Graph g;
  const Expression x = g.state(0);
  const auto slope = [&](const std::string& text, double at) {
    return static_cast<double>(value(g, g.derivative(read(g, text), x), {0.0L, {at, 0.0L}, {0.0L, 0.0L}}));
  };
  REQUIRE(slope("abs(x)", -2.0) == -1.0);
  REQUIRE(slope("max(x^2, 3*x)", 1.0) == 3.0);
  REQUIRE(slope("max(x^2, 3*x)", 4.0) == 8.0);
  REQUIRE(slope("min(x^2, 3*x)", 4.0) == 3.0);
  REQUIRE(slope("clamp(x, -1, 2)", 1.5) == 1.0);
  REQUIRE(slope("clamp(x, -1, 2)", 2.5) == 0.0);
  REQUIRE(slope("deadzone(x, 1)", 0.5) == 0.0);
  REQUIRE(slope("deadzone(x, 1)", -1.5) == 1.0);
  REQUIRE(slope("sign(x) + step(x)", 0.5) == 0.0);
}

TEST_CASE("splines: a clamped one reproduces a cubic, a periodic one a sine, with derivatives") {
  Table cubic{"cubic", {}, {}, false, 0.0, 0.0};
  const auto f = [](double u) { return 1.0 + u - 2.0 * u * u + 0.5 * u * u * u; };
  const auto df = [](double u) { return 1.0 - 4.0 * u + 1.5 * u * u; };
  for (const double u : {-1.0, 0.0, 0.3, 1.0, 2.5}) {
    cubic.u.push_back(u);
    cubic.y.push_back(f(u));
  }
  cubic.first_slope = df(-1.0);
  cubic.last_slope = df(2.5);
  const Spline spline = make_spline(cubic);
  for (double u = -1.0; u <= 2.5; u += 0.07) {
    REQUIRE(spline.value(0, u) == Approx(f(u)).margin(1e-13));
    REQUIRE(spline.value(1, u) == Approx(df(u)).margin(1e-13));
    REQUIRE(spline.value(2, u) == Approx(-4.0 + 3.0 * u).margin(1e-12));
    REQUIRE(spline.value(3, u) == Approx(3.0).margin(1e-11));
  }
  REQUIRE(spline.value(0, 3.5) == Approx(f(2.5) + df(2.5)));
  REQUIRE(spline.value(1, -7.0) == df(-1.0));

  Table wave{"wave", {}, {}, true};
  constexpr int n = 64;
  for (int i = 0; i <= n; ++i) {
    wave.u.push_back(2.0 * std::numbers::pi * i / n);
    wave.y.push_back(i == n ? 0.0 : std::sin(wave.u.back()));
  }
  const Spline periodic = make_spline(wave);
  for (double u = -10.0; u < 20.0; u += 0.37) {
    REQUIRE(std::abs(periodic.value(0, u) - std::sin(u)) < 1e-6);  // h^4/384
    REQUIRE(std::abs(periodic.value(1, u) - std::cos(u)) < 3e-5);
  }
  REQUIRE_THROWS_WITH(make_spline({"flat", {0.0, 0.0}, {1.0, 1.0}}), "table flat: its arguments do not increase");
  REQUIRE_THROWS_WITH(make_spline({"one", {0.0}, {1.0}}), "table one: it has 1 points; a spline needs 2");
  REQUIRE_THROWS_WITH(make_spline({"open", {0.0, 1.0, 2.0}, {1.0, 0.0, 2.0}, true}),
                      "table open: it is periodic, but its first value 1 is not its last 2");
}

TEST_CASE("substitution replaces symbols everywhere and simplifies the result") {
  Graph g;
  const Expression e = read(g, "(x - a)^2*cos(v) + (x - a)*v");
  const Replacement on_level{{g.state(0).index, g.parameter(0)}};
  REQUIRE(g.substitute(e, on_level) == g.constant(0.0));
  REQUIRE(g.substitute(e, {{g.state(1).index, read(g, "b*t")}}) == read(g, "(x - a)^2*cos(b*t) + (x - a)*(b*t)"));
  const Replacement exchange{{g.state(0).index, g.state(1)}, {g.state(1).index, g.state(0)}};
  REQUIRE(g.substitute(read(g, "x - 2*v"), exchange) == read(g, "v - 2*x"));
}

TEST_CASE("dependence lists states, parameters and time") {
  Graph g;
  const Dependence on = dependence(g, read(g, "cos(b*t)*v + 0*x"));
  REQUIRE(on.states == std::vector<std::size_t>{1});
  REQUIRE(on.parameters == std::vector<std::size_t>{1});
  REQUIRE(on.time);
  REQUIRE(!on.rate);
  REQUIRE(on.moves());
  REQUIRE(!dependence(g, read(g, "a/b + pi")).moves());
  REQUIRE(dependence(g, read(g, "x'")).rate);
}

TEST_CASE("an expression that is printed and parsed again is the same node") {
  for (unsigned seed = 1; seed <= 300; ++seed) {
    Graph g;
    RandomExpressions make(g, seed);
    Expression e = make(4);
    for (int order = 0; order < 2; ++order) {
      const std::string text = to_text(g, e, two_and_two());
      INFO("seed " << seed << ": " << text);
      // A contact power is printed as a power.
      if (text.size() > 20000) break;
      bool contact = false;
      for (const Expression part : reachable(g, e)) contact = contact || g.node(part).operation == Operation::contact_power;
      if (!contact) REQUIRE(read(g, text) == e);
      e = g.derivative(e, g.state(0));
    }
  }
  Graph g;
  REQUIRE(to_text(g, read(g, "-(x + 1)^2/(a*b) - -2e-3*v^-1"), two_and_two()) == "0.002*v^(-1) - (x + 1)^2/(a*b)");
  REQUIRE(to_text(g, read(g, "x + v + x*v"), two_and_two(), 5) == "x + v...");
}

TEST_CASE("long sums and deep chains of operations use no recursion") {
  Graph g;
  Expression e = g.state(0);
  for (int i = 0; i < 200000; ++i) e = g.add(g.multiply(e, g.parameter(0)), g.function(Operation::sin, g.state(1)));
  REQUIRE(dependence(g, e).states.size() == 2);
  const Expression d = g.derivative(e, g.state(0));
  REQUIRE(dependence(g, d).states.empty());
  REQUIRE(g.substitute(e, {{g.parameter(0).index, g.constant(0.0)}}) == g.function(Operation::sin, g.state(1)));
  REQUIRE(to_text(g, e, two_and_two(), 100).size() == 103);
}
