// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/problem/system_file.hpp>

#include <graze/apps/problem/toml_section.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>

namespace graze::apps {

namespace {

using namespace equations;

/// Reads one file; every error carries its place in the file.
class Reader {
 public:
  explicit Reader(Source source) : source_(std::move(source)) {}

  SystemText read(const toml::table& root) {
    check_sections(root, source_,
                   {"system", "parameters", "definitions", "modes", "events", "mechanics", "stops", "friction", "surfaces",
                    "outputs", "start", "tables", "units"});
    const bool mechanical = root.contains("mechanics");
    if (!mechanical && !root.contains("system"))
      refuse(place_of(root.source()), "there is no [system] with the names of the states");
    static const toml::table empty;  // [mechanics] needs no more
    const toml::table& system = root.contains("system") ? table_of(root, "system", "[system]") : empty;
    check_keys(system, "[system]", {"name", "states", "forcing", "period", "meaning"});
    out_.name = system.contains("name") ? string_of(system, "name", "[system]").text
                                        : std::filesystem::path(source_.file).stem().string();
    if (mechanical) read_mechanics(table_of(root, "mechanics", "[mechanics]"));
    if (!mechanical || system.contains("states"))
      for (const toml::node& state : array_of(system, "states", "[system]")) out_.states.push_back(string_of(state, "states"));
    if (system.contains("forcing")) out_.forcing = string_of(system, "forcing", "[system]");
    if (system.contains("period")) out_.period = value_of(*system.get("period"), "period");
    if (root.contains("parameters")) read_parameters(table_of(root, "parameters", "[parameters]"));
    if (root.contains("definitions")) read_definitions(table_of(root, "definitions", "[definitions]"), out_.definitions);
    if (root.contains("tables"))
      for (const auto& [key, node] : table_of(root, "tables", "[tables]")) read_table(key, node);
    if (!mechanical && !root.contains("modes"))
      refuse(place_of(system.source()), "the system has no [modes.NAME] with its equations, and no [mechanics]");
    if (root.contains("modes")) {
      for (const auto& [key, node] : table_of(root, "modes", "[modes]")) {
        const std::string where = fmt::format("[modes.{}]", key.str());
        const toml::table& mode = as_table(node, where, "a section with equations");
        check_keys(mode, where, {"equations"});
        out_.modes.push_back({text_of(key), string_of(mode, "equations", where)});
      }
      std::sort(out_.modes.begin(), out_.modes.end(), before<ModeText>);
    }
    each(root, "stops", [&](const toml::table& table, const std::string& where) { read_stop(table, where); });
    each(root, "friction", [&](const toml::table& table, const std::string& where) { read_friction(table, where); });
    each(root, "surfaces", [&](const toml::table& table, const std::string& where) { read_surface(table, where); });
    each(root, "events", [&](const toml::table& table, const std::string& where) { read_event(table, where); });
    if (root.contains("outputs")) read_definitions(table_of(root, "outputs", "[outputs]"), out_.outputs);
    if (root.contains("units"))
      for (const auto& [key, node] : table_of(root, "units", "[units]"))
        out_.units.push_back({text_of(key), string_of(node, fmt::format("the unit of {}", key.str())).text});
    if (root.contains("start")) read_start(table_of(root, "start", "[start]"));
    out_.source = std::move(source_);
    return std::move(out_);
  }

 private:
  [[noreturn]] void refuse(const Place& where, const std::string& message) const { throw EquationError(source_, where, message); }

  Text text_of(const toml::key& key) const { return {std::string(key.str()), place_of(key.source())}; }

  void check_keys(const toml::table& table, const std::string& where, const std::vector<std::string>& allowed) const {
    for (const auto& [key, node] : table) {
      const std::string name(key.str());
      if (std::find(allowed.begin(), allowed.end(), name) != allowed.end()) continue;
      refuse(place_of(key.source()), unknown_key(name, where, allowed));
    }
  }

  /// `wanted`: the kind of value allowed there, for the message.
  const toml::table& as_table(const toml::node& node, const std::string& what, const std::string& wanted) const {
    if (!node.is_table()) refuse(place_of(node.source()), fmt::format("{} must be {}", what, wanted));
    return *node.as_table();
  }

  const toml::table& table_of(const toml::table& parent, const char* key, const std::string& what) const {
    const toml::node* node = parent.get(key);
    if (!node) refuse({}, fmt::format("{} is missing", what));
    return as_table(*node, key, "a section " + what);
  }

  const toml::node& need(const toml::table& parent, const char* key, const std::string& what) const {
    const toml::node* node = parent.get(key);
    if (!node) refuse(place_of(parent.source()), fmt::format("{} lacks {}", what, key));
    return *node;
  }

  const toml::array& array_of(const toml::table& parent, const char* key, const std::string& what) const {
    const toml::node& node = need(parent, key, what);
    if (!node.is_array()) refuse(place_of(node.source()), fmt::format("{} must be a list", key));
    return *node.as_array();
  }

  Text string_of(const toml::node& node, std::string_view what) const {
    if (!node.is_string()) refuse(place_of(node.source()), fmt::format("{} must be a text in quotes", what));
    return quoted_text(source_, place_of(node.source()), **node.as_string());
  }

  Text string_of(const toml::table& parent, const char* key, const std::string& what) const {
    return string_of(need(parent, key, what), key);
  }

  /// A number as written in the file, or a text.
  Text value_of(const toml::node& node, std::string_view what) const {
    if (node.is_string()) return string_of(node, what);
    const Place where = place_of(node.source());
    if (!node.is_number()) refuse(where, fmt::format("{} must be a number, or an expression in quotes", what));
    return {node.is_integer() ? fmt::format("{}", **node.as_integer()) : fmt::format("{}", **node.as_floating_point()), where};
  }

  std::optional<Text> optional_value(const toml::table& table, const char* key) const {
    return table.contains(key) ? std::optional(value_of(*table.get(key), key)) : std::nullopt;
  }

  void read_parameters(const toml::table& table) {
    for (const auto& [key, node] : table) {
      ParameterText parameter;
      parameter.name = text_of(key);
      const std::string where = fmt::format("the parameter {}", key.str());
      if (const toml::table* given = node.as_table()) {
        check_keys(*given, where, {"value", "min", "max", "above", "below", "unit", "meaning"});
        parameter.value = required_value(*given, "value", where);
        parameter.min = optional_value(*given, "min");
        parameter.max = optional_value(*given, "max");
        parameter.above = optional_value(*given, "above");
        parameter.below = optional_value(*given, "below");
        if (given->contains("unit")) parameter.unit = string_of(*given, "unit", where).text;
        if (given->contains("meaning")) parameter.meaning = string_of(*given, "meaning", where).text;
      } else {
        parameter.value = value_of(node, where);
      }
      out_.parameters.push_back(std::move(parameter));
    }
    // Results list parameters in the file's order, which a TOML table does not keep.
    std::sort(out_.parameters.begin(), out_.parameters.end(), before<ParameterText>);
  }

  template <class Named> static bool before(const Named& a, const Named& b) {
    return std::pair(a.name.place.line, a.name.place.column) < std::pair(b.name.place.line, b.name.place.column);
  }

  void read_definitions(const toml::table& table, std::vector<Definition>& into) {
    for (const auto& [key, node] : table) into.push_back({text_of(key), value_of(node, key.str())});
    std::sort(into.begin(), into.end(), before<Definition>);
  }

  /// Reads the entries of an array of tables, [[key]], if there are any.
  template <class Read> void each(const toml::table& root, const char* key, const Read& read) {
    const toml::node* node = root.get(key);
    if (!node) return;
    if (!node->is_array_of_tables()) refuse(place_of(node->source()), fmt::format("{0} are written as [[{0}]], one each", key));
    std::size_t number = 0;
    for (const toml::node& entry : *node->as_array()) read(*entry.as_table(), fmt::format("[[{}]] number {}", key, ++number));
  }

  std::optional<Text> optional_string(const toml::table& table, const char* key, const std::string& where) const {
    return table.contains(key) ? std::optional(string_of(table, key, where)) : std::nullopt;
  }

  Text required_value(const toml::table& table, const char* key, const std::string& where) const {
    return value_of(need(table, key, where), key);
  }

  /// The value of `count`, > 0 if an orbit's period counts these events.
  std::size_t count_of(const toml::table& table) const {
    const toml::node* count = table.get("count");
    if (!count) return 0;
    if (!count->is_integer() || **count->as_integer() < 0)
      refuse(place_of(count->source()), "count must be a whole number from 0 on");
    return static_cast<std::size_t>(**count->as_integer());
  }

  void read_event(const toml::table& table, const std::string& where) {
    check_keys(table, where, {"name", "kind", "from", "to", "when", "reset", "count"});
    EventText event;
    event.name = string_of(table, "name", where);
    event.when = string_of(table, "when", where);
    event.kind = optional_string(table, "kind", where);
    event.from = optional_string(table, "from", where);
    event.to = optional_string(table, "to", where);
    event.reset = optional_string(table, "reset", where);
    event.count = count_of(table);
    out_.events.push_back(std::move(event));
  }

  void read_mechanics(const toml::table& table) {
    const std::string where = "[mechanics]";
    check_keys(table, where, {"coordinates", "velocities", "mass", "damping", "stiffness", "force"});
    MechanicsText mechanics;
    mechanics.place = place_of(table.source());
    for (const toml::node& name : array_of(table, "coordinates", where))
      mechanics.coordinates.push_back(string_of(name, "coordinates"));
    for (const toml::node& name : array_of(table, "velocities", where))
      mechanics.velocities.push_back(string_of(name, "velocities"));
    mechanics.mass = matrix(table, "mass", where);
    if (table.contains("damping")) mechanics.damping = matrix(table, "damping", where);
    if (table.contains("stiffness")) mechanics.stiffness = matrix(table, "stiffness", where);
    if (table.contains("force"))
      for (const toml::node& entry : array_of(table, "force", where)) mechanics.force.push_back(value_of(entry, "force"));
    out_.mechanics = std::move(mechanics);
  }

  std::vector<std::vector<Text>> matrix(const toml::table& table, const char* key, const std::string& where) const {
    std::vector<std::vector<Text>> rows;
    for (const toml::node& row : array_of(table, key, where)) {
      if (!row.is_array())
        refuse(place_of(row.source()), fmt::format("{} must be a list of rows, such as [[1, 0], [0, 1]]", key));
      rows.emplace_back();
      for (const toml::node& entry : *row.as_array()) rows.back().push_back(value_of(entry, key));
    }
    return rows;
  }

  void read_stop(const toml::table& table, const std::string& where) {
    check_keys(table, where, {"name", "gap", "law", "count"});
    StopText stop;
    stop.name = string_of(table, "name", where);
    stop.gap = string_of(table, "gap", where);
    stop.count = count_of(table);
    const toml::table& law = as_table(need(table, "law", where), "law", "a table, such as { newton = 0.8 }");
    check_keys(law, "law", {"newton", "hertz", "linear", "force", "adhesion"});
    for (const auto& [key, node] : law) {
      if (key.str() == "adhesion") {
        if (!node.is_boolean()) refuse(place_of(node.source()), "adhesion must be true or false");
        stop.adhesion = **node.as_boolean();
        continue;
      }
      if (!stop.law.text.empty())
        refuse(place_of(key.source()), fmt::format("a stop has one law, not {} and {}", stop.law.text, key.str()));
      stop.law = text_of(key);
      if (const toml::array* values = node.as_array()) {
        for (const toml::node& value : *values) stop.values.push_back(value_of(value, key.str()));
      } else {
        stop.values.push_back(value_of(node, key.str()));
      }
    }
    if (stop.law.text.empty()) refuse(place_of(law.source()), "law names none of newton, hertz, linear, force");
    out_.stops.push_back(std::move(stop));
  }

  void read_friction(const toml::table& table, const std::string& where) {
    check_keys(table, where, {"name", "speed", "normal", "law", "sticking", "count"});
    FrictionText friction;
    friction.name = string_of(table, "name", where);
    friction.speed = string_of(table, "speed", where);
    friction.normal = required_value(table, "normal", where);
    friction.law = required_value(table, "law", where);
    friction.sticking = optional_value(table, "sticking");
    friction.count = count_of(table);
    out_.friction.push_back(std::move(friction));
  }

  void read_surface(const toml::table& table, const std::string& where) {
    check_keys(table, where, {"function", "below", "above", "sliding", "count"});
    out_.surfaces.push_back({string_of(table, "function", where), string_of(table, "below", where),
                             string_of(table, "above", where), optional_string(table, "sliding", where), count_of(table)});
  }

  void read_start(const toml::table& table) {
    check_keys(table, "[start]", {"state", "settle", "period"});
    const toml::node* state = table.get("state");
    if (!state) return;
    if (const toml::array* list = state->as_array()) {
      const std::vector<Text> names = out_.state_texts();
      if (list->size() != names.size())
        refuse(place_of(state->source()),
               fmt::format("the number of entries of state is {}, and that of states {}; give one entry for each state",
                           list->size(), names.size()));
      for (std::size_t i = 0; i < list->size(); ++i) out_.start.push_back({names[i], value_of(*list->get(i), "a state")});
      return;
    }
    for (const auto& [key, node] : as_table(*state, "state", "a list of values, or a table such as { x = 0.5 }"))
      out_.start.push_back({text_of(key), value_of(node, key.str())});
  }

  void read_table(const toml::key& key, const toml::node& node) {
    const std::string where = fmt::format("[tables.{}]", key.str());
    const toml::table& given = as_table(node, where, "a section with u and y");
    check_keys(given, where, {"u", "y", "periodic", "slopes"});
    Table table;
    table.name = key.str();
    table.u = numbers(given, "u", where);
    table.y = numbers(given, "y", where);
    if (const toml::node* periodic = given.get("periodic")) {
      if (!periodic->is_boolean()) refuse(place_of(periodic->source()), "periodic must be true or false");
      table.periodic = **periodic->as_boolean();
    }
    if (given.contains("slopes")) {
      const std::vector<double> slopes = numbers(given, "slopes", where);
      if (slopes.size() != 2) refuse(place_of(given.get("slopes")->source()), "slopes must be two numbers, at both ends");
      table.first_slope = slopes[0];
      table.last_slope = slopes[1];
    }
    try {
      make_spline(table);
    } catch (const EquationError&) {
      throw;
    } catch (const std::invalid_argument& error) {
      refuse(place_of(key.source()), fmt::format("{}: {}", where, error.what()));
    }
    out_.tables.push_back(std::move(table));
  }

  std::vector<double> numbers(const toml::table& table, const char* key, const std::string& where) const {
    std::vector<double> list;
    for (const toml::node& node : array_of(table, key, where)) {
      const std::optional<double> number = node.is_number() ? node.value<double>() : std::nullopt;
      if (!number) refuse(place_of(node.source()), fmt::format("{} must be a list of numbers", key));
      list.push_back(*number);
    }
    return list;
  }

  Source source_;
  SystemText out_;
};

}  // namespace

bool has_system(const toml::table& root) {
  constexpr std::array sections = {"system", "mechanics", "modes", "events", "stops", "friction", "surfaces"};
  return std::any_of(sections.begin(), sections.end(), [&](const char* section) { return root.contains(section); });
}

SystemText read_system(const toml::table& root, Source source) { return Reader(std::move(source)).read(root); }

}  // namespace graze::apps
