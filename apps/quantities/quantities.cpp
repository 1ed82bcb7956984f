// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/console/arguments.hpp>
#include <graze/apps/quantities/quantities.hpp>
#include <graze/apps/text/column.hpp>
#include <graze/apps/text/number.hpp>

#include <graze/lib/models/physical_units.hpp>
#include <graze/lib/motion/extent.hpp>
#include <graze/lib/motion/trajectory.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

namespace graze::apps {

namespace {

/// Tolerance between a free run and the next state, relative to 1 + |x|; it bounds the error of the values. Near a grazing
/// impact an orbit is known only to 1e-6. An error below the tolerance is invisible in a picture.
constexpr double closing_tolerance = 1e-4;

struct Word {
  const char* text;
  QuantityKind kind;
};
constexpr std::array reductions = {Word{"max", QuantityKind::largest}, Word{"min", QuantityKind::smallest},
                                   Word{"amplitude", QuantityKind::amplitude}, Word{"mean", QuantityKind::mean}};
constexpr std::array words = {Word{"impact_speed_max", QuantityKind::impact_speed_max},
                              Word{"impact_speed_min", QuantityKind::impact_speed_min},
                              Word{"impacts", QuantityKind::impacts},
                              Word{"impacts_per_period", QuantityKind::impacts_per_period},
                              Word{"energy_lost", QuantityKind::energy_lost},
                              Word{"period", QuantityKind::period}};

std::string trimmed(const std::string& text) {
  const std::size_t from = text.find_first_not_of(" \t\n"), to = text.find_last_not_of(" \t\n");
  return from == std::string::npos ? std::string() : text.substr(from, to - from + 1);
}

/// The argument of `text` if the whole text is a call of `name` with one argument, and the byte where the argument begins;
/// nullopt: it is not such a call.
std::optional<std::pair<std::size_t, std::string>> argument_of(const std::string& text, const std::string& name) {
  std::size_t open = name.size();
  if (!text.starts_with(name)) return std::nullopt;
  while (open < text.size() && text[open] == ' ') ++open;
  if (open >= text.size() || text[open] != '(' || text.back() != ')') return std::nullopt;
  int depth = 0;
  for (std::size_t i = open; i < text.size(); ++i) {
    if (text[i] == '(') ++depth;
    if (text[i] == ')') --depth;
    if ((depth == 0 && i + 1 < text.size()) || (depth == 1 && text[i] == ',')) return std::nullopt;
  }
  return std::pair(open + 1, text.substr(open + 1, text.size() - open - 2));
}

/// The names that expressions may use, and their meanings.
class Reading {
 public:
  explicit Reading(const Problem& problem) : problem_(problem) {
    graph_ = *problem.written->graph;
    names_ = problem.written->names;
    tables_ = problem.written->tables;
    units_ = problem.written->units;
    if (is_built_in(problem)) name_units();
    scope_ = equations::scope_of(names_, tables_);
    scope_.refusal = [this](std::string_view name) -> std::string {
      return name == "t" && !is_forced(problem_.system) ? "the time t of an autonomous system cannot be used" : std::string();
    };
  }

  Quantities read(const std::vector<std::string>& texts) {
    Quantities out;
    for (const std::string& text : texts) {
      Quantity one = read(trimmed(text));
      if (std::any_of(out.list.begin(), out.list.end(), [&](const Quantity& other) { return other.text == one.text; }))
        throw std::invalid_argument(fmt::format("--y {0}: {0} is given twice", one.text));
      out.list.push_back(std::move(one));
    }
    try {
      out.functions = equations::MotionFunctions(graph_, expressions_, problem_.system.states);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(fmt::format("--y: {}", error.what()));
    }
    return out;
  }

 private:
  /// Units of a built-in system. For one in physical quantities also displacement X, velocity V and these quantities: those that
  /// are no parameters follow from the dimensionless parameters.
  void name_units() {
    for (const char* name : {"x", "v", "t"}) units_.emplace(name, "dimensionless");
    if (!problem_.converted_from) return;
    const ConvertedFrom& from = *problem_.converted_from;
    const ExcitationKind& kind = excitation_kind(from.excitation);
    const Values constants = to_dimensionless(kind, Values(from.quantities.begin(), from.quantities.end()));
    equations::Scope scope;
    scope.find = [&](std::string_view name) -> std::optional<equations::Expression> {
      if (const auto found = names_.find(name); found != names_.end()) return found->second;
      const auto constant = constants.find(name);
      return constant == constants.end() ? std::nullopt : std::optional(graph_.constant(constant->second));
    };
    const auto read = [&](const std::string& text) {
      return equations::parse_expression(graph_, {}, {text}, scope, "conversion");
    };
    const equations::Expression X = read("length*x"), V = read("length*alpha*v"), speed = read("length*alpha"),
                                seconds = read("1/alpha");
    const auto name_unit = [&](const ParameterInfo& info) {
      const bool given = std::any_of(from.quantities.begin(), from.quantities.end(),
                                     [&](const auto& quantity) { return quantity.first == info.name; });
      if (given) units_[info.name] = info.unit;
    };
    for (const ParameterInfo& info : kind.quantities) name_unit(info);
    for (const ContactQuantity& contact : contact_quantities()) name_unit(contact.info);
    for (const auto& [name, value] : kind.inverse) {
      const equations::Expression quantity = read(value.text);
      if (name.text == "energy") scales_.emplace(QuantityKind::energy_lost, Scale{quantity, "J"});
      if (units_.contains(name.text)) names_.emplace(name.text, quantity);
    }
    names_.insert({{"X", X}, {"V", V}});
    physical_ = {X, V};
    per_second_ = read("alpha");
    units_.insert({{"X", "m"}, {"V", "m/s"}});
    scales_.insert({{QuantityKind::impact_speed_max, {speed, "m/s"}},
                    {QuantityKind::impact_speed_min, {speed, "m/s"}},
                    {QuantityKind::period, {seconds, "s"}}});
  }

  Quantity read(const std::string& text) {
    Quantity one{.text = text};
    for (const Word& word : words)
      if (text == word.text && !names_.contains(text)) {
        one.kind = word.kind;
        if (word.kind == QuantityKind::period) one.unit = unit_of("t");
        if (const auto scale = scales_.find(one.kind); scale != scales_.end()) {
          one.unit = scale->second.unit;
          one.scale = index_of(scale->second.factor);
        }
        return one;
      }
    std::string argument = text;
    std::size_t begin = 0;
    for (const Word& word : reductions)
      if (const auto found = argument_of(text, word.text)) {
        one.kind = word.kind;
        begin = found->first;
        argument = found->second;
      }
    one.function = expression(text, argument, begin);
    one.moves = equations::dependence(graph_, expressions_[one.function]).moves();
    one.unit = unit_of(trimmed(argument));
    return one;
  }

  /// The index of an expression among the functions.
  std::size_t expression(const std::string& text, const std::string& argument, std::size_t begin) {
    const equations::Source source{"--y", text};
    const equations::Place place{1, equations::characters(text.substr(0, begin)) + 1, 1};
    equations::Expression read;
    try {
      read = equations::parse_expression(graph_, source, {argument, place}, scope_, "in the quantity");
    } catch (const equations::EquationError& error) {
      const std::string prefix = fmt::format("--y:{}:{}: ", error.place().line, error.place().column);
      const std::string& sentence = error.sentence();
      throw std::invalid_argument(fmt::format(
          "--y {}: {}; {}", text, sentence.starts_with(prefix) ? sentence.substr(prefix.size()) : sentence, allowed()));
    }
    return index_of(in_seconds(read));
  }

  /// The expression with X', V' and rates of expressions in X or V per second, not per dimensionless time.
  equations::Expression in_seconds(equations::Expression read) {
    equations::Replacement rates;
    for (const equations::Expression part : equations::reachable(graph_, read)) {
      if (graph_.node(part).operation != equations::Operation::rate) continue;
      for (const equations::Expression inner : equations::reachable(graph_, part))
        if (std::find(physical_.begin(), physical_.end(), inner) != physical_.end())
          rates[part.index] = graph_.multiply(per_second_, part);
    }
    return graph_.substitute(read, rates);
  }

  std::size_t index_of(equations::Expression read) {
    const auto known = std::find(expressions_.begin(), expressions_.end(), read);
    const auto index = static_cast<std::size_t>(known - expressions_.begin());
    if (known == expressions_.end()) expressions_.push_back(read);
    return index;
  }

  std::string unit_of(const std::string& name) const {
    if (is_built_in(problem_) && !problem_.converted_from) return "dimensionless";  // also for expressions of several names
    const auto found = units_.find(name);
    return found == units_.end() ? std::string() : found->second;
  }

  std::string allowed() const {
    std::string text = fmt::format(
        "a quantity is an expression E of {}{}, parameters{}{}, or max(E), min(E), amplitude(E) or mean(E)",
        fmt::join(state_columns(problem_), ", "), problem_.converted_from ? ", X, V, the quantities of [physical]" : "",
        is_forced(problem_.system) ? ", t" : "", is_built_in(problem_) ? "" : ", definitions and outputs");
    for (const Word& word : words) text += std::string(word.kind == QuantityKind::period ? " or " : ", ") + word.text;
    return text;
  }

  const Problem& problem_;
  equations::Graph graph_;
  std::map<std::string, equations::Expression, std::less<>> names_;
  std::map<std::string, std::size_t, std::less<>> tables_;
  std::map<std::string, std::string, std::less<>> units_;
  std::vector<equations::Expression> physical_;  ///< X and V
  equations::Expression per_second_;             ///< rate per second over rate per dimensionless time
  struct Scale {
    equations::Expression factor;
    std::string unit;
  };
  std::map<QuantityKind, Scale> scales_;  // of words in a problem with physical quantities
  equations::Scope scope_;
  std::vector<equations::Expression> expressions_;
};

/// Data of a motion collected up to the end of its last period.
struct Measured {
  std::vector<Extent> extents;              // over all periods
  std::vector<std::vector<double>> starts;  // of each function, at the beginning of each period
  std::vector<EventRecord> events;
  std::vector<double> impact_speeds = {};  // of impacts, also those that end at rest, and of entries into contact
};

std::optional<Measured> run_along(const Quantities& quantities, const HybridSystem& system, const Vector& p,
                                  const MeasuredMotion& motion) {
  const equations::MotionFunctions& functions = quantities.functions;
  std::vector<bool> has_extent(functions.size(), false);
  for (const Quantity& one : quantities.list)
    if (one.kind >= QuantityKind::largest && one.kind <= QuantityKind::mean) has_extent[one.function] = true;
  const bool needs_extents = std::find(has_extent.begin(), has_extent.end(), true) != has_extent.end();
  Measured out{std::vector<Extent>(functions.size()), std::vector<std::vector<double>>(functions.size()), {}};
  std::vector<double> values(functions.size()), rates(functions.size());
  Propagator propagator(system, p);
  const double unit = motion.duration / static_cast<double>(motion.states.size());
  for (std::size_t k = 0; k < motion.states.size(); ++k) {
    const Vector& start = motion.states[k];
    if (!mode_at(system, 0.0, start, p)) return std::nullopt;
    const Trajectory run = simulate(system, p, 0.0, start, {.t_end = unit});
    if (run.termination != Termination::time || run.segments.empty()) return std::nullopt;
    if (const bool last = k + 1 == motion.states.size(); !last || motion.closes) {
      const Vector& next = motion.states[last ? 0 : k + 1];
      if (!((run.x - next).lpNorm<Eigen::Infinity>() <= closing_tolerance * (1.0 + next.lpNorm<Eigen::Infinity>())))
        return std::nullopt;
    }
    functions.evaluate(system, run.segments.front().mode, 0.0, start, p, values.data(), rates.data());
    for (std::size_t f = 0; f < functions.size(); ++f) out.starts[f].push_back(values[f]);
    for (EventRecord event : run.events) {
      event.t += static_cast<double>(k) * unit;
      const bool comes_to_rest = event.kind == EventKind::stick;
      if (begins_contact(system.events[event.event].kind) && (!comes_to_rest || ends_contact(event)))
        out.impact_speeds.push_back(event.normal_speed);
      out.events.push_back(std::move(event));
    }
    if (!needs_extents) continue;
    const std::vector<Extent> found = extents(propagator, run, functions, has_extent);
    for (std::size_t f = 0; f < functions.size(); ++f) {
      Extent& all = out.extents[f];
      const bool known = std::isfinite(found[f].integral) && std::isfinite(all.integral);
      all = known ? Extent{std::max(all.largest, found[f].largest), std::min(all.smallest, found[f].smallest),
                           all.integral + found[f].integral}
                  : Extent{std::nan(""), std::nan(""), std::nan("")};
    }
  }
  return out;
}

std::vector<double> values_of(const Quantity& quantity, const Measured& measured, const MeasuredMotion& motion) {
  const double periods = static_cast<double>(motion.states.size());
  const auto extent = [&]() -> const Extent& { return measured.extents[quantity.function]; };
  double fastest = std::nan(""), slowest = std::nan("");
  for (const double speed : measured.impact_speeds) {
    fastest = std::fmax(fastest, speed);
    slowest = std::fmin(slowest, speed);
  }
  const auto impacts = static_cast<double>(measured.impact_speeds.size());
  switch (quantity.kind) {
  case QuantityKind::at_phase_0:
    return measured.starts[quantity.function];
  case QuantityKind::largest:
    return {extent().largest};
  case QuantityKind::smallest:
    return {extent().smallest};
  case QuantityKind::amplitude:
    return {0.5 * (extent().largest - extent().smallest)};
  case QuantityKind::mean:
    return {extent().integral / motion.duration};
  case QuantityKind::impact_speed_max:
    return {fastest};
  case QuantityKind::impact_speed_min:
    return {slowest};
  case QuantityKind::impacts:
    return {impacts};
  case QuantityKind::impacts_per_period:
    return {impacts / periods};
  case QuantityKind::energy_lost: {
    double sum = 0.0;
    const std::vector<Contact> contacts_of_motion =
        motion.closes ? contacts_of_cycle(measured.events, motion.duration).by_entry : contacts(measured.events);
    for (const Contact& contact : contacts_of_motion)
      if (contact.complete) sum += contact.energy_lost;
    return {sum / periods};
  }
  case QuantityKind::period:
    break;
  }
  return {motion.duration};
}

}  // namespace

void add_quantity_option(CLI::App& app, std::vector<std::string>& texts) {
  add_texts(app, "--y", texts, "QUANTITY",
            "show this too, and in pictures instead of the first state: an expression E of states, parameters and t (at forcing "
            "phase 0), max(E), min(E), amplitude(E), mean(E), impact_speed_max, impact_speed_min, impacts, impacts_per_period, "
            "energy_lost or period; repeatable");
}

Quantities read_quantities(const Problem& problem, const std::vector<std::string>& texts) { return Reading(problem).read(texts); }

void put_quantity_option(Json& options, const std::vector<std::string>& texts) {
  for (const std::string& text : texts) options["y"].push_back(trimmed(text));
}

std::string quantity_label(const Problem& problem, const std::string& text, bool at_phase_0) {
  const Quantity one = read_quantities(problem, {text}).list.front();
  const bool phase = at_phase_0 && one.moves && one.kind == QuantityKind::at_phase_0 && is_forced(problem.system);
  return text + (phase ? " at forcing phase 0" : "") +
         (one.unit.empty()              ? ""
          : one.unit == "dimensionless" ? " (dimensionless)"
                                        : " / " + one.unit);
}

Quantities read_expressions(const Problem& problem, const std::vector<std::string>& texts) {
  Quantities out = read_quantities(problem, texts);
  for (const Quantity& one : out.list)
    if (one.kind != QuantityKind::at_phase_0)
      throw std::invalid_argument(fmt::format("--y {}: this is a quantity of an orbit or an attractor; of the states of a motion "
                                              "only expressions can be shown, such as {}",
                                              one.text, state_columns(problem).front()));
  return out;
}

void append_values(const Quantities& expressions, const Problem& problem, bool timed, std::vector<Vector>& rows) {
  if (expressions.empty()) return;
  const auto count = static_cast<Eigen::Index>(expressions.list.size()),
             states = static_cast<Eigen::Index>(problem.system.states);
  std::vector<double> values(expressions.functions.size()), rates(values.size());
  for (Vector& row : rows) {
    const double t = timed ? row[0] : 0.0;
    const Vector x = row.tail(states);
    const auto mode = mode_at(problem.system, t, x, problem.parameters);
    if (mode) expressions.functions.evaluate(problem.system, *mode, t, x, problem.parameters, values.data(), rates.data());
    row.conservativeResize(row.size() + count);
    for (Eigen::Index k = 0; k < count; ++k)
      row[row.size() - count + k] = mode ? values[expressions.list[static_cast<std::size_t>(k)].function] : std::nan("");
  }
}

QuantityValues measure(const Quantities& quantities, const HybridSystem& system, const Vector& p, const MeasuredMotion& motion) {
  QuantityValues values;
  if (quantities.empty()) return values;
  const std::optional<Measured> measured = run_along(quantities, system, p, motion);
  for (const Quantity& one : quantities.list) {
    const std::size_t count = one.kind == QuantityKind::at_phase_0 ? motion.states.size() : 1;
    values.push_back({one.text, measured ? values_of(one, *measured, motion) : std::vector<double>(count, std::nan(""))});
    if (measured && one.scale)
      for (double& value : values.back().values) value *= measured->starts[*one.scale].front();
  }
  return values;
}

QuantityValues measure(const Quantities& quantities, const HybridSystem& system, const PeriodicOrbit& orbit) {
  return measure(quantities, system, orbit.parameters, {.states = orbit.states, .duration = orbit.duration});
}

QuantityValues measure(const Quantities& quantities, const HybridSystem& system, const Vector& p, const Attractor& attractor) {
  constexpr int periods_of_a_motion = 64;
  const bool closes = attractor.type == AttractorType::periodic, forced = is_forced(system);
  QuantityValues unknown;
  for (const Quantity& one : quantities.list) unknown.push_back({one.text, {std::nan("")}});
  if (quantities.empty() || (!forced && !closes)) return unknown;
  MeasuredMotion motion{.states = {attractor.state}, .duration = attractor.duration, .closes = closes};
  if (forced) {
    const double unit = forcing_period(system, p);
    const int periods = closes ? attractor.period : periods_of_a_motion;
    motion.duration = periods * unit;
    while (static_cast<int>(motion.states.size()) < periods) {
      const Trajectory run = simulate(system, p, 0.0, motion.states.back(), {.t_end = unit});
      if (run.termination != Termination::time) return unknown;
      motion.states.push_back(run.x);
    }
  }
  return measure(quantities, system, p, motion);
}

void put_quantities(Json& json, const QuantityValues& values) {
  json.erase("y");
  if (!values.empty()) json["y"] = tree_of([&](JsonText& text) { write_quantities(values, text); });
}

Json with_quantities(Json schema) {
  const Json number = JsonForm<std::optional<double>>::schema();
  Json values = {{"type", "object"}, {"additionalProperties", {{"anyOf", {number, list_schema(number)}}}}};
  return merged_schemas({std::move(schema), object_schema({{"y", "quantities that --y asks for", values, false}})});
}

void write_quantities(const QuantityValues& values, JsonText& json) {
  json.begin_object();
  for (const QuantityValue& one : values) {
    if (one.values.size() == 1)
      json.member(one.name, one.values.front());
    else
      json.member(one.name, one.values);
  }
  json.end_object();
}

std::vector<double> values_at(const QuantityValues& values, std::size_t period) {
  std::vector<double> list;
  for (const QuantityValue& one : values) list.push_back(one.values.size() == 1 ? one.values.front() : one.values.at(period));
  return list;
}

void add_quantity_column(Table& table, const std::string& name) {
  const bool taken = std::find(table.columns.begin(), table.columns.end(), name) != table.columns.end();
  table.columns.push_back(taken ? name + " (--y)" : name);
}

void add_columns(Table& table, const QuantityValues& values) {
  for (const QuantityValue& one : values) add_quantity_column(table, one.name);
}

void add_cells(std::vector<std::string>& row, const QuantityValues& values, bool for_people) {
  for (const double value : values_at(values))
    row.push_back(!std::isfinite(value) ? (for_people ? "-" : "") : for_people ? rounded(value, 10) : exact(value));
}

}  // namespace graze::apps
