// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/system_text.hpp>

#include <graze/lib/equations/check_system.hpp>
#include <graze/lib/equations/functions.hpp>
#include <graze/lib/equations/initial_mode.hpp>
#include <graze/lib/equations/nonsmooth.hpp>
#include <graze/lib/equations/polynomial.hpp>
#include <graze/lib/equations/read_pieces.hpp>
#include <graze/lib/equations/structure.hpp>
#include <graze/lib/system/guard_rounding.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace graze::equations {

namespace {

class Builder {
 public:
  explicit Builder(const SystemText& text)
      : text_(text), graph_(*(out_.graph = std::make_shared<Graph>())), names_(read_names(text, graph_)) {}

  TextSystem build() {
    HybridSystem& system = out_.system;
    system.name = text_.name;
    system.states = names_.states.size();
    system.state_names = names_.symbols.states;
    pieces_ = read_pieces(names_);
    if (const bool timed = read_forcing(); !timed) refuse_time();
    pieces_ = split_nonsmooth(graph_, pieces_, names_.parameters, names_.symbols, text_.source);
    replace_contact_powers();
    finish_resets();
    system.parameters = names_.parameters;
    build_modes();
    build_events();
    read_outputs();
    read_units();
    system.initial_mode = mode_by_guards(system, constraints_, conditions_);
    validate(system);
    check_system(system, names_, pieces_);
    out_.tied = std::move(names_.tied);
    out_.start = std::move(names_.start);
    out_.names = std::move(names_.meanings);
    for (auto& [name, expression] : out_.names) expression = graph_.substitute(expression, contact_powers_);
    out_.tables = std::move(names_.tables);
    out_.source = text_.source;
    out_.symbols = std::move(names_.symbols);
    out_.hazards = std::move(names_.hazards);
    return std::move(out_);
  }

 private:
  // Forcing ------------------------------------------------------------------------------------------------------------------

  /// False: the system is not forced.
  bool read_forcing() {
    if (text_.forcing && text_.period) names_.refuse(text_.period->place, "both a forcing frequency and a period are given");
    if (!text_.forcing && !text_.period) return false;
    const Expression two_pi = graph_.multiply(graph_.constant(2.0), graph_.pi());
    const Text& place = text_.forcing ? *text_.forcing : *text_.period;
    Expression period;
    if (text_.forcing) {
      if (!names_.is_parameter(text_.forcing->text)) {
        std::vector<std::string> candidates;
        for (const ParameterText& one : text_.parameters) candidates.push_back(one.name.text);
        names_.refuse(place.place, fmt::format("the forcing frequency '{}' is no parameter{}", text_.forcing->text,
                                               suggestion_or_list(text_.forcing->text, candidates)));
      }
      period = graph_.divide(two_pi, names_.meanings.at(text_.forcing->text));
    } else {
      period = parse_expression(graph_, text_.source, *text_.period, names_.parameter_scope(), "in the period", &names_.hazards);
    }
    const double value = names_.value_of(period);
    if (!(value > 0.0) || !std::isfinite(value))
      names_.refuse(place.place, text_.forcing ? fmt::format("the forcing frequency is {} by default; allowed is > 0",
                                                             names_.value_of(names_.meanings.at(text_.forcing->text)))
                                               : fmt::format("the period is {} by default; allowed is > 0", value));
    const auto on = dependence(graph_, period).parameters;
    if (on.size() == 1 && is_zero(graph_, graph_.subtract(graph_.multiply(period, graph_.parameter(on[0])), two_pi))) {
      out_.system.forcing_frequency = on[0];
      ParameterInfo& frequency = names_.parameters[on[0]];
      if (frequency.lower <= 0.0) {
        frequency.lower = 0.0;
        frequency.lower_open = true;
      }
      return true;
    }
    out_.system.period = ForcingPeriod{function_of_parameters(graph_, period), gradient_of_parameters(graph_, period)};
    return true;
  }

  /// Refuses the time in an autonomous system. Of mechanics, the first mode has no contact: a stop that moves is named itself.
  void refuse_time() const {
    const auto refuse_in = [&](const ModePiece& mode) {
      for (std::size_t i = 0; i < mode.field.size(); ++i)
        if (dependence(graph_, mode.field[i]).time)
          names_.refuse(
              mode.equation[i],
              fmt::format("the equation of {} depends on the time, but neither a forcing frequency nor a period is given",
                          names_.symbols.states[i]));
    };
    if (!pieces_.modes.empty()) refuse_in(pieces_.modes.front());
    for (const EventPiece& event : pieces_.events) {
      if (dependence(graph_, event.guard).time)
        names_.refuse(event.when,
                      fmt::format("the guard of {} depends on the time, but neither a forcing frequency nor a period is given",
                                  event.name));
      if (dependence(graph_, event.map).time)
        names_.refuse(event.reset,
                      fmt::format("the reset of {} depends on the time, but neither a forcing frequency nor a period is given",
                                  event.name));
    }
    for (const ModePiece& mode : pieces_.modes) refuse_in(mode);
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
          if (!dependence(graph_, n.a).moves() || bounds(graph_, n.a, names_.parameters).lower >= 0.0) continue;
          const Place place = known_place(graph_, names_.hazards, part).value_or(mode.equation[i]);
          const bool entered = std::any_of(pieces_.events.begin(), pieces_.events.end(), [&](const EventPiece& event) {
            return event.to == m && event.from != m && is_zero(graph_, graph_.subtract(event.guard, n.a));
          });
          if (!entered && root) continue;  // a root is checked at the start only
          const std::string base = to_text(graph_, n.a, names_.symbols, 60);
          const double exponent = root ? 0.5 : value_of_constant(n.b);
          if (!entered)
            names_.refuse(place,
                          fmt::format("{} may become negative under an exponent that is no integer, in mode {}, which is not "
                                      "entered through it as a guard",
                                      base, mode.name));
          if (!(exponent >= 1.0))
            names_.refuse(place,
                          fmt::format("the power of {} has an infinite derivative at the guard through which mode {} is entered",
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
    return on.moves() || !on.parameters.empty() ? std::nan("") : names_.value_of(e);
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
      if (!vanishes_on(graph_, graph_.subtract(g[i], f[i]), event.guard, names_.parameters)) return false;
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
      mode.structure = recognise_structure(graph_, piece.field, out_.system.forcing_frequency, names_.parameters.size());
      conditions_.emplace_back();
      for (const Expression one : piece.conditions) conditions_.back().push_back(scalar_function(graph_, one));
      constraints_.emplace_back();
      for (const ConstraintPiece& one : piece.constraints) {
        // If the constraint fixes one state at a constant value, the motion in the mode preserves it exactly.
        const auto fixed = solve_guard(graph_, one.value, names_.states.size(), [](std::size_t) { return true; });
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
      if (const double here = restitution(0.0, {}, names_.defaults); !(here >= 0.0 && here <= 1.0))
        names_.refuse(piece.when,
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
        parse_definitions(graph_, text_.source, text_.outputs, names_.scope(true), "output", &names_.hazards);
    for (std::size_t number = 0; number < expressions.size(); ++number) {
      const Expression raw = expressions[number];
      names_.meanings.emplace(text_.outputs[number].name.text, raw);
      const bool by_mode = dependence(graph_, raw).rate;
      std::vector<ScalarFunction> of_mode;
      for (std::size_t m = 0; m < (by_mode ? pieces_.modes.size() : 1); ++m) {
        Expression e = raw;
        if (by_mode) {
          Rates rates(names_, pieces_.modes[m]);
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
    for (const ParameterInfo& info : names_.parameters) add(info);
    for (const TiedParameter& tied : names_.tied) add(tied.info);
    for (const UnitText& one : text_.units) {
      const std::string& name = one.name.text;
      if (!names_.kinds.contains(name) && name != "t") {
        std::vector<std::string> candidates = {"t"};
        for (const auto& [known, what] : names_.kinds)
          if (what != "parameter") candidates.push_back(known);
        names_.refuse(one.name.place, fmt::format("a unit of '{}', which is no state, definition or output{}", name,
                                                  suggestion(name, candidates)));
      }
      if (names_.is_parameter(name))
        names_.refuse(one.name.place, fmt::format("the unit of a parameter stands with it: {} = {{ value = ..., unit = \"{}\" }}",
                                                  name, one.unit));
      out_.units.insert_or_assign(name, one.unit);
    }
  }

  const SystemText& text_;
  TextSystem out_;
  Graph& graph_;
  Names names_;
  Pieces pieces_;
  std::vector<std::vector<ToleratedConstraint>> constraints_;  // of each mode
  std::vector<std::vector<ScalarFunction>> conditions_;        // of each mode: see ModePiece
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
