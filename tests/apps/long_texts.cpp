// SPDX-License-Identifier: GPL-3.0-or-later
// Texts that are output while they are made: lists on several threads, JSON without a tree, files.
#include "graze_program.hpp"

#include <graze/apps/console/output_file.hpp>
#include <graze/apps/results/sweep_report.hpp>
#include <graze/apps/text/json_text.hpp>
#include <graze/apps/text/write_items.hpp>

#include <catch2/catch.hpp>
#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <stdexcept>

using namespace graze;
using namespace graze::apps;
using namespace graze::support;
using Catch::Matchers::Contains;

TEST_CASE("a list written item by item is the same text on any number of threads") {
  for (const std::size_t size : {0U, 1U, 36U, 37U, 500U}) {
    const LongList list{"list", size, [](std::size_t k, std::string& text) {
                          text += (k % 3 == 0 ? Json::object() : Json{{"k", k}, {"numbers", std::vector<double>(k, 0.1)}}).dump();
                        }};
    const Json head = {{"before", 1}, {"list", nullptr}, {"after", {{"x", 2}}}};
    for (const int threads : {1, 3}) {
      const auto text_of = [threads](const Json& json, const LongList& items) {
        return whole_text([&](const TextSink& sink) { pretty(json, items, threads, sink); });
      };
      const Json whole = with_items(head, list, threads);
      CHECK(whole["list"].size() == size);
      CHECK(text_of(head, list) == pretty(whole));
      CHECK(text_of(whole, {}) == pretty(whole));
    }
  }
}

TEST_CASE("items of a list are output in their order and once each for any computing times") {
  for (const std::size_t size : {0U, 1U, 16U, 17U, 5000U})
    for (const int threads : {1, 2, 5}) {
      std::string expected;
      for (std::size_t k = 0; k < size; ++k) expected += std::to_string(k) + ",";
      const std::string text = whole_text([&](const TextSink& sink) {
        write_items(threads, size, sink, [](std::size_t k, std::string& out) {
          double work = 1.0;
          for (std::size_t i = 0; i < (k * 7919) % 1000; ++i) work = std::sin(work);
          out += std::to_string(k) + (work > 2.0 ? "" : ",");
        });
      });
      CHECK(text == expected);
    }
}

TEST_CASE("an exception from a sink or an item ends the making of a long text") {
  const auto number = [](std::size_t k, std::string& out) { out += std::to_string(k); };
  const auto refuse_the_later = [](std::size_t k, std::string&) {
    if (k > 1500) throw std::length_error("an item");
  };
  for (const int threads : {1, 3}) {
    std::size_t pieces = 0;
    const TextSink full = [&pieces](std::string_view) {
      if (++pieces == 3) throw std::runtime_error("full");
    };
    CHECK_THROWS_WITH(write_items(threads, 2000, full, number), "full");
    CHECK(pieces == 3);
    CHECK_THROWS_AS(write_items(
                        threads, 2000, [](std::string_view) {}, refuse_the_later),
                    std::length_error);
  }
}

TEST_CASE("JSON written as text equals the text of its tree") {
  const double infinity = std::numeric_limits<double>::infinity();
  const std::vector<std::string> texts = {"plain", "a \"b\"\n\\", "z = \u221e/1", ""};
  const std::vector<std::complex<double>> pair = {{0.5, -0.25}, {0.5, 0.25}};
  std::string text;
  JsonText json(text);
  json.begin_object();
  json.member("whole", -3);
  json.member("large", std::numeric_limits<std::int64_t>::max());
  json.member("truth", true);
  json.member("nothing", std::optional<int>());
  json.member("something", std::optional(7));
  json.member("texts", texts);
  json.member("pair", pair);
  json.member("states", std::vector<Vector>{Vector{{1.0, -0.5}}, Vector()});
  json.member("no number", std::vector{std::nan(""), infinity, -infinity});
  json.key("list");
  json.begin_list();
  json.begin_object();
  json.end_object();
  json.value("b");
  json.begin_list();
  json.end_list();
  json.end_list();
  json.member("last \"name\"", 0.0);
  json.end_object();
  const Json tree = {{"whole", -3},
                     {"large", std::numeric_limits<std::int64_t>::max()},
                     {"truth", true},
                     {"nothing", nullptr},
                     {"something", 7},
                     {"texts", texts},
                     {"pair", {{0.5, -0.25}, {0.5, 0.25}}},
                     {"states", {{1.0, -0.5}, Json::array()}},
                     {"no number", {nullptr, nullptr, nullptr}},
                     {"list", {Json::object(), "b", Json::array()}},
                     {"last \"name\"", 0.0}};
  CHECK(text == tree.dump());
}

TEST_CASE("numbers in JSON written as text read back to the same double and stay doubles") {
  std::mt19937_64 random(11);
  std::vector<double> numbers = {0.1, 5e-324, std::numeric_limits<double>::max(), -0.0, 1.0, 1e22, 123456789.0, 1e-7};
  for (int i = 0; i < 20000; ++i) {
    double value = 0.0;
    const std::uint64_t bits = random();
    std::memcpy(&value, &bits, sizeof value);
    if (std::isfinite(value)) numbers.push_back(value);
  }
  const Json back = tree_of([&](JsonText& json) { json.value(numbers); });
  REQUIRE(back.size() == numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    CHECK(back[i].is_number_float());
    CHECK(back[i].get<double>() == numbers[i]);
    CHECK(std::signbit(back[i].get<double>()) == std::signbit(numbers[i]));
  }
}

TEST_CASE("a row of a sweep reads back from its text") {
  SweepRow row;
  row.value = 0.95;
  row.direction = SweepDirection::down;
  Attractor& attractor = row.attractor;
  attractor.type = AttractorType::periodic;
  attractor.period = 2;
  attractor.impacts = 5;
  attractor.isolated_impacts = 4;
  attractor.state = Vector{{0.1, -2.0}};
  attractor.multipliers = {{0.0, 0.0}, {0.0, 0.0}};
  attractor.exponents = {-0.05, -std::numeric_limits<double>::infinity()};
  attractor.standard_errors = {0.0, 0.0};
  row.end = attractor.state;
  row.states = {attractor.state, Vector{{1.0, 1e-300}}};
  row.impact_speeds = {0.3, 1e-9};
  const Json json = rows_json({row});
  CHECK(json[0]["attractor"]["sticking"] == true);
  CHECK(json[0]["exponents"][1].is_null());
  const std::vector<SweepRow> back = value_of<std::vector<SweepRow>>(json);
  REQUIRE(back.size() == 1);
  CHECK(rows_json(back) == json);
  CHECK(back[0].value == row.value);
  CHECK(back[0].direction == row.direction);
  CHECK(back[0].states == row.states);
  CHECK(back[0].impact_speeds == row.impact_speeds);
  CHECK(back[0].attractor.exponents == attractor.exponents);
  CHECK(back[0].attractor.multipliers == attractor.multipliers);
  CHECK(back[0].attractor.isolated_impacts == 4);
}

TEST_CASE("a file is written piece by piece and stays as it was if its text fails") {
  const TemporaryFolder folder;
  const std::string file = folder.write("result.json", "before");
  const LongText failing = [](const TextSink& sink) {
    sink("half");
    throw std::runtime_error("interrupted");
  };
  CHECK_THROWS_WITH(write_whole(file, failing), "interrupted");
  CHECK(read_file(file) == "before");
  CHECK(folder.files() == 1);
  const LongText pieces = [](const TextSink& sink) {
    for (const char* piece : {"one ", "", "two"}) sink(piece);
  };
  CHECK_FALSE(write_whole(file, pieces));
  CHECK(read_file(file) == "one two");
  CHECK_FALSE(write_whole(file, [](const TextSink&) {}));
  CHECK(read_file(file).empty());
  CHECK(folder.files() == 1);
  // If the disk is full the rest of the text is not made.
  std::size_t made = 0;
  const LongText endless = [&made](const TextSink& sink) {
    for (; made < 1000; ++made) sink("x");
  };
  const std::optional<std::string> failure = write_whole("/dev/full", endless);
  REQUIRE(failure);
  CHECK_THAT(*failure, Contains("/dev/full: cannot be written: No space left on device"));
  CHECK(made == 0);
}

TEST_CASE("a file of many megabytes is complete or stays as it was if its text fails") {
  const TemporaryFolder folder;
  const std::string file = folder.write("result.csv", "before");
  constexpr int pieces = 30, lines = 40000;
  std::string piece;
  for (int k = 0; k < lines; ++k) piece += fmt::format("{},{}\n", k, 7 * k);
  REQUIRE(pieces * piece.size() > (std::size_t{12} << 20));  // several times the amount written at once
  const LongText failing = [&piece](const TextSink& sink) {
    for (int k = 0; k < pieces; ++k) sink(piece);
    throw std::runtime_error("interrupted");
  };
  CHECK_THROWS_WITH(write_whole(file, failing), "interrupted");
  CHECK(read_file(file) == "before");
  CHECK(folder.files() == 1);
  const LongText numbered = [&piece](const TextSink& sink) {
    for (int k = 0; k < pieces; ++k) sink(fmt::format("{}:\n{}", k, piece));
  };
  CHECK_FALSE(write_whole(file, numbered));
  CHECK(read_file(file) == whole_text(numbered));
  CHECK(folder.files() == 1);
}
