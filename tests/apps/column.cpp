// SPDX-License-Identifier: GPL-3.0-or-later
// Lists of columns, and the formats that follow from them.
#include "json_schema.hpp"

#include <graze/apps/text/column.hpp>

#include <catch2/catch.hpp>

#include <limits>

using namespace graze;
using namespace graze::apps;
using namespace graze::support;

namespace {

enum class Colour { red, green };
std::string_view colour_name(Colour colour) { return colour == Colour::red ? "red" : "green"; }

struct Part {
  int count = 0;
};
struct Thing {
  double length = 0.0;
  std::optional<double> mass;
  Colour colour = Colour::red;
  Vector place;
  std::vector<std::complex<double>> roots;
  std::vector<Part> parts;
  std::string note;
  int twice() const { return 2 * static_cast<int>(parts.size()); }
};

const Columns<Part>& part_columns() {
  static const Columns<Part> list = {{"count", "of the part", &Part::count}};
  return list;
}
const Columns<Thing>& thing_columns();

}  // namespace

namespace graze::apps {
template <> struct JsonForm<Colour> : ChoiceForm<Colour, colour_name, Colour::red, Colour::green> {};
template <> struct JsonForm<Part> : RecordForm<Part, part_columns> {};
template <> struct JsonForm<Thing> : RecordForm<Thing, thing_columns> {};
}  // namespace graze::apps

namespace {

const Columns<Thing>& thing_columns() {
  static const Columns<Thing> list = {
      {"length [m]", "from end to end", &Thing::length},
      {"mass", "null: not known", &Thing::mass},
      {"colour", "of the surface", &Thing::colour},
      {"place", "in the room", &Thing::place},
      {"roots", "of its polynomial", &Thing::roots},
      {"parts", "that it is made of", &Thing::parts},
      {"twice", "as many as parts", &Thing::twice},
      {"note", "where there is one", &Thing::note, only([](const Thing& thing) { return !thing.note.empty(); })}};
  return list;
}

Thing thing() { return {0.1, std::nullopt, Colour::green, Vector{{1.0, -1e-300}}, {{0.5, 0.25}, {0.5, -0.25}}, {{3}, {4}}, {}}; }

}  // namespace

TEST_CASE("columns: JSON as a tree and as a text are the same and are read back") {
  Thing one = thing();
  for (const char* note : {"", "as new"}) {
    one.note = note;
    const Json json = json_of(one);
    CHECK(json.contains("note") == !one.note.empty());
    std::string text;
    JsonText writer(text);
    JsonForm<Thing>::write(one, writer);
    CHECK(text == flat(json));
    const Thing back = value_of<Thing>(Json::parse(text));
    CHECK(json_of(back) == json);
    CHECK(back.place == one.place);
    CHECK(back.roots == one.roots);
    CHECK(back.parts[1].count == 4);
  }
}

TEST_CASE("columns: missing members and wrong types are refused") {
  for (const char* name : {"length", "mass", "colour", "place", "roots", "parts"}) {
    INFO(name);
    Json json = json_of(thing());
    json.erase(name);
    CHECK_THROWS_AS(value_of<Thing>(json), Json::exception);
    json[name] = Json::object({{"a", "b"}});
    CHECK_THROWS(value_of<Thing>(json));
  }
  Json json = json_of(thing());
  json["colour"] = "blue";
  CHECK_THROWS_AS(value_of<Thing>(json), std::invalid_argument);
  json = json_of(thing());
  json.erase("twice");  // it follows from the parts
  CHECK(value_of<Thing>(json).twice() == 4);
}

TEST_CASE("columns: a schema has the members, their units, and the optional ones") {
  const Json schema = schema_of(thing_columns());
  CHECK(schema_faults(json_of(thing()), schema).empty());
  CHECK(schema["properties"]["length"]["unit"] == "m");
  CHECK(schema["properties"]["mass"]["description"] == "null: not known");
  CHECK(schema["required"].size() == thing_columns().size() - 1);
  Thing broken = thing();
  broken.length = std::numeric_limits<double>::infinity();
  CHECK(schema_faults(Json::parse(flat(json_of(broken))), schema) == std::vector<std::string>{"$.length is a null"});
}

TEST_CASE("columns: rows of a table, exact for programs and rounded for people") {
  const Table exact = table_of(
      thing_columns(), {{"length"}, {"mass"}, {"place", {"x", "y", "z"}}, {"roots", {"a", "b", "c", "d"}}}, std::vector{thing()});
  CHECK(exact.columns == std::vector<std::string>{"length", "mass", "x", "y", "z", "a", "b", "c", "d"});
  CHECK(exact.rows[0] == std::vector<std::string>{"0.1", "", "1", "-1e-300", "", "0.5", "0.25", "0.5", "-0.25"});
  const Table rounded =
      table_of(thing_columns(), {{"mass", {"m"}, 3}, {"roots", {"1", "2", "3"}, 3}, {"note", {"note"}, 3}}, std::vector{thing()});
  CHECK(rounded.rows[0] == std::vector<std::string>{"-", "0.5 + 0.25 i", "0.5 - 0.25 i", "-", "-"});
}
