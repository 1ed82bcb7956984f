// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/source.hpp>

#include <catch2/catch.hpp>

using namespace graze::equations;

TEST_CASE("places count lines from the position of the text in its file and columns in characters") {
  const Source source{"beam.toml", "a = 1\nξ' = \"η·v + x\"\n"};
  const Text text{"η·v +\n  ξξ x", {2, 7, 9}};
  const Places places(text);
  REQUIRE(places(0, 2).column == 7);
  REQUIRE(places(4, 1).line == 2);  // v, after two characters of two bytes
  REQUIRE(places(4, 1).column == 9);
  const Place last = places(text.text.size() - 1, 1);
  REQUIRE(last.line == 3);
  REQUIRE(last.column == 6);
  REQUIRE(places(10, 100).length == 4);  // ends with its line
  REQUIRE(places(0, 100).length == 5);
  REQUIRE(characters("ξη v") == 4);
}

TEST_CASE("an equation error shows its line with carets under the characters of the place and keeps tabs") {
  const Source source{"beam.toml", "a = 1\n\tξ' = η + etaa*x\nlast"};
  const EquationError error(source, {2, 12, 4}, "unknown name 'etaa'");
  REQUIRE(error.sentence() == "beam.toml:2:12: unknown name 'etaa'");
  REQUIRE(std::string(error.what()) == "beam.toml:2:12: unknown name 'etaa'\n"
                                       "\tξ' = η + etaa*x\n"
                                       "\t          ^^^^");
  REQUIRE(std::string(EquationError(source, {3, 5, 9}, "missing").what()) == "beam.toml:3:5: missing\nlast\n    ^");
  REQUIRE(std::string(EquationError(source, {}, "no states").what()) == "beam.toml: no states");
}

TEST_CASE("of a long line an equation error shows the part around the place") {
  Source source{"long", std::string(5000, '(')};
  source.text += "ξ";
  source.text.append(5000, ')');
  const EquationError error(source, {1, 5001, 1}, "here");
  const std::string what = error.what();
  REQUIRE(what.size() < 500);
  REQUIRE(what.find("\n...((((") != std::string::npos);
  const std::size_t caret = what.rfind('\n') + 1;
  const std::size_t line = what.find('\n') + 1;
  REQUIRE(what.find("ξ") - line == what.find('^') - caret);
}

TEST_CASE("strings of a file begin after their quotes") {
  const Source source{"f", "a = \"x + 1\"\nb = \"\"\"\n  x' = v\n\"\"\"\nc = \"\"\"y\"\"\"\nd = 'z'\n"};
  REQUIRE(quoted_text(source, {1, 5, 7}, "x + 1").place.column == 6);
  const Text block = quoted_text(source, {2, 5, 3}, "  x' = v\n");
  REQUIRE(block.place.line == 3);
  REQUIRE(block.place.column == 1);
  REQUIRE(quoted_text(source, {5, 5, 3}, "y").place.column == 8);
  REQUIRE(quoted_text(source, {6, 5, 3}, "z").place.column == 6);
}
