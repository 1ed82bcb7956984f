// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/names.hpp>

#include <graze/lib/equations/functions.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace graze::equations {

bool Names::is_parameter(std::string_view name) const {
  const auto kind = kinds.find(name);
  return kind != kinds.end() && kind->second == "parameter";
}

std::optional<std::size_t> Names::state_number(std::string_view name) const {
  const auto found = std::find(symbols.states.begin(), symbols.states.end(), name);
  return found == symbols.states.end() ? std::nullopt : std::optional(static_cast<std::size_t>(found - symbols.states.begin()));
}

double Names::value_of(Expression e) const {
  return values(graph, {&e, 1}, 0.0, Vector::Zero(static_cast<Eigen::Index>(states.size())), defaults)[0];
}

Scope Names::scope(bool with_time) const {
  Scope out = scope_of(meanings, tables);
  out.refusal = [this, with_time](std::string_view name) -> std::string {
    if (name == "t") return with_time ? std::string() : "the time t cannot be used";
    const auto kind = kinds.find(name);
    return kind == kinds.end() ? std::string() : fmt::format("the {} {} cannot be used", kind->second, name);
  };
  return out;
}

Scope Names::parameter_scope() const {
  Scope out = scope(false);
  out.rates = false;
  out.find = [this](std::string_view name) -> std::optional<Expression> {
    const auto found = meanings.find(name);
    if (!is_parameter(name) || found == meanings.end()) return std::nullopt;
    return found->second;
  };
  std::erase_if(out.names, [&](const std::string& name) { return !is_parameter(name); });
  return out;
}

std::function<double(const Vector& p)> function_of_parameters(const Graph& graph, Expression e) {
  return [value = scalar_function(graph, e)](const Vector& p) { return value(0.0, {}, p); };
}

std::function<void(const Vector& p, Vector& out)> gradient_of_parameters(Graph& graph, Expression e) {
  return [gradient = gradient_in_parameters(graph, e)](const Vector& p, Vector& out) {
    if (gradient) {
      gradient(0.0, {}, p, out);
    } else {
      out.setZero();
    }
  };
}

namespace {

class NamesReader {
 public:
  NamesReader(const SystemText& text, Graph& graph) : text_(text), graph_(graph), names_{text, graph} {}

  Names read() {
    read_declarations();
    read_parameters();
    read_definitions();
    read_start();
    return std::move(names_);
  }

 private:
  void declare(const Text& name, const std::string& kind, const std::string& article) {
    if (name.text.empty()) names_.refuse(name.place, fmt::format("a {} without a name", kind));
    if (!is_name(name.text))
      names_.refuse(name.place, fmt::format("'{}' is no name for {} {}: letters, digits and _ are, beginning with a letter",
                                            name.text, article, kind));
    const auto& reserved = reserved_names();
    if (std::find(reserved.begin(), reserved.end(), name.text) != reserved.end())
      names_.refuse(name.place, fmt::format("{} {} cannot be called '{}', which is {}", article, kind, name.text,
                                            name.text == "t"    ? "the time"
                                            : name.text == "pi" ? "the number pi"
                                                                : "a function"));
    const auto [at, is_new] = names_.kinds.try_emplace(name.text, kind);
    if (!is_new)
      names_.refuse(name.place,
                    fmt::format("the name '{}' of {} {} is that of a {} already", name.text, article, kind, at->second));
  }

  template <class List, class NameOf> void distinct(const List& list, const char* kind, const NameOf& name_of) const {
    std::map<std::string, int> seen;
    for (const auto& one : list) {
      const Text& name = name_of(one);
      if (name.text.empty()) names_.refuse(name.place, fmt::format("{} without a name", kind));
      if (++seen[name.text] > 1) names_.refuse(name.place, fmt::format("{} called '{}' exists already", kind, name.text));
    }
  }

  void read_states() {
    names_.states = text_.state_texts();
    if (!text_.mechanics) {
      if (!text_.stops.empty())
        names_.refuse(text_.stops[0].name.place, "a stop needs mechanics, with coordinates and a mass matrix");
      if (!text_.friction.empty())
        names_.refuse(text_.friction[0].name.place,
                      "friction needs mechanics, with a mass matrix; without, it is a surface where two modes meet");
      if (names_.states.empty()) names_.refuse({}, "the system has no states");
      return;
    }
    const MechanicsText& mechanics = *text_.mechanics;
    if (!text_.states.empty())
      names_.refuse(text_.states[0].place,
                    "both states and mechanics are given; the states are the coordinates, then the velocities");
    if (!text_.modes.empty())
      names_.refuse(text_.modes[0].name.place, "both modes and mechanics are given; the modes follow from the mechanics");
    if (mechanics.coordinates.empty()) names_.refuse(mechanics.place, "the mechanics has no coordinates");
    if (mechanics.velocities.size() != mechanics.coordinates.size())
      names_.refuse(
          mechanics.velocities.empty() ? mechanics.place : mechanics.velocities[0].place,
          fmt::format("the number of coordinates is {}, and that of velocities {}; give one velocity for each coordinate",
                      mechanics.coordinates.size(), mechanics.velocities.size()));
  }

  void read_declarations() {
    read_states();
    for (const Text& state : names_.states) declare(state, "state", "a");
    for (const ParameterText& parameter : text_.parameters) declare(parameter.name, "parameter", "a");
    for (const Definition& definition : text_.definitions) declare(definition.name, "definition", "a");
    for (const Definition& output : text_.outputs) declare(output.name, "output", "an");
    distinct(text_.modes, "a mode", [](const ModeText& mode) -> const Text& { return mode.name; });
    distinct(text_.events, "an event", [](const EventText& event) -> const Text& { return event.name; });
    for (std::size_t i = 0; i < names_.states.size(); ++i) {
      names_.symbols.states.push_back(names_.states[i].text);
      names_.meanings.emplace(names_.states[i].text, graph_.state(i));
    }
    for (const Table& table : text_.tables) names_.tables.emplace(table.name, graph_.add_table(table));
  }

  double number(const Text& text, const std::string& where) {
    Scope none;
    none.find = [](std::string_view) { return std::nullopt; };
    none.refusal = [](std::string_view name) { return fmt::format("the name {} cannot be used", name); };
    none.rates = false;
    const double value = names_.value_of(parse_expression(graph_, text_.source, text, none, where, &names_.hazards));
    if (!std::isfinite(value)) names_.refuse(text.place, fmt::format("the number {} is not finite", where));
    return value;
  }

  ParameterInfo info_of(const ParameterText& text) {
    ParameterInfo info;
    info.name = text.name.text;
    info.unit = text.unit;
    info.meaning = text.meaning;
    const auto bound = [&](const Text& of, const char* which) {
      return number(of, fmt::format("in the {} of the parameter {}", which, info.name));
    };
    if (text.min && text.above)
      names_.refuse(text.above->place, fmt::format("the parameter {} has both min and above", info.name));
    if (text.max && text.below)
      names_.refuse(text.below->place, fmt::format("the parameter {} has both max and below", info.name));
    if (text.min) info.lower = bound(*text.min, "min");
    if (text.above) info.lower = bound(*text.above, "above");
    info.lower_open = text.above.has_value();
    if (text.max) info.upper = bound(*text.max, "max");
    // The next smaller number: ranges have no open upper end.
    if (text.below) info.upper = std::nextafter(bound(*text.below, "below"), -std::numeric_limits<double>::infinity());
    if (info.upper < info.lower)
      names_.refuse(text.name.place,
                    fmt::format("no value is allowed for the parameter {}: its range is {}", info.name, range_text(info)));
    return info;
  }

  void check_range(const ParameterInfo& info, const Text& value) const {
    try {
      check_parameters({info}, Vector::Constant(1, info.default_value));
    } catch (const std::invalid_argument& error) {
      names_.refuse(value.place, error.what());
    }
  }

  /// A parameter that is the coefficient of restitution of a stop lies between 0 and 1.
  void limit_restitution(ParameterInfo& info) const {
    const bool is_one = std::any_of(text_.stops.begin(), text_.stops.end(), [&](const StopText& stop) {
      return stop.law.text == "newton" && stop.values.size() == 1 && stop.values.front().text == info.name;
    });
    if (!is_one) return;
    if (info.lower < 0.0) info.lower_open = false;
    info.lower = std::max(info.lower, 0.0);
    info.upper = std::min(info.upper, 1.0);
  }

  void read_parameters() {
    std::vector<Definition> tied;
    std::vector<ParameterInfo> tied_infos;
    std::vector<ParameterInfo>& free = names_.parameters;
    for (const ParameterText& one : text_.parameters) {
      const std::string where = fmt::format("in the parameter {}", one.name.text);
      ParameterInfo info = info_of(one);
      limit_restitution(info);
      if (has_names(text_.source, one.value, where)) {
        tied.push_back({one.name, one.value});
        tied_infos.push_back(info);
        continue;
      }
      info.default_value = number(one.value, where);
      check_range(info, one.value);
      names_.meanings.emplace(info.name, graph_.parameter(free.size()));
      free.push_back(info);
    }
    names_.defaults = default_parameters(free);
    for (const ParameterInfo& info : free) names_.symbols.parameters.push_back(info.name);
    const std::vector<Expression> expressions =
        parse_definitions(graph_, text_.source, tied, names_.parameter_scope(), "parameter", &names_.hazards);
    for (std::size_t i = 0; i < tied.size(); ++i) {
      const Expression e = expressions[i];
      ParameterInfo& info = tied_infos[i];
      info.default_value = names_.value_of(e);
      check_range(info, tied[i].value);
      names_.meanings.emplace(info.name, e);
      TiedParameter one;
      one.info = info;
      one.value = function_of_parameters(graph_, e);
      one.dp = gradient_of_parameters(graph_, e);
      names_.tied.push_back(std::move(one));
    }
  }

  void read_definitions() {
    const std::vector<Expression> expressions =
        parse_definitions(graph_, text_.source, text_.definitions, names_.scope(true), "definition", &names_.hazards);
    for (std::size_t i = 0; i < expressions.size(); ++i) names_.meanings.emplace(text_.definitions[i].name.text, expressions[i]);
  }

  void read_start() {
    if (text_.start.empty()) return;
    Vector x = Vector::Constant(static_cast<Eigen::Index>(names_.states.size()), std::nan(""));
    for (const StartText& one : text_.start) {
      const auto i = names_.state_number(one.state.text);
      if (!i)
        names_.refuse(one.state.place, fmt::format("the start gives '{}', which is no state{}", one.state.text,
                                                   suggestion_or_list(one.state.text, names_.symbols.states)));
      double& value = x[static_cast<Eigen::Index>(*i)];
      if (!std::isnan(value)) names_.refuse(one.state.place, fmt::format("the start gives {} twice", one.state.text));
      value = names_.value_of(parse_expression(graph_, text_.source, one.value, names_.parameter_scope(),
                                               fmt::format("in the start of {}", one.state.text), &names_.hazards));
      if (!std::isfinite(value)) names_.refuse(one.value.place, fmt::format("the start of {} is not finite", one.state.text));
    }
    for (double& value : x)
      if (std::isnan(value)) value = 0.0;
    names_.start = x;
  }

  const SystemText& text_;
  Graph& graph_;
  Names names_;
};

}  // namespace

Names read_names(const SystemText& text, Graph& graph) { return NamesReader(text, graph).read(); }

}  // namespace graze::equations
