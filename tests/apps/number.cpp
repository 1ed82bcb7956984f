// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/text/number.hpp>

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>
#include <numbers>

using namespace graze;
using namespace graze::apps;

TEST_CASE("numbers are read with fractions and pi and signs") {
  CHECK(parse_number("0.05") == 0.05);
  CHECK(parse_number("-1e-3") == -1e-3);
  CHECK(parse_number("+2") == 2.0);
  CHECK(parse_number(".5") == 0.5);
  CHECK(parse_number("36/35") == 36.0 / 35.0);
  CHECK(parse_number(" 2 * pi ") == 2.0 * std::numbers::pi);
  CHECK(parse_number("-pi/4") == -std::numbers::pi / 4.0);
  CHECK(parse_number("2*pi/0.95") == 2.0 * std::numbers::pi / 0.95);
  CHECK(parse_number("1/-4") == -0.25);
  CHECK(std::isnan(*parse_number("nan")));
  CHECK(std::isinf(*parse_number("1/0")));
}

TEST_CASE("invalid numbers are refused") {
  for (const char* text : {"", " ", "x", "1.2.3", "1/", "/2", "2pi", "1 2", "--1", "+-1", "0x10", "1,5", "1e", "3*", "pie"}) {
    INFO(text);
    CHECK(parse_number(text) == std::nullopt);
  }
}

TEST_CASE("a number that no double holds is distinguished from an invalid one") {
  for (const char* text : {"1e400", "-1e400", "1e-400", "2*1e999"}) {
    INFO(text);
    CHECK(parse_number(text) == std::nullopt);
    CHECK(is_beyond_double(text));
    CHECK(no_number(text).find("not a number") == std::string::npos);
  }
  for (const char* text : {"1e308", "5e-324", "x", "", "1e", "1,5"}) CHECK_FALSE(is_beyond_double(text));
  CHECK(no_number("x").find("\"x\" is not a number") == 0);
}

TEST_CASE("integers are read and other numbers are refused") {
  CHECK(parse_count("1000") == 1000);
  CHECK(parse_count("1e3") == 1000);
  CHECK(parse_count("-2") == -2);
  for (const char* text : {"1.5", "1e10", "nan", "inf", "ten"}) {
    INFO(text);
    CHECK(parse_count(text) == std::nullopt);
  }
}

TEST_CASE("states are read") {
  const std::optional<Vector> state = parse_numbers("-0.169,-0.962");
  REQUIRE(state);
  CHECK(*state == Vector{{-0.169, -0.962}});
  CHECK(parse_numbers("1,2,pi")->size() == 3);
  CHECK_FALSE(parse_numbers("1,"));
  CHECK_FALSE(parse_numbers("1;2"));
}

TEST_CASE("exact text reads back to the same double") {
  for (const double value :
       {0.1, 1.0 / 3.0, 0.919542643087348, -1e-300, 5e-324, std::numeric_limits<double>::max(), std::nextafter(2.0, 3.0)}) {
    CHECK(parse_number(exact(value)) == value);
  }
}

TEST_CASE("rounded text is for people") {
  CHECK(rounded(0.919542643087348, 12) == "0.919542643087");
  CHECK(rounded(2.0) == "2");
  CHECK(rounded({0.609338, -0.365643}) == "0.609338 - 0.365643 i");
  CHECK(rounded({-1.0, 0.0}) == "-1");
}
