// SPDX-License-Identifier: GPL-3.0-or-later
#include "json_schema.hpp"

#include <graze/apps/commands/command.hpp>

#include <catch2/catch.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <stdexcept>

namespace graze::support {

using apps::Json;

namespace {

bool is_of_type(const Json& value, const std::string& type) {
  if (type == "number") return value.is_number();
  if (type == "integer") return value.is_number_integer();
  return type == value.type_name();
}

bool is_of_types(const Json& value, const Json& types) {
  if (types.is_string()) return is_of_type(value, types);
  return std::any_of(types.begin(), types.end(), [&](const Json& type) { return is_of_type(value, type); });
}

void check_object(const Json& value, const Json& schema, const std::string& place, std::vector<std::string>& faults) {
  for (const Json& name : schema.value("required", Json::array()))
    if (!value.contains(name.get<std::string>())) faults.push_back(fmt::format("{} lacks {}", place, apps::flat(name)));
  const Json known = schema.value("properties", Json::object()), others = schema.value("additionalProperties", Json(true));
  for (const auto& [name, member] : value.items()) {
    const Json& rule = known.contains(name) ? known.at(name) : others;
    if (rule == Json(false)) faults.push_back(fmt::format("{} has {}, which it should not", place, name));
    if (!rule.is_object()) continue;
    for (std::string& fault : schema_faults(member, rule, place + "." + name)) faults.push_back(std::move(fault));
  }
}

void check_list(const Json& value, const Json& schema, const std::string& place, std::vector<std::string>& faults) {
  if (value.size() < schema.value("minItems", std::size_t{0}) || value.size() > schema.value("maxItems", value.size()))
    faults.push_back(fmt::format("{} has {} items", place, value.size()));
  if (!schema.contains("items")) return;
  for (std::size_t i = 0; i < value.size(); ++i)
    for (std::string& fault : schema_faults(value[i], schema["items"], fmt::format("{}[{}]", place, i)))
      faults.push_back(std::move(fault));
}

std::map<std::string, Json> schemas() {
  std::map<std::string, Json> list;
  for (const apps::Command& command : apps::commands())
    for (const apps::ResultKind& kind : command.results) list.emplace("graze." + kind.name + "/1", kind.schema());
  return list;
}

}  // namespace

std::vector<std::string> schema_faults(const Json& value, const Json& schema, const std::string& place) {
  static const std::set<std::string> known = {"$schema", "title",    "description", "unit",     "type",
                                              "const",   "enum",     "properties",  "required", "additionalProperties",
                                              "items",   "minItems", "maxItems",    "anyOf"};
  std::vector<std::string> faults;
  for (const auto& [keyword, rule] : schema.items())
    if (!known.contains(keyword)) throw std::invalid_argument("a schema has the keyword " + keyword);
  if (schema.contains("type") && !is_of_types(value, schema["type"]))
    faults.push_back(fmt::format("{} is a {}", place, value.type_name()));
  if (schema.contains("const") && value != schema["const"]) faults.push_back(fmt::format("{} is {}", place, apps::flat(value)));
  if (schema.contains("enum") && std::find(schema["enum"].begin(), schema["enum"].end(), value) == schema["enum"].end())
    faults.push_back(fmt::format("{} is {}", place, apps::flat(value)));
  if (schema.contains("anyOf") && std::none_of(schema["anyOf"].begin(), schema["anyOf"].end(),
                                               [&](const Json& one) { return schema_faults(value, one, place).empty(); }))
    faults.push_back(place + " is none of what it can be");
  if (value.is_object()) check_object(value, schema, place, faults);
  if (value.is_array()) check_list(value, schema, place, faults);
  return faults;
}

std::vector<std::string> result_faults(const Json& result) {
  static const std::map<std::string, Json> list = schemas();
  const auto found = list.find(apps::schema_of(result));
  if (found == list.end()) return {"there is no such schema: " + apps::schema_of(result)};
  return schema_faults(result, found->second);
}

void check_results(const std::vector<std::string>& arguments, const Outcome& outcome) {
  if (outcome.code == 2) return;
  std::vector<std::string> texts;
  const auto is_asked = [&](const std::string& option) {
    return std::find(arguments.begin(), arguments.end(), option) + 1 < arguments.end();
  };
  const auto value_of = [&](const std::string& option) { return *(std::find(arguments.begin(), arguments.end(), option) + 1); };
  const auto look_into = [&](const std::string& file) {
    std::error_code error;
    if (std::filesystem::is_regular_file(file, error)) texts.push_back(read_file(file));
  };
  if (is_asked("--json")) value_of("--json") == "-" ? texts.push_back(outcome.out) : look_into(value_of("--json"));
  for (const char* folder : {"--out", "--resume"})
    if (is_asked(folder) && !arguments.empty()) look_into(value_of(folder) + "/" + arguments.front() + ".json");
  for (const std::string& text : texts) {
    const Json result = Json::parse(text, nullptr, false);
    if (!result.is_object()) continue;  // no result was written there
    if (const std::vector<std::string> faults = result_faults(result); !faults.empty())
      FAIL_CHECK(fmt::format("{}:\n{}", fmt::join(arguments, " "), fmt::join(faults, "\n")));
  }
}

}  // namespace graze::support

using namespace graze::apps;
using namespace graze::support;

TEST_CASE("the shipped schemas are those that the program prints") {
  std::size_t kinds = 0;
  for (const char* name : {"orbit", "branch", "diagram"}) CHECK_THAT(call({"schema"}).out, Catch::Matchers::Contains(name));
  for (const Command& command : commands())
    for (const ResultKind& kind : command.results) {
      INFO(kind.name);
      ++kinds;
      const Outcome outcome = call({"schema", kind.name});
      CHECK(outcome.code == 0);
      CHECK(outcome.out == read_file(GRAZE_DATA_DIR "/schemas/" + kind.name + ".json"));
    }
  const std::filesystem::directory_iterator files(GRAZE_DATA_DIR "/schemas");
  CHECK(static_cast<std::size_t>(std::distance(begin(files), end(files))) == kinds);
  const Outcome unknown = call({"schema", "orbt"});
  CHECK(unknown.code == 2);
  CHECK_THAT(unknown.err, Catch::Matchers::Contains("did you mean \"orbit\""));
}

TEST_CASE("a result that violates its schema is detected") {
  Json result = json_of(call("continue", "newton-elastic", {"--from", "0.95", "--to", "0.94", "--json", "-"}));
  CHECK(result_faults(result).empty());
  Json& point = result["branches"][0]["points"][1];
  const Json whole = point;
  point["one_more"] = 1;
  CHECK(result_faults(result) == std::vector<std::string>{"$.branches[0].points[1] has one_more, which it should not"});
  point = whole;
  point.erase("state");
  CHECK(result_faults(result) == std::vector<std::string>{"$.branches[0].points[1] lacks \"state\""});
  point = whole;
  point["stable"] = "yes";
  CHECK(result_faults(result) == std::vector<std::string>{"$.branches[0].points[1].stable is a string"});
  point = whole;
  point["multipliers"][0].push_back(0.0);
  CHECK(result_faults(result) == std::vector<std::string>{"$.branches[0].points[1].multipliers[0] has 3 items"});
  point = whole;
  result["branches"][0]["stop"]["reason"] = "bored";
  CHECK(result_faults(result) == std::vector<std::string>{"$.branches[0].stop.reason is \"bored\""});
}
