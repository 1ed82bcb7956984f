// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/text/column.hpp>
#include <graze/apps/text/number.hpp>

namespace graze::apps {

namespace {

std::string cell_of(const Json& value, int digits) {
  if (value.is_null()) return digits > 0 ? "-" : "";
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_string()) return value;
  if (value.is_number_integer()) return std::to_string(value.get<std::int64_t>());
  if (value.is_array()) return rounded(value_of<std::complex<double>>(value), digits);
  return digits > 0 ? rounded(value.get<double>(), digits) : exact(value);
}

}  // namespace

Json object_schema(const std::vector<Member>& members) {
  Json out = {{"type", "object"}, {"properties", Json::object()}, {"required", Json::array()}, {"additionalProperties", false}};
  for (const Member& member : members) {
    Json& property = out["properties"][member.name] = {{"description", member.meaning}};
    if (!member.unit.empty()) property["unit"] = member.unit;
    property.update(member.schema);
    if (member.always) out["required"].push_back(member.name);
  }
  return out;
}

Json merged_schemas(const std::vector<Json>& objects) {
  Json out = object_schema({});
  for (const Json& object : objects) {
    out["properties"].update(object.at("properties"));
    out["required"].insert(out["required"].end(), object.at("required").begin(), object.at("required").end());
  }
  return out;
}

Json list_schema(const Json& item) { return {{"type", "array"}, {"items", item}}; }

Json or_null(const Json& schema) {
  if (!schema.contains("type") || !schema["type"].is_string()) return {{"anyOf", {schema, {{"type", "null"}}}}};
  Json out = schema;
  out["type"] = {schema["type"], "null"};
  return out;
}

void add_heading(Table& table, const std::string& name) {
  for (std::string& heading : table.columns)
    if (heading == name) heading += '_';
  table.columns.push_back(name);
}

void add_given_headings(Table& table, const std::vector<std::string>& names) {
  for (std::string name : names) {
    while (std::find(table.columns.begin(), table.columns.end(), name) != table.columns.end()) name += '_';
    table.columns.push_back(std::move(name));
  }
}

void add_columns(Table& table, const std::vector<Shown>& shown) {
  for (const Shown& one : shown) {
    const bool own = one.heads == std::vector<std::string>{one.column};
    own ? add_heading(table, one.column) : add_given_headings(table, one.heads);
  }
}

void add_cells(std::vector<std::string>& row, const Json& value, const Shown& shown) {
  if (!value.is_array()) return row.push_back(cell_of(value, shown.digits));
  Json items = value;
  if (shown.digits == 0 && !value.empty() && value[0].is_array()) {
    items = Json::array();
    for (const Json& number : value) items.insert(items.end(), number.begin(), number.end());
  }
  for (std::size_t i = 0; i < shown.heads.size(); ++i) row.push_back(cell_of(i < items.size() ? items[i] : Json(), shown.digits));
}

}  // namespace graze::apps
