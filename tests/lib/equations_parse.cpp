// SPDX-License-Identifier: GPL-3.0-or-later
// The grammar, and every message of the parser with its place. No text exhausts the stack or takes long.
#include "support/expressions.hpp"

#include <catch2/catch.hpp>
#include <fmt/format.h>

using namespace graze::equations;
using namespace graze::support;

namespace {

double number(const std::string& text) {
  Graph g;
  return static_cast<double>(value(g, read(g, text), {0.5L, {2.0L, 3.0L}, {5.0L, 7.0L}}));
}

/// The message of the mistake, without the file.
std::string mistake(const std::string& text) {
  Graph g;
  try {
    read(g, text);
  } catch (const EquationError& error) {
    return error.sentence().substr(5);
  }
  return "none";
}

std::vector<Expression> define(Graph& g, const std::vector<std::pair<std::string, std::string>>& definitions) {
  Source source{"text", ""};
  std::vector<Definition> list;
  std::size_t line = 0;
  for (const auto& [name, text] : definitions) {
    ++line;
    list.push_back({{name, {line, 1, name.size()}}, {text, {line, 10, text.size()}}});
    source.text += name + std::string(9 - std::min<std::size_t>(9, name.size()), ' ') + text + "\n";
  }
  return parse_definitions(g, source, list, two_and_two_scope(g), "definition");
}

}  // namespace

TEST_CASE("precedence: powers from the right before signs before products before sums") {
  REQUIRE(number("1 + 2*3") == 7.0);
  REQUIRE(number("(1 + 2)*3") == 9.0);
  REQUIRE(number("10 - 4 - 3") == 3.0);
  REQUIRE(number("16/4/2") == 2.0);
  REQUIRE(number("-2^2") == -4.0);
  REQUIRE(number("(-2)^2") == 4.0);
  REQUIRE(number("2^-1") == 0.5);
  REQUIRE(number("2^3^2") == 512.0);
  REQUIRE(number("-2*-3") == 6.0);
  REQUIRE(number("2 - -3") == 5.0);
  REQUIRE(number("+2 + +3") == 5.0);
  REQUIRE(number("2*x^2") == 8.0);
  REQUIRE(number("-x^2/v") == Approx(-4.0 / 3.0).epsilon(1e-15));
  REQUIRE(number("36/35") == 36.0 / 35.0);
  REQUIRE(number(".5 + 1e-1 + 2.5E+1") == 25.6);
  REQUIRE(number("cos(pi*t)") == Approx(0.0).margin(1e-15));
  REQUIRE(number("atan2(x, v) + hypot(3, 4)") == Approx(std::atan2(2.0, 3.0) + 5.0));
  REQUIRE(number("clamp(x, -1, 1) + clamp(x, 4, 5) + deadzone(v, 1) + deadzone(-v, 1)") == 5.0);
  REQUIRE(number("x # a comment = 3\n  + 1") == 3.0);
}

TEST_CASE("names may have Greek letters and characters that only look like operators are reported") {
  Graph g;
  REQUIRE(is_name("ξ_1"));
  REQUIRE(is_name("k₂"));
  REQUIRE(!is_name("2x"));
  REQUIRE(!is_name("x y"));
  REQUIRE(!is_name(""));
  CHECK(mistake("x − v") == "1:3: unexpected '−' in the test; write -");
  CHECK(mistake("x²") == "1:2: unexpected '²' in the test; write ^2");
  CHECK(mistake("x·v") == "1:2: unexpected '·' in the test; write *");
  CHECK(mistake("x § v") == "1:3: unexpected '§' in the test");
  CHECK(mistake("x + \xff") == "1:5: a byte 0xff that is no character in the test");
}

TEST_CASE("every mistake gives one sentence with its place") {
  CHECK(mistake("") == "1:1: nothing stands in the test");
  CHECK(mistake("  \n ") == "2:2: nothing stands in the test");
  CHECK(mistake("x +") == "1:4: an operand is missing at the end in the test");
  CHECK(mistake("x + * v") == "1:5: an operand is missing before '*' in the test");
  CHECK(mistake("x v") == "1:3: an operator is missing before 'v' in the test");
  CHECK(mistake("2x") == "1:2: an operator is missing before 'x' in the test");
  CHECK(mistake("x (v)") == "1:1: 'x' is not a function; write x*(...) for a product in the test");
  CHECK(mistake("(x)(v)") == "1:4: an operator is missing before '(' in the test");
  CHECK(mistake("2*(x + v") == "1:3: '(' is not closed in the test");
  CHECK(mistake("sin(x, (v)") == "1:4: '(' is not closed in the test");
  CHECK(mistake("x + v)") == "1:6: ')' without '(' in the test");
  CHECK(mistake("2*()") == "1:4: nothing stands between ( and ) in the test");
  CHECK(mistake("x, v") == "1:2: unexpected ',' in the test");
  CHECK(mistake("x = v") == "1:3: unexpected '=' in the test");
  CHECK(mistake("x; v") == "1:2: unexpected ';' in the test");
  CHECK(mistake("x*y") == "1:3: unknown name 'y' in the test");
  CHECK(mistake("v + xx") == "1:5: unknown name 'xx' in the test; did you mean 'x'?");
  CHECK(mistake("sine(x)") == "1:1: unknown function 'sine' in the test; did you mean 'sin'?");
  CHECK(mistake("sin + 1") == "1:1: the function sin needs its arguments in parentheses in the test");
  CHECK(mistake("sin()") == "1:1: sin takes 1 argument, not 0, in the test");
  CHECK(mistake("1 + atan2(x)") == "1:5: atan2 takes 2 arguments, not 1, in the test");
  CHECK(mistake("max(x, v, a)") == "1:1: max takes 2 arguments, not 3, in the test");
  CHECK(mistake("spline(x, v)") == "1:8: unknown table 'x' in the test");
  CHECK(mistake("spline(2, v)") == "1:8: spline takes the name of a table first in the test");
  CHECK(mistake("x/0") == "1:3: a division by zero in the test");
  CHECK(mistake("x/(v - v)") == "1:3: a division by zero in the test");
  CHECK(mistake("1.2.3") == "1:1: a number with two decimal points");
  CHECK(mistake("1e999") == "1:1: the number 1e999 is too large or too small");
  CHECK(mistake("t'") == "1:1: t' in the test: only a state or a definition has a rate");
  CHECK(mistake("(x + v)'") == "1:8: ' behind something that is no name in the test; only a state or a definition has a rate");
}

TEST_CASE("the caret stands under the name at fault") {
  Graph g;
  const std::string text = "xi*cos(etaa*t)";
  Scope scope = two_and_two_scope(g);
  scope.names.push_back("eta");
  const auto find = scope.find;
  scope.find = [&](std::string_view name) { return name == "xi" || name == "eta" ? g.parameter(0) : find(name); };
  const Source source{"duffing.toml", "[modes.free]\nequations = \"\"\"\n  v' = " + text + " - x\n"};
  REQUIRE_THROWS_WITH(parse_expression(g, source, {text + " - x", {3, 8, 18}}, scope, "in the equation of v"),
                      "duffing.toml:3:15: unknown name 'etaa' in the equation of v; did you mean 'eta'?\n"
                      "  v' = xi*cos(etaa*t) - x\n"
                      "              ^^^^");
}

TEST_CASE("depth and length are limited: no text exhausts the stack or takes long") {
  const std::string deep = "1:201: more than 200 parentheses, functions, signs and powers inside one another in the test";
  const auto repeat = [](const std::string& piece, int times) {
    std::string out;
    for (int i = 0; i < times; ++i) out += piece;
    return out;
  };
  CHECK(mistake(repeat("(", 100000) + "x" + repeat(")", 100000)) == deep);
  CHECK(mistake(repeat("(", 100000)) == deep);
  CHECK(mistake(repeat("-", 100000) + "x") == deep);
  CHECK(mistake(repeat("x^", 100000) + "x").find("more than 200") != std::string::npos);
  CHECK(mistake(repeat("sin(", 100000)).find("more than 200") != std::string::npos);
  CHECK(mistake(repeat("(", 150) + "x" + repeat(")", 150)) == "none");
  CHECK(mistake(repeat("x+", 600000) + "x") == "1:1: the text in the test has 1200001 bytes; at most 1048576 are read");
  // A long sum has no depth.
  REQUIRE(mistake(repeat("x*v/a+", 100000) + "x") == "none");
}

TEST_CASE("definitions are read in any order and each name is defined once") {
  Graph g;
  const auto values = define(g, {{"c", "a1 + b1"}, {"a1", "2*b1"}, {"b1", "x + 1"}, {"d", "c*c"}});
  REQUIRE(values[0] == read(g, "2*(x + 1) + (x + 1)"));
  REQUIRE(values[3] == read(g, "(2*(x + 1) + (x + 1))^2"));
  REQUIRE(define(g, {{"e", "x*v"}, {"p", "e'"}})[1] == g.rate(read(g, "x*v")));
}

TEST_CASE("a cycle among definitions is reported with the chain of names") {
  Graph g;
  REQUIRE_THROWS_WITH(define(g, {{"one", "x + two"}, {"two", "three*2"}, {"three", "v - two"}}),
                      "text:3:14: the definition two depends on itself: two -> three -> two\nthree    v - two\n             ^^^");
  REQUIRE_THROWS_WITH(define(g, {{"self", "1 + self"}}),
                      Catch::StartsWith("text:1:14: the definition self depends on itself: self -> self\n"));
  // A long cycle is shortened.
  std::vector<std::pair<std::string, std::string>> many;
  for (int i = 0; i < 20000; ++i) many.emplace_back(fmt::format("d{}", i), fmt::format("d{} + 1", (i + 1) % 20000));
  try {
    define(g, many);
    FAIL("no cycle was found");
  } catch (const EquationError& error) {
    REQUIRE(error.sentence() == "text:20000:10: the definition d0 depends on itself: d0 -> d1 -> d2 -> d3 -> d4 -> d5 -> ... -> "
                                "d19995 -> d19996 -> d19997 -> d19998 -> d19999 -> d0");
  }
}

TEST_CASE("ten thousand nested definitions have a graph of a few nodes each") {
  std::vector<std::pair<std::string, std::string>> many = {{"d0", "x"}};
  for (int i = 1; i < 10000; ++i)
    many.emplace_back(fmt::format("d{}", i), fmt::format("a*d{} + sin(d{})/(1 + v^2)", i - 1, i - 1));
  std::reverse(many.begin(), many.end());
  Graph g;
  const std::vector<Expression> values = define(g, many);
  REQUIRE(dependence(g, values[0]).states.size() == 2);
  REQUIRE(g.size() < 60000);
}

TEST_CASE("blocks: line breaks and semicolons separate equations and operators and parentheses continue them") {
  Graph g;
  const std::string text = "# a mode\nx' = v; v' = a*\n  x +\n b*(x\n -\n v)\n   - sin(x)  # last\n\n\n";
  const Source source{"text", text};
  const auto where = [](std::string_view name) { return fmt::format("in the equation of {}", name); };
  const auto block = [&](const std::string& of) {
    return parse_block(g, source, {of, {1, 1, 1}}, two_and_two_scope(g), where, "in the block");
  };
  const auto list = block(text);
  REQUIRE(list.size() == 2);
  REQUIRE(list[0].name == "x");
  REQUIRE(list[0].primed);
  REQUIRE(list[0].place.line == 2);
  REQUIRE(list[1].place.column == 9);
  REQUIRE(list[1].value == read(g, "a*x + b*(x - v) - sin(x)"));
  REQUIRE(!block("v = -a*v")[0].primed);
  REQUIRE(block(" ;; ").empty());
  const auto message_of = [&](const std::string& of) -> std::string {
    try {
      block(of);
    } catch (const EquationError& error) {
      return error.sentence();
    }
    return "none";
  };
  REQUIRE(message_of("x' = v\nv'") == "text:2:1: an equation \"name = expression\" was expected at 'v' in the block");
  REQUIRE(message_of("x' = v v' = x") == "text:1:11: a second '=' in the equation of x; is a line break or ; missing?");
  REQUIRE(message_of("x' = \nv' = x") == "text:1:5: nothing stands in the equation of x");
  REQUIRE(message_of("x' = (v\nv' = x") == "text:1:6: '(' is not closed in the equation of x");
  REQUIRE(message_of("x' = v\nv' = x +\n\n") == "text:2:9: an operand is missing at the end in the equation of v");
  REQUIRE(message_of("x' = v\nv' =\n") == "text:2:5: nothing stands in the equation of v");
  REQUIRE(message_of("x' = v +\nv' = x") == "text:1:9: an operand is missing at the end in the equation of x");
  REQUIRE(message_of("x' = v\n= 3") == "text:2:1: an equation \"name = expression\" was expected at '=' in the block");
}

TEST_CASE("damaged texts are parsed or refused with a place") {
  const std::vector<std::string> pieces = {"x", "v", "a",  "b",     "t",  "pi", "sin(", "max(",   "spline(", "(",   ")", "^",
                                           "-", "+", "*",  "/",     ",",  "'",  "=",    ";",      "1.5",     "1e3", "0", ".",
                                           "#", " ", "\n", "sqrt(", "zz", "ξ",  "\xce", "clamp(", "abs(",    "3"};
  std::mt19937 engine(4);
  int read_well = 0, refused = 0;
  for (int i = 0; i < 40000; ++i) {
    std::string text;
    for (std::size_t k = engine() % 12; k > 0; --k) text += pieces[engine() % pieces.size()];
    Graph g;
    try {
      const Expression e = read(g, text);
      ++read_well;
      if (!dependence(g, e).rate) REQUIRE(read(g, to_text(g, e, two_and_two())) == e);
    } catch (const EquationError& error) {
      ++refused;
      INFO(text);
      REQUIRE(error.place().line >= 1);
      REQUIRE(error.place().column >= 1);
    }
  }
  REQUIRE(read_well > 500);
  REQUIRE(refused > 500);
}
