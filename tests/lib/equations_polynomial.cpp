// SPDX-License-Identifier: GPL-3.0-or-later
// Normal forms, proofs that an expression vanishes, and bounds. From these follow levels, solutions of guards, and rebounds.
#include "support/expressions.hpp"

#include <graze/lib/equations/structure.hpp>

#include <catch2/catch.hpp>

using namespace graze;
using namespace graze::equations;
using namespace graze::support;

namespace {

ParameterInfo ranged(const std::string& name, double lower, double upper, bool open) {
  ParameterInfo info;
  info.name = name;
  info.lower = lower;
  info.upper = upper;
  info.lower_open = open;
  return info;
}

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Parameter a is positive; b has any sign.
const std::vector<ParameterInfo> ranges = {ranged("a", 0.0, infinity, true), ranged("b", -infinity, infinity, false)};

}  // namespace

TEST_CASE("expressions that are equal when expanded have one normal form") {
  Graph g;
  const auto same = [&](const std::string& a, const std::string& b) {
    INFO(a << " and " << b);
    REQUIRE(normal_form(g, read(g, a)) == normal_form(g, read(g, b)));
    REQUIRE(is_zero(g, read(g, "(" + a + ") - (" + b + ")")));
  };
  same("(x + v)^2", "x^2 + 2*x*v + v^2");
  same("x*(v - a) - b*(x - 1)", "-x*(a + b - v) + b");
  same("(x^2 - v^2)/(2*a)", "(x - v)*(x + v)/a/2");
  same("a*x/(1 + v^2) + x*b/(v*v + 1)", "x*(a + b)*(1 + v^2)^-1");
  same("cos(a*(t + 1))", "cos(a*t + a)");
  same("sqrt(x - v)*x - x*sqrt(-v + x)", "0*x");
  same("(x - a)^(3/2)", "(-a + x)^1.5");
  same("sin(x - x*1 + v)", "sin(v)");
  REQUIRE(!is_zero(g, read(g, "x^2 - v^2")));
  REQUIRE(!is_zero(g, read(g, "sqrt(x^2) - x")));    // |x| - x
  REQUIRE(!is_zero(g, read(g, "0.1 + 0.2 - 0.3")));  // as decimal numbers of the file they differ
}

TEST_CASE("normal forms of random expressions keep their values") {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    Graph g;
    RandomExpressions make(g, seed);
    const Expression e = make(4);
    const Point at = make.point();
    const long double wanted = value(g, e, at), given = value(g, normal_form(g, e), at);
    INFO("seed " << seed << ": " << to_text(g, e, two_and_two()));
    REQUIRE(static_cast<double>(std::fabs(wanted - given)) < 1e-14 * (1.0 + static_cast<double>(std::fabs(wanted))));
  }
}

TEST_CASE("nested functions and long chains are expanded in linear time") {
  Graph g;
  Expression e = g.state(0);
  for (int i = 0; i < 2000; ++i) e = g.function(Operation::sin, g.add(g.multiply(g.parameter(0), e), g.state(1)));
  REQUIRE(normal_form(g, e) != g.constant(0.0));
  REQUIRE(is_zero(g, g.subtract(g.multiply(g.constant(2.0), e), g.add(e, e))));
}

TEST_CASE("bounds of random expressions enclose their values") {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    Graph g;
    RandomExpressions make(g, seed);
    const Expression e = make(3);
    const std::vector<ParameterInfo> positive = {ranged("a", 0.2, 1.2, false), ranged("b", 0.0, infinity, true)};
    const Bounds range = bounds(g, e, positive);
    INFO("seed " << seed << ": " << to_text(g, e, two_and_two()));
    for (int i = 0; i < 20; ++i) {
      const auto at = value(g, e, make.point());
      REQUIRE(static_cast<double>(at) >= range.lower - 1e-12 * std::abs(range.lower));
      REQUIRE(static_cast<double>(at) <= range.upper + 1e-12 * std::abs(range.upper));
    }
  }
  Graph g;
  REQUIRE(bounds(g, read(g, "x^2 + v^2"), ranges).lower == 0.0);
  REQUIRE(bounds(g, read(g, "1 + x^2*b^2"), ranges).lower == 1.0);
  REQUIRE(bounds(g, read(g, "a"), ranges).lower > 0.0);
  REQUIRE(bounds(g, read(g, "exp(x) + cosh(v)"), ranges).lower == 1.0);
  REQUIRE(bounds(g, read(g, "-abs(x) - 2"), ranges).upper == -2.0);
  REQUIRE(bounds(g, read(g, "x - v"), ranges).lower == -infinity);
}

TEST_CASE("guards: levels are recognised however they are written") {
  Graph g;
  for (const char* text : {"x - a", "-a + x", "-(a - x)", "(2*x - 2*a)/2", "x + v - (a + v)"}) {
    INFO(text);
    const auto level = recognise_level(g, read(g, text));
    REQUIRE(level.has_value());
    REQUIRE(level->coordinate == 0);
    REQUIRE(level->level == 0);
    REQUIRE(level->sign == 1.0);
  }
  REQUIRE(recognise_level(g, read(g, "b - v"))->sign == -1.0);
  REQUIRE(recognise_level(g, read(g, "b - v"))->coordinate == 1);
  for (const char* text : {"x + a", "x - 1", "2*x - 2*a", "x - a*b", "x - a - b", "x - v", "x^2 - a", "x - a + t"}) {
    INFO(text);
    REQUIRE(!recognise_level(g, read(g, text)));
  }
}

TEST_CASE("guards are solved for a state in which they are linear and a field difference that vanishes there is found") {
  Graph g;
  const auto any = [](std::size_t) { return true; };
  const auto solution = solve_guard(g, read(g, "a - 2*x + sin(v)"), 2, any);
  REQUIRE(solution->state == 0);
  REQUIRE(normal_form(g, solution->value) == normal_form(g, read(g, "(a + sin(v))/2")));
  REQUIRE(solve_guard(g, read(g, "x^2 + v"), 2, any)->state == 1);
  REQUIRE(!solve_guard(g, read(g, "x^2 + sin(v)"), 2, any));
  REQUIRE(!solve_guard(g, read(g, "a*x - b"), 2, any));  // a may be zero
  REQUIRE(!solve_guard(g, read(g, "x + sin(x)"), 2, any));
  REQUIRE(vanishes_on(g, read(g, "b*(x - a)*v"), read(g, "x - a"), ranges));
  REQUIRE(vanishes_on(g, read(g, "b*(x^2 + v^2 - 1)"), read(g, "1 - x^2 - v^2"), ranges));
  REQUIRE(vanishes_on(g, read(g, "a*b*x + b*sin(v)"), read(g, "a*x + sin(v)"), ranges));
  REQUIRE(vanishes_on(g, read(g, "b*(sqrt(x^2 + v^2) - a)*x/sqrt(x^2 + v^2)"), read(g, "sqrt(x^2 + v^2) - a"), ranges));
  REQUIRE(vanishes_on(g, read(g, "sin(x)*v - a*v"), read(g, "2*a - 2*sin(x)"), ranges));
  REQUIRE(!vanishes_on(g, read(g, "b*(x - a)*v + v"), read(g, "x - a"), ranges));
  REQUIRE(!vanishes_on(g, read(g, "b*(sqrt(x^2 + v^2) - a)*x + v"), read(g, "sqrt(x^2 + v^2) - a"), ranges));
  REQUIRE(!vanishes_on(g, read(g, "sqrt(x^2 + v^2) - a"), read(g, "b*sqrt(x^2 + v^2) - a*b"), ranges));  // b may be zero
}

TEST_CASE("rebounds: the level and a parameter that reverses the speed") {
  Graph g;
  const auto level = recognise_level(g, read(g, "x - a"));
  const auto rebound = [&](const std::string& x, const std::string& v) {
    return recognise_rebound(g, {read(g, x), read(g, v)}, level);
  };
  REQUIRE(rebound("x", "-b*v")->coefficient == 1);
  REQUIRE(rebound("a", "-(v*b)")->level == 0);
  REQUIRE(!rebound("x", "b*v"));
  REQUIRE(!rebound("x", "-0.8*v"));
  REQUIRE(!rebound("x", "-b*v + 1"));
  REQUIRE(!rebound("x", "-b*x"));
  REQUIRE(!rebound("b", "-b*v"));
}
