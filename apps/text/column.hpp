// SPDX-License-Identifier: GPL-3.0-or-later
// Column: one field of a result, with its name, unit, meaning, getter and setter. The fields of a type are one list of columns.
// From this list follow its JSON (as a tree, or written straight into a text), the reader of that JSON, its schema, and the
// rows of its tables. A new field is one line of the list.
//
// JsonForm<V> defines the JSON form of a value: json(), value() (the inverse, @throws Json::exception for JSON of another kind)
// and schema(). It also defines the CSV form: cells(), each after a comma, empty if unknown. A number that may be missing is a
// std::optional; a plain number that is not finite becomes null as well. A type with a list of columns declares that list as
// its form by
//     template <> struct JsonForm<Contact> : RecordForm<Contact, contact_columns> {};
// and an enumeration, each of whose values has a name, by
//     template <> struct JsonForm<MapType> : ChoiceForm<MapType, map_type_name, MapType::undecided, MapType::periodic> {};
#pragma once

#include <graze/apps/text/json_text.hpp>
#include <graze/apps/text/table.hpp>

#include <fmt/compile.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <map>
#include <stdexcept>
#include <utility>

namespace graze::apps {

/// A member of an object, as JSON Schema (draft 2020-12) describes it. `always`: the member is never left out.
struct Member {
  std::string name, meaning;
  Json schema;
  bool always = true;
  std::string unit = {};
};
/// The schema of an object with exactly these members.
Json object_schema(const std::vector<Member>& members);
/// The members of several object schemas in one schema.
Json merged_schemas(const std::vector<Json>& objects);
Json list_schema(const Json& item);
Json or_null(const Json& schema);

template <class V> struct JsonForm {
  static_assert(std::is_arithmetic_v<V> || std::convertible_to<V, std::string_view> || std::is_same_v<V, Json>);
  static Json json(const V& value) { return value; }
  static V value(const Json& json) {
    if constexpr (std::is_integral_v<V> && !std::is_same_v<V, bool>) {
      const bool fits = json.is_number_unsigned() ? std::in_range<V>(json.get<std::uint64_t>())
                                                  : json.is_number_integer() && std::in_range<V>(json.get<std::int64_t>());
      if (!fits) throw Json::type_error::create(302, "type must be a whole number, and not too large", &json);
    }
    return json.get<V>();
  }
  static void write(const V& value, JsonText& text) { text.value(value); }
  static void cells(const V& value, std::string& line) requires(!std::is_same_v<V, Json>) {
    line += ',';
    if constexpr (std::is_same_v<V, bool>)
      line += value ? "yes" : "no";
    else if constexpr (std::is_floating_point_v<V>) {
      if (!std::isnan(value)) fmt::format_to(std::back_inserter(line), FMT_COMPILE("{}"), value);
    } else
      fmt::format_to(std::back_inserter(line), FMT_COMPILE("{}"), value);
  }
  static Json schema() {
    if constexpr (std::is_same_v<V, Json>) return Json::object();
    return {{"type", std::is_same_v<V, bool>   ? "boolean"
                     : std::is_integral_v<V>   ? "integer"
                     : std::is_arithmetic_v<V> ? "number"
                                               : "string"}};
  }
};

/// A list of values that have forms of their own.
template <class List, class Item = typename List::value_type> struct ListForm {
  static Json json(const List& list) {
    Json out = Json::array();
    for (const Item& item : list) out.push_back(JsonForm<Item>::json(item));
    return out;
  }
  static List value(const Json& json) {
    List list;
    for (const Json& item : json) list.push_back(JsonForm<Item>::value(item));
    return list;
  }
  static void write(const List& list, JsonText& text) {
    text.begin_list();
    for (const Item& item : list) JsonForm<Item>::write(item, text);
    text.end_list();
  }
  static void cells(const List& list, std::string& line) requires requires(const Item& item) {
    JsonForm<Item>::cells(item, line);
  }
  {
    for (const Item& item : list) JsonForm<Item>::cells(item, line);
  }
  static Json schema() { return list_schema(JsonForm<Item>::schema()); }
};
template <class Item> struct JsonForm<std::vector<Item>> : ListForm<std::vector<Item>> {};
template <> struct JsonForm<Vector> : ListForm<Vector, double> {
  static Vector value(const Json& json) { return vector_from(json); }
};
template <> struct JsonForm<std::array<double, 2>> : ListForm<std::array<double, 2>> {
  static std::array<double, 2> value(const Json& json) { return {json.at(0).get<double>(), json.at(1).get<double>()}; }
};
template <> struct JsonForm<std::complex<double>> {
  static Json json(const std::complex<double>& value) { return {value.real(), value.imag()}; }
  static std::complex<double> value(const Json& json) { return {json.at(0).get<double>(), json.at(1).get<double>()}; }
  static void write(const std::complex<double>& value, JsonText& text) { text.value(value); }
  static Json schema() { return {{"type", "array"}, {"items", {{"type", "number"}}}, {"minItems", 2}, {"maxItems", 2}}; }
};
template <class V> struct JsonForm<std::optional<V>> {
  static Json json(const std::optional<V>& value) { return value ? JsonForm<V>::json(*value) : Json(nullptr); }
  static std::optional<V> value(const Json& json) {
    return json.is_null() ? std::nullopt : std::optional(JsonForm<V>::value(json));
  }
  static void write(const std::optional<V>& value, JsonText& text) {
    value ? JsonForm<V>::write(*value, text) : text.value(std::optional<bool>());
  }
  static void cells(const std::optional<V>& value, std::string& line) requires requires { JsonForm<V>::cells(*value, line); }
  { value ? JsonForm<V>::cells(*value, line) : void(line += ','); }
  static Json schema() { return or_null(JsonForm<V>::schema()); }
};
/// A number that may be infinite or unknown; JSON can express neither.
struct MaybeFinite {
  MaybeFinite() = default;
  explicit MaybeFinite(double number) : value(number) {}
  double value = 0.0;
};
template <> struct JsonForm<MaybeFinite> {
  static Json json(const MaybeFinite& number) { return std::isfinite(number.value) ? Json(number.value) : Json(nullptr); }
  static MaybeFinite value(const Json& json) { return MaybeFinite(json.is_null() ? std::nan("") : json.get<double>()); }
  static void write(const MaybeFinite& number, JsonText& text) { text.value(number.value); }
  static void cells(const MaybeFinite& number, std::string& line) { JsonForm<double>::cells(number.value, line); }
  static Json schema() { return or_null(JsonForm<double>::schema()); }
};
/// Values by arbitrary names.
template <class V> struct JsonForm<std::map<std::string, V>> {
  using Named = std::map<std::string, V>;
  static Json json(const Named& values) {
    Json out = Json::object();
    for (const auto& [name, value] : values) out[name] = JsonForm<V>::json(value);
    return out;
  }
  static Named value(const Json& json) {
    Named values;
    for (const auto& [name, value] : json.items()) values.insert_or_assign(name, JsonForm<V>::value(value));
    return values;
  }
  static void write(const Named& values, JsonText& text) {
    text.begin_object();
    for (const auto& [name, value] : values) {
      text.key(name);
      JsonForm<V>::write(value, text);
    }
    text.end_object();
  }
  static Json schema() { return {{"type", "object"}, {"additionalProperties", JsonForm<V>::schema()}}; }
};

/// A condition on a record, passed after a column: the record has the column only if the condition holds.
template <class Condition> struct Only { Condition holds; };
template <class Condition> Only<Condition> only(Condition holds) { return {holds}; }

template <class T> struct Column {
  std::string name, unit, meaning;
  Json schema;
  std::function<Json(const T&)> json;
  std::function<void(const T&, JsonText&)> write;
  std::function<void(const T&, std::string&)> cells = {};  ///< of a line of CSV; empty: the value has no CSV form
  std::function<void(T&, const Json&)> set = {};           ///< empty: a derived value, not read back
  std::function<bool(const T&)> applies = {};              ///< whether a record has this column; empty: always
  bool needed = true;                                      ///< the reader requires it

  Column() = default;
  /// `head`: the name, followed by a unit in brackets: "duration [time]". `get`: a data member, which is then also read back,
  /// or any callable on a T. `put(T&, V)` stores a value of the type that `get` returns.
  template <class Get> Column(const char* head, const char* says, Get get) : Column(head, says, get, nullptr) {}
  template <class Get, class Put> Column(const char* head, const char* says, Get get, Put put) : name(head), meaning(says) {
    if (const std::size_t bracket = name.find(" ["); bracket != std::string::npos) {
      unit = name.substr(bracket + 2, name.size() - bracket - 3);
      name.erase(bracket);
    }
    using Form = JsonForm<std::remove_cvref_t<std::invoke_result_t<Get, const T&>>>;
    schema = Form::schema();
    json = [get](const T& record) { return Form::json(std::invoke(get, record)); };
    write = [get](const T& record, JsonText& text) { Form::write(std::invoke(get, record), text); };
    if constexpr (requires(const T& record, std::string& line) { Form::cells(std::invoke(get, record), line); })
      cells = [get](const T& record, std::string& line) { Form::cells(std::invoke(get, record), line); };
    if constexpr (!std::is_null_pointer_v<Put>)
      set = [put](T& record, const Json& value) { put(record, Form::value(value)); };
    else if constexpr (std::is_member_object_pointer_v<Get>)
      set = [get](T& record, const Json& value) { record.*get = Form::value(value); };
  }
  template <class Get, class Condition>
  Column(const char* head, const char* says, Get get, Only<Condition> where) : Column(head, says, get, nullptr, where) {}
  template <class Get, class Put, class Condition>
  Column(const char* head, const char* says, Get get, Put put, Only<Condition> where) : Column(head, says, get, put) {
    *this = this->where(where.holds);
  }

  Column where(std::function<bool(const T&)> holds) const {
    Column out = *this;
    out.applies = std::move(holds);
    out.needed = false;
    return out;
  }
  /// The same column, optional for the reader: only results of newer versions have it, or the reader does not use it.
  Column not_needed() const {
    Column out = *this;
    out.needed = false;
    return out;
  }
  bool is_in(const T& record) const { return !applies || applies(record); }
};
template <class T> using Columns = std::vector<Column<T>>;

template <class T> void write_members(const Columns<T>& columns, const T& record, JsonText& text) {
  for (const Column<T>& one : columns) {
    if (!one.is_in(record)) continue;
    text.key(one.name);
    one.write(record, text);
  }
}

template <class T> Json json_of(const Columns<T>& columns, const T& record) {
  Json out = Json::object();
  reserve_members(out, columns.size() + 1);
  for (const Column<T>& one : columns)
    if (one.is_in(record)) out[one.name] = one.json(record);
  return out;
}

/// @throws Json::exception, std::invalid_argument if a member is missing or of another kind.
template <class T> void read(const Columns<T>& columns, const Json& json, T& record) {
  for (const Column<T>& one : columns)
    if (one.set && (one.needed || json.contains(one.name))) one.set(record, json.at(one.name));
}

template <class T> Json schema_of(const Columns<T>& columns) {
  std::vector<Member> members;
  for (const Column<T>& one : columns) members.push_back({one.name, one.meaning, one.schema, !one.applies, one.unit});
  return object_schema(members);
}

template <class T, const Columns<T>& (*columns)()> struct RecordForm {
  static Json json(const T& record) { return json_of(columns(), record); }
  static T value(const Json& json) {
    T record{};
    read(columns(), json, record);
    return record;
  }
  static void write(const T& record, JsonText& text) {
    text.begin_object();
    write_members(columns(), record, text);
    text.end_object();
  }
  static Json schema() { return schema_of(columns()); }
};

template <class E, auto name, E... all> struct ChoiceForm {
  static Json json(E choice) { return name(choice); }
  static E value(const Json& json) {
    for (const E choice : {all...})
      if (json == name(choice)) return choice;
    const std::array<std::string_view, sizeof...(all)> names = {name(all)...};
    throw std::invalid_argument(
        fmt::format("{} stands in the result where it can be one of {}; compute it anew", flat(json), fmt::join(names, ", ")));
  }
  static void write(E choice, JsonText& text) { text.value(name(choice)); }
  static void cells(E choice, std::string& line) { JsonForm<std::string_view>::cells(name(choice), line); }
  static Json schema() { return {{"enum", {name(all)...}}}; }
};

template <class V> Json json_of(const V& value) { return JsonForm<V>::json(value); }
template <class V> V value_of(const Json& json) { return JsonForm<V>::value(json); }

/// The columns of a part of a record, as columns of the record.
template <class T, class Part> Columns<T> of_part(const Columns<Part>& columns, Part T::*part) {
  Columns<T> list;
  for (const Column<Part>& one : columns) {
    Column<T>& out = list.emplace_back();
    out.name = one.name;
    out.unit = one.unit;
    out.meaning = one.meaning;
    out.schema = one.schema;
    out.needed = one.needed;
    out.json = [=](const T& record) { return one.json(record.*part); };
    out.write = [=](const T& record, JsonText& text) { one.write(record.*part, text); };
    if (one.cells) out.cells = [=](const T& record, std::string& line) { one.cells(record.*part, line); };
    if (one.set) out.set = [=](T& record, const Json& json) { one.set(record.*part, json); };
    if (one.applies) out.applies = [=](const T& record) { return one.applies(record.*part); };
  }
  return list;
}

/// A column that groups several fields of a record in a JSON object of their own.
template <class T> Column<T> object(const char* name, const char* meaning, const Columns<T>& columns) {
  Column<T> out;
  out.name = name;
  out.meaning = meaning;
  out.schema = schema_of(columns);
  out.json = [columns](const T& record) { return json_of(columns, record); };
  out.write = [columns](const T& record, JsonText& text) {
    text.begin_object();
    write_members(columns, record, text);
    text.end_object();
  };
  out.set = [columns](T& record, const Json& json) { read(columns, json, record); };
  return out;
}

template <class T> Columns<T> joined(std::initializer_list<Columns<T>> lists) {
  Columns<T> out;
  for (const Columns<T>& list : lists) out.insert(out.end(), list.begin(), list.end());
  return out;
}

/// A column of a record in a table: the headings of its cells (one, or one for each item of a list), and the number of
/// significant digits for people. 0 digits: exact numbers, with real and imaginary part in separate cells.
struct Shown {
  const char* column;
  std::vector<std::string> heads = {column};
  int digits = 0;
};

/// Appends the cells of a JSON value: numbers, yes or no, text. A missing value is "-" for people, otherwise empty.
void add_cells(std::vector<std::string>& row, const Json& value, const Shown& shown);

/// Adds a heading of the program's own. A heading with this name, of a state or a parameter, gets "_" behind it.
void add_heading(Table& table, const std::string& name);
/// Adds headings named by a file: states and parameters. A name that is taken gets "_" behind it.
void add_given_headings(Table& table, const std::vector<std::string>& names);

/// The headings of a table, and the cells of a record.
void add_columns(Table& table, const std::vector<Shown>& shown);
template <class T>
void add_cells(std::vector<std::string>& row, const Columns<T>& columns, const std::vector<Shown>& shown, const T& record) {
  for (const Shown& one : shown)
    for (const Column<T>& candidate : columns)
      if (candidate.name == one.column) add_cells(row, candidate.is_in(record) ? candidate.json(record) : Json(), one);
}
template <class T> Table table_of(const Columns<T>& columns, const std::vector<Shown>& shown, const std::vector<T>& records) {
  Table table;
  add_columns(table, shown);
  for (const T& record : records) add_cells(table.rows.emplace_back(), columns, shown, record);
  return table;
}

/// Continues a line of CSV with the cells of a column, one for each heading, each after a comma.
template <class T> void append_cells(std::string& line, const Column<T>& column, const T& record, std::size_t heads = 1) {
  const auto begin = static_cast<std::ptrdiff_t>(line.size());
  if (column.is_in(record)) column.cells(record, line);
  line.append(heads - static_cast<std::size_t>(std::count(line.begin() + begin, line.end(), ',')), ',');
}
template <class T>
void append_cells(std::string& line, const Columns<T>& columns, const std::vector<Shown>& shown, const T& record) {
  for (const Shown& one : shown)
    for (const Column<T>& candidate : columns)
      if (candidate.name == one.column) append_cells(line, candidate, record, one.heads.size());
}

inline MaybeFinite finite(double value) { return MaybeFinite(value); }
using MaybeNumbers = std::vector<MaybeFinite>;
inline MaybeNumbers finite(const std::vector<double>& values) { return {values.begin(), values.end()}; }
/// Rows in which a number may be unknown.
inline std::vector<MaybeNumbers> finite(const std::vector<Vector>& rows) {
  std::vector<MaybeNumbers> out;
  for (const Vector& row : rows) out.emplace_back(row.begin(), row.end());
  return out;
}
/// The inverse; `otherwise` replaces numbers that JSON cannot express.
inline std::vector<double> numbers(const MaybeNumbers& values, double otherwise) {
  std::vector<double> out;
  for (const MaybeFinite& one : values) out.push_back(std::isnan(one.value) ? otherwise : one.value);
  return out;
}

}  // namespace graze::apps
