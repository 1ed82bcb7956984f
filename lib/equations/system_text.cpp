// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/system_text.hpp>

#include <graze/lib/equations/functions.hpp>
#include <graze/lib/equations/initial_mode.hpp>
#include <graze/lib/equations/nonsmooth.hpp>
#include <graze/lib/equations/not_finite.hpp>
#include <graze/lib/equations/polynomial.hpp>
#include <graze/lib/equations/sliding.hpp>
#include <graze/lib/equations/structure.hpp>
#include <graze/lib/system/guard_rounding.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>

namespace graze::equations {

namespace {

constexpr std::array event_kinds = {EventKind::impact, EventKind::enter,   EventKind::leave,
                                    EventKind::stick,  EventKind::release, EventKind::other};

/// Number of states on a guard at which its reset is tested, including one from the start.
constexpr int reset_trials = 40;
/// Tolerance for the periodicity of the field, relative to its size: far above rounding, far below the effect of a wrong
/// period.
constexpr double period_tolerance = 1e-8;

class Builder {
 public:
  explicit Builder(const SystemText& text) : text_(text), graph_(*(out_.graph = std::make_shared<Graph>())) {}

  TextSystem build() {
    read_names();
    read_parameters();
    read_definitions();
    read_start();
    make_modes();
    read_events();
    if (const bool timed = read_forcing(); !timed) refuse_time();
    pieces_ = split_nonsmooth(graph_, pieces_, out_.system.parameters, symbols_, text_.source);
    replace_contact_powers();
    finish_resets();
    build_modes();
    build_events();
    read_outputs();
    read_units();
    out_.system.initial_mode = mode_by_guards(out_.system, constraints_, conditions_);
    validate(out_.system);
    check_values();
    check_period();
    check_resets();
    out_.names = names_;
    for (auto& [name, expression] : out_.names) expression = graph_.substitute(expression, contact_powers_);
    out_.tables = tables_;
    out_.source = text_.source;
    out_.symbols = symbols_;
    out_.hazards = std::move(hazards_);
    return std::move(out_);
  }

 private:
  [[noreturn]] void refuse(const Place& place, const std::string& message) const {
    throw EquationError(text_.source, place, message);
  }
  Eigen::Index states() const { return static_cast<Eigen::Index>(state_texts_.size()); }

  // Names -------------------------------------------------------------------------------------------------------------------

  void declare(const Text& name, const std::string& kind, const std::string& article) {
    if (name.text.empty()) refuse(name.place, fmt::format("a {} without a name", kind));
    if (!is_name(name.text))
      refuse(name.place, fmt::format("'{}' is no name for {} {}: letters, digits and _ are, beginning with a letter", name.text,
                                     article, kind));
    const auto& reserved = reserved_names();
    if (std::find(reserved.begin(), reserved.end(), name.text) != reserved.end())
      refuse(name.place, fmt::format("{} {} cannot be called '{}', which is {}", article, kind, name.text,
                                     name.text == "t"    ? "the time"
                                     : name.text == "pi" ? "the number pi"
                                                         : "a function"));
    const auto [at, is_new] = kinds_.try_emplace(name.text, kind);
    if (!is_new)
      refuse(name.place, fmt::format("the name '{}' of {} {} is that of a {} already", name.text, article, kind, at->second));
  }

  template <class List, class NameOf> void distinct(const List& list, const char* kind, const NameOf& name_of) const {
    std::map<std::string, int> seen;
    for (const auto& one : list) {
      const Text& name = name_of(one);
      if (name.text.empty()) refuse(name.place, fmt::format("{} without a name", kind));
      if (++seen[name.text] > 1) refuse(name.place, fmt::format("{} called '{}' exists already", kind, name.text));
    }
  }

  void read_states() {
    state_texts_ = text_.state_texts();
    if (!text_.mechanics) {
      if (!text_.stops.empty()) refuse(text_.stops[0].name.place, "a stop needs mechanics, with coordinates and a mass matrix");
      if (!text_.friction.empty())
        refuse(text_.friction[0].name.place,
               "friction needs mechanics, with a mass matrix; without, it is a surface where two modes meet");
      if (state_texts_.empty()) refuse({}, "the system has no states");
      return;
    }
    const MechanicsText& mechanics = *text_.mechanics;
    if (!text_.states.empty())
      refuse(text_.states[0].place, "both states and mechanics are given; the states are the coordinates, then the velocities");
    if (!text_.modes.empty())
      refuse(text_.modes[0].name.place, "both modes and mechanics are given; the modes follow from the mechanics");
    if (mechanics.coordinates.empty()) refuse(mechanics.place, "the mechanics has no coordinates");
    if (mechanics.velocities.size() != mechanics.coordinates.size())
      refuse(
          mechanics.velocities.empty() ? mechanics.place : mechanics.velocities[0].place,
          fmt::format("there are {} coordinates and {} velocities", mechanics.coordinates.size(), mechanics.velocities.size()));
  }

  void read_names() {
    out_.system.name = text_.name;
    read_states();
    for (const Text& state : state_texts_) declare(state, "state", "a");
    for (const ParameterText& parameter : text_.parameters) declare(parameter.name, "parameter", "a");
    for (const Definition& definition : text_.definitions) declare(definition.name, "definition", "a");
    for (const Definition& output : text_.outputs) declare(output.name, "output", "an");
    distinct(text_.modes, "a mode", [](const ModeText& mode) -> const Text& { return mode.name; });
    distinct(text_.events, "an event", [](const EventText& event) -> const Text& { return event.name; });
    for (std::size_t i = 0; i < state_texts_.size(); ++i) {
      symbols_.states.push_back(state_texts_[i].text);
      names_.emplace(state_texts_[i].text, graph_.state(i));
    }
    out_.system.states = state_texts_.size();
    out_.system.state_names = symbols_.states;
    for (const Table& table : text_.tables) tables_.emplace(table.name, graph_.add_table(table));
  }

  /// The names known so far; declared names that are not known yet are refused with the message of `refusal`.
  Scope scope(bool with_time) {
    Scope out;
    out.find = [this](std::string_view name) -> std::optional<Expression> {
      const auto found = names_.find(name);
      return found == names_.end() ? std::nullopt : std::optional(found->second);
    };
    out.table = [this](std::string_view name) -> std::optional<std::size_t> {
      const auto found = tables_.find(name);
      return found == tables_.end() ? std::nullopt : std::optional(found->second);
    };
    for (const auto& [name, expression] : names_) out.names.push_back(name);
    for (const auto& [name, number] : tables_) out.tables.push_back(name);
    out.refusal = [this, with_time](std::string_view name) -> std::string {
      if (name == "t") return with_time ? std::string() : "the time t cannot be used";
      const auto kind = kinds_.find(name);
      return kind == kinds_.end() ? std::string() : fmt::format("the {} {} cannot be used", kind->second, name);
    };
    return out;
  }

  /// Names of parameters only.
  Scope parameter_scope() {
    Scope out = scope(false);
    out.rates = false;
    out.find = [this](std::string_view name) -> std::optional<Expression> {
      const auto kind = kinds_.find(name);
      const auto found = names_.find(name);
      if (kind == kinds_.end() || kind->second != "parameter" || found == names_.end()) return std::nullopt;
      return found->second;
    };
    std::erase_if(out.names, [&](const std::string& name) { return kinds_.at(name) != "parameter"; });
    return out;
  }

  // Parameters --------------------------------------------------------------------------------------------------------------

  /// The value at the default parameters.
  double value_of(Expression e) const { return values(graph_, {&e, 1}, 0.0, Vector::Zero(states()), defaults_)[0]; }

  /// The function of an expression of parameters only.
  std::function<double(const Vector& p)> function_of_parameters(Expression e) {
    return [value = scalar_function(graph_, e)](const Vector& p) { return value(0.0, {}, p); };
  }
  std::function<void(const Vector& p, Vector& out)> gradient_of_parameters(Expression e) {
    return [gradient = gradient_in_parameters(graph_, e)](const Vector& p, Vector& out) {
      if (gradient) {
        gradient(0.0, {}, p, out);
      } else {
        out.setZero();
      }
    };
  }

  double number(const Text& text, const std::string& where) {
    Scope none;
    none.find = [](std::string_view) { return std::nullopt; };
    none.refusal = [](std::string_view name) { return fmt::format("the name {} cannot be used", name); };
    none.rates = false;
    const double value = value_of(parse_expression(graph_, text_.source, text, none, where, &hazards_));
    if (!std::isfinite(value)) refuse(text.place, fmt::format("the number {} is not finite", where));
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
    if (text.min && text.above) refuse(text.above->place, fmt::format("the parameter {} has both min and above", info.name));
    if (text.max && text.below) refuse(text.below->place, fmt::format("the parameter {} has both max and below", info.name));
    if (text.min) info.lower = bound(*text.min, "min");
    if (text.above) info.lower = bound(*text.above, "above");
    info.lower_open = text.above.has_value();
    if (text.max) info.upper = bound(*text.max, "max");
    // The next smaller number: ranges have no open upper end.
    if (text.below) info.upper = std::nextafter(bound(*text.below, "below"), -std::numeric_limits<double>::infinity());
    if (info.upper < info.lower)
      refuse(text.name.place,
             fmt::format("no value is allowed for the parameter {}: its range is {}", info.name, range_text(info)));
    return info;
  }

  void check_range(const ParameterInfo& info, const Text& value) const {
    try {
      check_parameters({info}, Vector::Constant(1, info.default_value));
    } catch (const std::invalid_argument& error) {
      refuse(value.place, error.what());
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
    std::vector<ParameterInfo>& free = out_.system.parameters;
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
      names_.emplace(info.name, graph_.parameter(free.size()));
      free.push_back(info);
    }
    defaults_ = default_parameters(free);
    for (const ParameterInfo& info : free) symbols_.parameters.push_back(info.name);
    const std::vector<Expression> expressions =
        parse_definitions(graph_, text_.source, tied, parameter_scope(), "parameter", &hazards_);
    for (std::size_t i = 0; i < tied.size(); ++i) {
      const Expression e = expressions[i];
      ParameterInfo& info = tied_infos[i];
      info.default_value = value_of(e);
      check_range(info, tied[i].value);
      names_.emplace(info.name, e);
      TiedParameter one;
      one.info = info;
      one.value = function_of_parameters(e);
      one.dp = gradient_of_parameters(e);
      out_.tied.push_back(std::move(one));
    }
  }

  void read_definitions() {
    const std::vector<Expression> expressions =
        parse_definitions(graph_, text_.source, text_.definitions, scope(true), "definition", &hazards_);
    for (std::size_t i = 0; i < expressions.size(); ++i) names_.emplace(text_.definitions[i].name.text, expressions[i]);
  }

  // Modes and events ---------------------------------------------------------------------------------------------------------

  /// Replaces rates by expressions of the mode's field.
  class Rates {
   public:
    Rates(Builder& builder, const ModePiece& mode)
        : builder_(builder), mode_(mode), field_(mode.field.size()), in_progress_(mode.field.size(), false) {}

    Expression resolve(Expression e) {
      Graph& graph = builder_.graph_;
      if (!dependence(graph, e).rate) return e;
      Replacement known;
      for (const Expression part : reachable(graph, e)) {
        const Node n = graph.node(part);
        if (n.operation != Operation::rate) continue;
        known.emplace(part.index, rate_along(graph, graph.substitute(n.a, known), [this](std::size_t i) { return field(i); }));
      }
      return graph.substitute(e, known);
    }

    Expression field(std::size_t i) {
      if (field_[i]) return *field_[i];
      if (in_progress_[i])
        builder_.refuse(mode_.equation[i],
                        fmt::format("the rate of {} in mode {} depends on itself", builder_.symbols_.states[i], mode_.name));
      in_progress_[i] = true;
      field_[i] = resolve(mode_.field[i]);
      return *field_[i];
    }

   private:
    Builder& builder_;
    const ModePiece& mode_;
    std::vector<std::optional<Expression>> field_;
    std::vector<char> in_progress_;
  };

  std::optional<std::size_t> state_number(const std::string& name) const {
    const auto found = std::find(symbols_.states.begin(), symbols_.states.end(), name);
    return found == symbols_.states.end() ? std::nullopt
                                          : std::optional(static_cast<std::size_t>(found - symbols_.states.begin()));
  }

  void read_modes() {
    if (text_.modes.empty()) refuse({}, "the system has no modes");
    const Scope names = scope(true);
    for (const ModeText& text : text_.modes) {
      ModePiece mode;
      mode.name = text.name.text;
      mode.place = text.name.place;
      std::vector<std::optional<Assignment>> equation(state_texts_.size());
      const auto where = [&](std::string_view name) { return fmt::format("in the equation of {}", name); };
      for (Assignment& one :
           parse_block(graph_, text_.source, text.equations, names, where, fmt::format("in mode {}", mode.name), &hazards_)) {
        const auto i = state_number(one.name);
        if (!i)
          refuse(one.place, fmt::format("an equation of '{}', which is no state, in mode {}{}", one.name, mode.name,
                                        suggestion(one.name, symbols_.states)));
        if (!one.primed) refuse(one.place, fmt::format("an equation of mode {} begins with {}' =", mode.name, one.name));
        if (equation[*i]) refuse(one.place, fmt::format("a second equation of {} in mode {}", one.name, mode.name));
        equation[*i] = std::move(one);
      }
      for (std::size_t i = 0; i < equation.size(); ++i) {
        if (!equation[i])
          refuse(text.name.place.line > 0 ? text.name.place : text.equations.place,
                 fmt::format("the state {} has no equation in mode {}", symbols_.states[i], mode.name));
        mode.field.push_back(equation[i]->value);
        mode.equation.push_back(equation[i]->equation);
      }
      pieces_.modes.push_back(std::move(mode));
    }
    std::vector<std::vector<Expression>> resolved;
    for (const ModePiece& mode : pieces_.modes) {
      Rates rates(*this, mode);
      resolved.emplace_back();
      for (std::size_t i = 0; i < symbols_.states.size(); ++i) resolved.back().push_back(rates.field(i));
    }
    for (std::size_t m = 0; m < pieces_.modes.size(); ++m) pieces_.modes[m].field = resolved[m];
  }

  /// Makes the modes from the text, from mechanics and from surfaces.
  void make_modes() {
    const Reading reading{graph_, text_, scope(true), &hazards_, symbols_, out_.system.parameters, defaults_, out_.start};
    if (text_.mechanics) {
      pieces_ = make_mechanics(reading);
    } else {
      read_modes();
    }
    add_surfaces(reading, pieces_);
    for (const ModePiece& mode : pieces_.modes) rates_.emplace_back(*this, mode);
  }

  std::size_t mode_number(const Text& name, const std::string& event) const {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < pieces_.modes.size(); ++i) {
      if (pieces_.modes[i].name == name.text) return i;
      names.push_back(pieces_.modes[i].name);
    }
    refuse(name.place,
           fmt::format("the event {} names an unknown mode '{}'{}", event, name.text, suggestion_or_list(name.text, names)));
  }

  /// A mode to which a reset may lead; it does if the conditions are positive.
  struct Side {
    std::size_t mode = 0;
    std::vector<Expression> conditions;
  };

  /// Finds the modes after a reset that names no mode: it stays in its mode, but goes to the side of a surface on which it
  /// ends.
  void find_sides(const Side& side, const std::vector<Expression>& decided, const std::vector<Expression>& map,
                  std::vector<Side>& out) {
    Replacement after;
    for (std::size_t i = 0; i < map.size(); ++i) after.emplace(graph_.state(i).index, map[i]);
    for (const SurfacePiece& surface : pieces_.surfaces) {
      if (!surface.parts(side.mode) || std::find(decided.begin(), decided.end(), surface.h) != decided.end()) continue;
      const Expression behind = graph_.substitute(surface.h, after);
      const Expression change = side.mode == surface.sliding ? graph_.substitute(behind, surface.rounding_distance)
                                                             : graph_.subtract(behind, surface.h);
      if (is_zero(graph_, change)) continue;
      std::vector<Expression> known = decided;
      known.push_back(surface.h);
      for (const bool upwards : {true, false}) {
        if (surface.below == surface.above && !upwards) break;
        Side next{upwards ? surface.above : surface.below, side.conditions};
        if (surface.below != surface.above) next.conditions.push_back(upwards ? behind : graph_.negate(behind));
        find_sides(next, known, map, out);
      }
      return;
    }
    out.push_back(side);
  }

  void read_events() {
    const Scope names = scope(true);
    for (std::size_t number = 0; number < text_.events.size(); ++number) {
      const EventText& text = text_.events[number];
      const std::string& name = text.name.text;
      EventPiece event{
          .name = name, .text = number, .count = text.count, .guard = {}, .map = {}, .when = text.when.place, .reset = {}};
      if (text.kind) {
        std::vector<std::string> kinds;
        for (const EventKind kind : event_kinds) kinds.emplace_back(event_kind_name(kind));
        const auto found = std::find(kinds.begin(), kinds.end(), text.kind->text);
        if (found == kinds.end())
          refuse(text.kind->place, fmt::format("the event {} has an unknown kind '{}'{}", name, text.kind->text,
                                               suggestion_or_list(text.kind->text, kinds)));
        event.kind = event_kinds[static_cast<std::size_t>(found - kinds.begin())];
      }
      const Expression guard =
          parse_expression(graph_, text_.source, text.when, names, fmt::format("in the guard of {}", name), &hazards_);
      std::vector<Expression> map;
      for (std::size_t i = 0; i < symbols_.states.size(); ++i) map.push_back(graph_.state(i));
      if (text.reset) {
        event.reset = text.reset->place;
        std::vector<char> seen(map.size(), 0);
        const auto where = [&](std::string_view of) { return fmt::format("in the reset of {} by {}", of, name); };
        for (const Assignment& one :
             parse_block(graph_, text_.source, *text.reset, names, where, fmt::format("in the reset of {}", name), &hazards_)) {
          const auto i = state_number(one.name);
          if (!i)
            refuse(one.place, fmt::format("the reset of {} sets '{}', which is no state{}", name, one.name,
                                          suggestion_or_list(one.name, symbols_.states)));
          if (one.primed) refuse(one.place, fmt::format("the reset of {} sets a rate; write {} = ...", name, one.name));
          if (seen[*i]++) refuse(one.place, fmt::format("the reset of {} sets {} twice", name, one.name));
          map[*i] = one.value;
        }
      }
      const std::size_t first = text.from ? mode_number(*text.from, name) : 0;
      const std::size_t last = text.from ? first : pieces_.modes.size() - 1;
      for (event.from = first; event.from <= last; ++event.from) {
        event.to = text.to ? mode_number(*text.to, name) : event.from;
        event.guard = rates_[event.from].resolve(guard);
        if (dependence(graph_, event.guard).states.empty() || is_zero(graph_, event.guard))
          refuse(text.when.place, fmt::format("the guard of {} does not depend on the motion: no state stands in it", name));
        event.map.clear();
        for (const Expression one : map) event.map.push_back(rates_[event.from].resolve(one));
        std::vector<Side> sides;
        if (text.to) {
          sides.push_back({event.to, {}});
        } else {
          find_sides({event.to, {}}, {}, event.map, sides);
        }
        for (std::size_t i = 0; i < sides.size(); ++i) {
          event.to = sides[i].mode;
          event.otherwise.reset();
          if (i + 1 < sides.size()) event.otherwise = AlternativePiece{sides[i].conditions, pieces_.events.size() + 1};
          pieces_.events.push_back(event);
        }
      }
    }
  }

  // Forcing ------------------------------------------------------------------------------------------------------------------

  /// False: the system is not forced.
  bool read_forcing() {
    if (text_.forcing && text_.period) refuse(text_.period->place, "both a forcing frequency and a period are given");
    if (!text_.forcing && !text_.period) return false;
    const Expression two_pi = graph_.multiply(graph_.constant(2.0), graph_.pi());
    const Text& place = text_.forcing ? *text_.forcing : *text_.period;
    Expression period;
    if (text_.forcing) {
      const auto kind = kinds_.find(text_.forcing->text);
      if (kind == kinds_.end() || kind->second != "parameter") {
        std::vector<std::string> candidates;
        for (const ParameterText& one : text_.parameters) candidates.push_back(one.name.text);
        refuse(place.place, fmt::format("the forcing frequency '{}' is no parameter{}", text_.forcing->text,
                                        suggestion_or_list(text_.forcing->text, candidates)));
      }
      period = graph_.divide(two_pi, names_.at(text_.forcing->text));
    } else {
      period = parse_expression(graph_, text_.source, *text_.period, parameter_scope(), "in the period", &hazards_);
    }
    const double value = value_of(period);
    if (!(value > 0.0) || !std::isfinite(value))
      refuse(place.place, text_.forcing ? fmt::format("the forcing frequency is {} by default; allowed is > 0",
                                                      value_of(names_.at(text_.forcing->text)))
                                        : fmt::format("the period is {} by default; allowed is > 0", value));
    const auto on = dependence(graph_, period).parameters;
    if (on.size() == 1 && is_zero(graph_, graph_.subtract(graph_.multiply(period, graph_.parameter(on[0])), two_pi))) {
      out_.system.forcing_frequency = on[0];
      ParameterInfo& frequency = out_.system.parameters[on[0]];
      if (frequency.lower <= 0.0) {
        frequency.lower = 0.0;
        frequency.lower_open = true;
      }
      return true;
    }
    out_.system.period = ForcingPeriod{function_of_parameters(period), gradient_of_parameters(period)};
    return true;
  }

  /// Refuses the time in an autonomous system. Of mechanics, the first mode has no contact: a stop that moves is named itself.
  void refuse_time() const {
    const auto refuse_in = [&](const ModePiece& mode) {
      for (std::size_t i = 0; i < mode.field.size(); ++i)
        if (dependence(graph_, mode.field[i]).time)
          refuse(mode.equation[i],
                 fmt::format("the equation of {} depends on the time, but neither a forcing frequency nor a period is given",
                             symbols_.states[i]));
    };
    if (!pieces_.modes.empty()) refuse_in(pieces_.modes.front());
    for (const EventPiece& event : pieces_.events) {
      if (dependence(graph_, event.guard).time)
        refuse(event.when,
               fmt::format("the guard of {} depends on the time, but neither a forcing frequency nor a period is given",
                           event.name));
      if (dependence(graph_, event.map).time)
        refuse(event.reset,
               fmt::format("the reset of {} depends on the time, but neither a forcing frequency nor a period is given",
                           event.name));
    }
    for (const ModePiece& mode : pieces_.modes) refuse_in(mode);
  }

  void check_period() const {
    if (!is_forced(out_.system)) return;
    const double T = forcing_period(out_.system, defaults_);
    const Vector x = out_.start ? *out_.start : Vector::Constant(states(), 0.1);
    // Instants without a simple relation to the period.
    for (const double phase : {0.137, 0.618}) {
      for (std::size_t m = 0; m < pieces_.modes.size(); ++m) {
        const ModePiece& mode = pieces_.modes[m];
        const std::vector<double> before = values(graph_, mode.field, phase * T, x, defaults_);
        const std::vector<double> after = values(graph_, mode.field, (1.0 + phase) * T, x, defaults_);
        for (std::size_t i = 0; i < before.size(); ++i)
          if (std::abs(after[i] - before[i]) > period_tolerance * (1.0 + std::abs(before[i])))
            refuse(mode.equation[i], fmt::format("the equation of {} does not repeat with the period {}", symbols_.states[i], T));
      }
    }
  }

  // Contact laws, resets -----------------------------------------------------------------------------------------------------

  void replace_contact_powers() {
    for (std::size_t m = 0; m < pieces_.modes.size(); ++m) {
      ModePiece& mode = pieces_.modes[m];
      Replacement replacement;
      for (std::size_t i = 0; i < mode.field.size(); ++i) {
        for (const Expression part : reachable(graph_, mode.field[i])) {
          const Node n = graph_.node(part);
          const bool root = n.operation == Operation::sqrt;
          if ((n.operation != Operation::power && !root) || replacement.contains(part.index)) continue;
          if (!dependence(graph_, n.a).moves() || bounds(graph_, n.a, out_.system.parameters).lower >= 0.0) continue;
          const Place place = known_place(graph_, hazards_, part).value_or(mode.equation[i]);
          const bool entered = std::any_of(pieces_.events.begin(), pieces_.events.end(), [&](const EventPiece& event) {
            return event.to == m && event.from != m && is_zero(graph_, graph_.subtract(event.guard, n.a));
          });
          if (!entered && root) continue;  // a root is checked at the start only
          const std::string base = to_text(graph_, n.a, symbols_, 60);
          const double exponent = root ? 0.5 : value_of_constant(n.b);
          if (!entered)
            refuse(place, fmt::format("{} may become negative under an exponent that is no integer, in mode {}, which is not "
                                      "entered through it as a guard",
                                      base, mode.name));
          if (!(exponent >= 1.0))
            refuse(place, fmt::format("the power of {} has an infinite derivative at the guard through which mode {} is entered",
                                      base, mode.name));
          replacement.emplace(part.index, graph_.contact_power(n.a, exponent));
        }
      }
      for (Expression& one : mode.field) one = graph_.substitute(one, replacement);
      for (ConstraintPiece& constraint : mode.constraints)
        for (Expression& one : constraint.direction) one = graph_.substitute(one, replacement);
      contact_powers_.insert(replacement.begin(), replacement.end());
    }
  }

  /// The value of a constant expression; NaN: it is not constant.
  double value_of_constant(Expression e) const {
    const Dependence on = dependence(graph_, e);
    return on.moves() || !on.parameters.empty() ? std::nan("") : value_of(e);
  }

  bool is_identity(const EventPiece& event) const {
    for (std::size_t i = 0; i < event.map.size(); ++i)
      if (event.map[i] != graph_.state(i)) return false;
    return true;
  }

  /// Sets one state that a reset leaves unchanged to its exact value on the guard, if the guard is linear in it: rounding could
  /// leave the state beyond the guard.
  void finish_resets() {
    for (EventPiece& event : pieces_.events) {
      if (is_identity(event)) continue;
      const auto kept = [&](std::size_t i) { return event.map[i] == graph_.state(i); };
      if (const auto solution = solve_guard(graph_, event.guard, event.map.size(), kept))
        event.map[solution->state] = solution->value;
    }
  }

  /// True if the fields of both modes agree where the guard vanishes.
  bool fields_agree(const EventPiece& event) {
    const auto& f = pieces_.modes[event.from].field;
    const auto& g = pieces_.modes[event.to].field;
    if (f == g) return true;
    for (std::size_t i = 0; i < f.size(); ++i)
      if (!vanishes_on(graph_, graph_.subtract(g[i], f[i]), event.guard, out_.system.parameters)) return false;
    return true;
  }

  void build_modes() {
    std::map<Expression, std::size_t> numbers;  // numbers of the constraints
    for (const ModePiece& piece : pieces_.modes) {
      Mode mode;
      mode.name = piece.name;
      mode.field = vector_function(graph_, piece.field);
      mode.field_dx = derivative_in_states(graph_, piece.field);
      mode.field_dp = derivative_in_parameters(graph_, piece.field);
      if (!mode.field_dp) mode.field_dp = [](double, const Vector&, const Vector&, Matrix& J) { J.setZero(); };
      mode.field_dt = derivative_in_time(graph_, piece.field);
      mode.structure = recognise_structure(graph_, piece.field, out_.system.forcing_frequency, out_.system.parameters.size());
      conditions_.emplace_back();
      for (const Expression one : piece.conditions) conditions_.back().push_back(scalar_function(graph_, one));
      constraints_.emplace_back();
      for (const ConstraintPiece& one : piece.constraints) {
        // If the constraint fixes one state at a constant value, the motion in the mode preserves it exactly.
        const auto fixed = solve_guard(graph_, one.value, states(), [](std::size_t) { return true; });
        const bool exact = fixed && !dependence(graph_, fixed->value).moves();
        constraints_.back().push_back({scalar_function(graph_, one.value), exact ? guard_tolerance : constraint_tolerance});
        mode.constraints.push_back({numbers.try_emplace(one.value, numbers.size()).first->second,
                                    scalar_function(graph_, one.value), gradient_in_states(graph_, one.value),
                                    gradient_in_parameters(graph_, one.value), vector_function(graph_, one.direction)});
      }
      out_.system.modes.push_back(std::move(mode));
      out_.modes.push_back({piece.field, piece.equation});
    }
  }

  void build_events() {
    for (const EventPiece& piece : pieces_.events) {
      Event event;
      event.name = piece.name;
      event.from = piece.from;
      event.to = piece.to;
      event.kind = piece.kind;
      // In a mode with constraints the guard is not marked as a level: continuity on the whole level would be tested, but it
      // holds only on the constraints.
      const auto level = pieces_.modes[piece.from].constraints.empty() ? recognise_level(graph_, piece.guard) : std::nullopt;
      if (level) {
        event.guard = make_level_guard(*level);
      } else {
        event.guard.value = scalar_function(graph_, piece.guard);
        event.guard.dx = gradient_in_states(graph_, piece.guard);
        event.guard.dp = gradient_in_parameters(graph_, piece.guard);
        event.guard.dt = scalar_derivative_in_time(graph_, piece.guard);
      }
      if (is_identity(piece)) {
        event.continuous = piece.from != piece.to && (piece.continuous || (!piece.decided && fields_agree(piece)));
        // A split may leave copies that no motion meets, of which it is not true.
        if (event.continuous && event.guard.level) event.continuous = is_continuous(out_.system, event);
      } else if (const auto rebound = recognise_rebound(graph_, piece.map, level); rebound && piece.from == piece.to) {
        event.reset = make_rebound(*rebound);
        const auto coefficient = static_cast<Eigen::Index>(rebound->coefficient);
        event.log_volume_change = [coefficient](const Vector& p) { return 2.0 * std::log(p[coefficient]); };
      } else {
        event.reset = reset_of(piece.map);
      }
      add_contact(piece, event);
      out_.system.events.push_back(std::move(event));
      out_.events.push_back({piece.guard, piece.map, piece.text, piece.count, piece.when, piece.reset});
      if (piece.count > 0) out_.system.returns.push_back(out_.system.events.size() - 1);
    }
  }

  Reset reset_of(const std::vector<Expression>& map) {
    Reset reset;
    reset.map = vector_function(graph_, map);
    reset.dx = derivative_in_states(graph_, map);
    reset.dp = derivative_in_parameters(graph_, map);
    reset.dt = derivative_in_time(graph_, map);
    return reset;
  }

  /// Adds the properties of an event that come from mechanics and surfaces.
  void add_contact(const EventPiece& piece, Event& event) {
    if (piece.effective_mass) event.effective_mass = scalar_function(graph_, *piece.effective_mass);
    if (piece.opening_rate) event.opening_rate = scalar_function(graph_, *piece.opening_rate);
    if (piece.restitution && !event.log_volume_change) {
      const ScalarFunction restitution = scalar_function(graph_, *piece.restitution);
      if (const double here = restitution(0.0, {}, default_parameters(out_.system.parameters)); !(here >= 0.0 && here <= 1.0))
        throw EquationError(text_.source, piece.when,
                            fmt::format("the restitution of the stop {} is {} at the parameters of the file; allowed is 0 to 1",
                                        piece.name, here));
      event.log_volume_change = [restitution](const Vector& p) { return 2.0 * std::log(std::abs(restitution(0.0, {}, p))); };
    }
    if (const auto& rest = piece.accumulation)
      event.accumulation = Accumulation{rest->sticking_mode, reset_of(rest->map), scalar_function(graph_, rest->pressing)};
    if (const auto& otherwise = piece.otherwise) {
      std::vector<ScalarFunction> conditions;
      for (const Expression one : otherwise->conditions) conditions.push_back(scalar_function(graph_, one));
      event.otherwise = Alternative{[conditions](double t, const Vector& x, const Vector& p) {
                                      double least = std::numeric_limits<double>::infinity();
                                      for (const ScalarFunction& one : conditions) least = std::min(least, one(t, x, p));
                                      return least;
                                    },
                                    otherwise->event};
    }
  }

  void read_outputs() {
    const std::vector<Expression> expressions =
        parse_definitions(graph_, text_.source, text_.outputs, scope(true), "output", &hazards_);
    for (std::size_t number = 0; number < expressions.size(); ++number) {
      const Expression raw = expressions[number];
      names_.emplace(text_.outputs[number].name.text, raw);
      const bool by_mode = dependence(graph_, raw).rate;
      std::vector<ScalarFunction> of_mode;
      for (std::size_t m = 0; m < (by_mode ? pieces_.modes.size() : 1); ++m) {
        Expression e = raw;
        if (by_mode) {
          Rates rates(*this, pieces_.modes[m]);
          e = rates.resolve(raw);
        }
        of_mode.push_back(scalar_function(graph_, graph_.substitute(e, contact_powers_)));
      }
      out_.outputs.push_back(
          {text_.outputs[number].name.text, [of_mode](std::size_t mode, double t, const Vector& x, const Vector& p) {
             return of_mode[of_mode.size() == 1 ? 0 : mode](t, x, p);
           }});
    }
  }

  void read_units() {
    const auto add = [this](const ParameterInfo& info) {
      if (info.unit != ParameterInfo().unit) out_.units.emplace(info.name, info.unit);
    };
    for (const ParameterInfo& info : out_.system.parameters) add(info);
    for (const TiedParameter& tied : out_.tied) add(tied.info);
    for (const UnitText& one : text_.units) {
      const std::string& name = one.name.text;
      const auto kind = kinds_.find(name);
      if (kind == kinds_.end() && name != "t") {
        std::vector<std::string> candidates = {"t"};
        for (const auto& [known, what] : kinds_)
          if (what != "parameter") candidates.push_back(known);
        refuse(one.name.place,
               fmt::format("a unit of '{}', which is no state, definition or output{}", name, suggestion(name, candidates)));
      }
      if (kind != kinds_.end() && kind->second == "parameter")
        refuse(one.name.place,
               fmt::format("the unit of a parameter stands with it: {} = {{ value = ..., unit = \"{}\" }}", name, one.unit));
      out_.units.insert_or_assign(name, one.unit);
    }
  }

  // Values at the start --------------------------------------------------------------------------------------------------------

  void read_start() {
    if (text_.start.empty()) return;
    Vector x = Vector::Constant(states(), std::nan(""));
    for (const StartText& one : text_.start) {
      const auto i = state_number(one.state.text);
      if (!i)
        refuse(one.state.place, fmt::format("the start gives '{}', which is no state{}", one.state.text,
                                            suggestion_or_list(one.state.text, symbols_.states)));
      double& value = x[static_cast<Eigen::Index>(*i)];
      if (!std::isnan(value)) refuse(one.state.place, fmt::format("the start gives {} twice", one.state.text));
      value = value_of(parse_expression(graph_, text_.source, one.value, parameter_scope(),
                                        fmt::format("in the start of {}", one.state.text), &hazards_));
      if (!std::isfinite(value)) refuse(one.value.place, fmt::format("the start of {} is not finite", one.state.text));
    }
    for (double& value : x)
      if (std::isnan(value)) value = 0.0;
    out_.start = x;
  }

  /// Checks divisions, roots and logarithms: those of parameters in every mode, those of the motion in the mode of the start.
  void check_values() const {
    const Vector zero = Vector::Zero(states());
    std::optional<std::size_t> start_mode;
    if (out_.start) {
      // Checked before the mode is determined: a guard may divide by zero, too.
      for (const EventPiece& event : pieces_.events) check_values(event.guard, *out_.start, true, event.when);
      start_mode = mode_at(out_.system, 0.0, *out_.start, defaults_);
      if (!start_mode) {
        std::vector<std::string> contacts, others;  // each name once; a stop has guards in many modes
        for (const EventPiece& event : pieces_.events) {
          std::vector<std::string>& list = begins_contact(event.kind) ? contacts : others;
          const bool beyond = values(graph_, {&event.guard, 1}, 0.0, *out_.start, defaults_)[0] > 0.0;
          if (beyond && std::find(list.begin(), list.end(), event.name) == list.end()) list.push_back(event.name);
        }
        refuse(text_.start.front().state.place, fmt::format("the start lies beyond a guard of every mode ({})",
                                                            fmt::join(contacts.empty() ? others : contacts, ", ")));
      }
    }
    for (std::size_t m = 0; m < pieces_.modes.size(); ++m)
      for (std::size_t i = 0; i < pieces_.modes[m].field.size(); ++i)
        check_values(pieces_.modes[m].field[i], out_.start ? *out_.start : zero, start_mode == m, pieces_.modes[m].equation[i]);
    for (const EventPiece& event : pieces_.events) {
      if (!out_.start) check_values(event.guard, zero, false, event.when);
      for (const Expression one : event.map) check_values(one, zero, false, event.reset);
    }
  }

  void check_values(Expression root, const Vector& x, bool with_motion, const Place& otherwise) const {
    const auto check = [&](Expression part) {
      if (const auto found = find_not_finite({graph_, symbols_, hazards_}, part, 0.0, x, defaults_, otherwise))
        refuse(found->place, fmt::format("{} {}", found->sentence, found->moves ? "at the start" : "at the default parameters"));
    };
    for (const Expression part : reachable(graph_, root))
      if (operands(graph_.node(part).operation) > 0 && !dependence(graph_, part).moves()) check(part);
    if (with_motion) check(root);
  }

  /// Checks that a reset within a mode leaves its guard, at states on the guard near the start and at random ones.
  void check_resets() const {
    std::mt19937 engine(1);
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    const Vector& p = defaults_;
    Vector f(states()), gradient(states()), after(states());
    for (std::size_t e = 0; e < pieces_.events.size(); ++e) {
      const Event& event = out_.system.events[e];
      const EventPiece& piece = pieces_.events[e];
      if (event.from != event.to || piece.text >= text_.events.size()) continue;
      const Mode& mode = out_.system.modes[event.from];
      const auto rate = [&](double t, const Vector& x) {
        mode.field(t, x, p, f);
        return transversality(event.guard, t, x, f, p);
      };
      for (int trial = 0; trial < reset_trials; ++trial) {
        Vector x = out_.start ? *out_.start : Vector::Zero(states());
        for (double& value : x)
          if (trial > 0) value += any(engine) * (1.0 + std::abs(value));
        double h = event.guard.value(0.0, x, p);
        for (int i = 0; i < 30 && h != 0.0; ++i) {
          event.guard.dx(0.0, x, p, gradient);
          x -= gradient * (h / gradient.squaredNorm());
          h = event.guard.value(0.0, x, p);
        }
        if (!x.allFinite() || !(std::abs(h) <= guard_width(guard_scale(event.guard, 0.0, x, p), 0.0, x))) continue;
        const double arrives = rate(0.0, x);
        if (!(arrives > 1e-6 * (1.0 + f.lpNorm<Eigen::Infinity>()))) continue;
        if (event.reset.map) {
          event.reset.map(0.0, x, p, after);
        } else {
          after = x;
        }
        if (!after.allFinite()) continue;
        const double beyond = event.guard.value(0.0, after, p), leaves = rate(0.0, after);
        const double reach = 100.0 * guard_width(guard_scale(event.guard, 0.0, after, p), 0.0, after);
        const Place& place = piece.reset.line > 0 ? piece.reset : piece.when;
        if (beyond > reach || (beyond >= -reach && leaves > 1e-9 * (1.0 + f.lpNorm<Eigen::Infinity>())))
          refuse(place,
                 fmt::format("{} leaves the state beyond its guard in mode {}: the guard is {:.3g} and rises at the rate {:.3g} "
                             "after it; to mark an "
                             "instant at which nothing changes, write two modes with the same equations and an event each way",
                             event.reset.map ? fmt::format("the reset of {}", event.name)
                                             : fmt::format("{} has no reset and", event.name),
                             mode.name, std::abs(beyond) <= reach ? 0.0 : beyond, leaves));
        break;
      }
    }
  }

  const SystemText& text_;
  std::vector<Text> state_texts_;
  std::vector<std::vector<ToleratedConstraint>> constraints_;  // of each mode
  std::vector<std::vector<ScalarFunction>> conditions_;        // of each mode: see ModePiece
  TextSystem out_;
  Graph& graph_;
  std::map<std::string, std::string, std::less<>> kinds_;  // name -> "state", "parameter", "definition" or "output"
  std::map<std::string, Expression, std::less<>> names_;
  std::map<std::string, std::size_t, std::less<>> tables_;
  std::vector<Hazard> hazards_;
  Symbols symbols_;
  Vector defaults_;
  Pieces pieces_;
  std::vector<Rates> rates_;
  Replacement contact_powers_;
};

}  // namespace

std::vector<Text> SystemText::state_texts() const {
  if (!mechanics) return states;
  std::vector<Text> all = mechanics->coordinates;
  all.insert(all.end(), mechanics->velocities.begin(), mechanics->velocities.end());
  return all;
}

TextSystem make_system(const SystemText& text) { return Builder(text).build(); }

}  // namespace graze::equations
