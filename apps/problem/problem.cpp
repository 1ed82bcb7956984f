// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/problem/problem.hpp>
#include <graze/apps/problem/system_file.hpp>
#include <graze/apps/problem/toml_section.hpp>
#include <graze/apps/text/number.hpp>
#include <graze/lib/equations/not_finite.hpp>
#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/models/physical_units.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace graze::apps {

namespace {

const equations::TiedParameter* find_tied(const Problem& problem, std::string_view name) {
  for (const equations::TiedParameter& tied : problem.written->tied)
    if (tied.info.name == name) return &tied;
  return nullptr;
}

Eigen::Index index_of(const Problem& problem, std::string_view name) {
  try {
    return static_cast<Eigen::Index>(parameter_index(problem.system.parameters, name));
  } catch (const std::invalid_argument& error) {
    if (find_tied(problem, name))
      throw std::invalid_argument(
          problem.converted_from
              ? fmt::format("{} follows from the physical quantity that is varied; set that", name)
              : fmt::format("{} is an expression of other parameters in {}; set those, or give it a value there", name,
                            problem.file));
    std::string text = error.what();
    if (problem.converted_from) {  // the physical quantities of the file are names, too
      std::vector<std::string> names;
      for (const ParameterInfo& info : problem.system.parameters) names.push_back(info.name);
      for (const auto& quantity : problem.converted_from->quantities) names.push_back(quantity.first);
      text = unknown_name("parameter", name, names);
    }
    throw std::invalid_argument(text + (is_built_in(problem) ? owner_of(name, problem.contact) : ""));
  }
}

/// Whether a section [physical] may contain this quantity.
bool is_physical(std::string_view name) {
  const auto named = [name](const ParameterInfo& info) { return info.name == name; };
  return std::any_of(
             excitation_kinds().begin(), excitation_kinds().end(),
             [&](const ExcitationKind& kind) { return std::any_of(kind.quantities.begin(), kind.quantities.end(), named); }) ||
         std::any_of(contact_quantities().begin(), contact_quantities().end(),
                     [&](const ContactQuantity& quantity) { return named(quantity.info); });
}

/// Stores a built-in system, with the lower bound of eta raised to `slowest_forcing`: slower motions could be computed, but
/// would take too long.
void take_system(Problem& problem, equations::TextSystem written) {
  const auto bound = [](ParameterInfo& info) {
    if (info.name != "eta") return;
    info.lower = slowest_forcing;
    info.lower_open = false;
  };
  for (ParameterInfo& info : written.system.parameters) bound(info);
  for (equations::TiedParameter& tied : written.tied) bound(tied.info);
  problem.system = written.system;
  problem.parameters = default_parameters(problem.system.parameters);
  problem.written = std::make_shared<const equations::TextSystem>(std::move(written));
}

}  // namespace

Problem make_problem(const std::string& oscillator, const std::string& contact) {
  Problem problem;
  problem.oscillator = oscillator;
  problem.contact = contact;
  take_system(problem, read_oscillator(oscillator_kind(oscillator), contact_law(contact)));
  return problem;
}

namespace {

/// A parameter's value at other parameter values than the problem's own.
double parameter_at(const Problem& problem, const Vector& parameters, std::string_view name) {
  const equations::TiedParameter* const tied = find_tied(problem, name);
  return tied ? tied->value(parameters) : parameters[index_of(problem, name)];
}

}  // namespace

double parameter(const Problem& problem, std::string_view name) { return parameter_at(problem, problem.parameters, name); }

Vector built_in_parameters(const Problem& problem) {
  std::vector<ParameterInfo> infos = oscillator_parameters();
  const ContactLaw& law = contact_law(problem.contact);
  infos.insert(infos.end(), law.parameters.begin(), law.parameters.end());
  Vector out(static_cast<Eigen::Index>(infos.size()));
  for (std::size_t i = 0; i < infos.size(); ++i) out[static_cast<Eigen::Index>(i)] = parameter(problem, infos[i].name);
  return out;
}

namespace {

/// The parameters with one of them changed.
Vector changed(const Problem& problem, std::string_view name, double value) {
  Vector out = problem.parameters;
  out[index_of(problem, name)] = value;
  check_parameters(problem.system.parameters, out);
  return out;
}

void check_tied(const Problem& problem, const Vector& parameters) {
  for (const equations::TiedParameter& tied : problem.written->tied)
    check_parameters({tied.info}, Vector{{tied.value(parameters)}});
}

}  // namespace

void set_parameter(Problem& problem, std::string_view name, double value) {
  const Vector parameters = changed(problem, name, value);
  check_tied(problem, parameters);
  problem.parameters = parameters;
}

void set_parameters(Problem& problem, const std::vector<std::pair<std::string, double>>& values) {
  for (const auto& [name, value] : values) problem.parameters = changed(problem, name, value);
  check_tied(problem, problem.parameters);
}

std::string parameter_name(const Problem& problem, const std::string& given) {
  if (!given.empty()) return given;
  if (const auto frequency = problem.system.forcing_frequency) return problem.system.parameters[*frequency].name;
  std::vector<std::string> names;
  for (const ParameterInfo& info : problem.system.parameters) names.push_back(info.name);
  const char* const why = is_forced(problem.system) ? "its forcing frequency is no parameter of its own" : "it has no forcing";
  throw std::invalid_argument(fmt::format("{}: {}; give --param NAME, one of {}", problem.file, why, fmt::join(names, ", ")));
}

void check_parameter_name(const Problem& problem, std::string_view name) {
  try {
    index_of(problem, name);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("--param {}: {}", name, error.what()));
  }
}

void set_parameter(Problem& problem, std::string_view name, double value, const std::string& option) {
  check_parameter_name(problem, name);  // an unknown name is not an error of this option
  try {
    set_parameter(problem, name, value);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("{} {}: {}", option, value, error.what()));
  }
}

std::string owner_of(std::string_view parameter, const std::string& contact) {
  for (const ContactLaw& law : contact_laws())
    for (const ParameterInfo& info : law.parameters)
      if (info.name == parameter && law.name != contact)
        return fmt::format(" ({} belongs to the {} contact law, and this model has {} contact)", parameter, law.name, contact);
  if (is_physical(parameter))
    return fmt::format(" ({} is a physical quantity, which a problem file gives in its section [physical] and which is converted "
                       "to parameters)",
                       parameter);
  return {};
}

namespace {

/// A physical quantity that the file gives; null: the file gives none of this name, or it is also a parameter of the system.
std::pair<std::string, double>* given_quantity(Problem& problem, const std::string& name) {
  if (!problem.converted_from) return nullptr;
  for (const ParameterInfo& info : problem.system.parameters)
    if (info.name == name) return nullptr;
  for (auto& quantity : problem.converted_from->quantities)
    if (quantity.first == name) return &quantity;
  return nullptr;
}

/// Whether a dimensionless parameter follows from the quantity, or the quantity from the parameter.
bool depend_on_each_other(const ConvertedFrom& from, const std::string& parameter, const std::string& quantity) {
  const auto other = [](double value) { return 1.5 * value + 0.1; };
  const ExcitationKind& kind = excitation_kind(from.excitation);
  Values quantities(from.quantities.begin(), from.quantities.end());
  Values parameters = to_dimensionless(kind, quantities);
  if (!parameters.contains(parameter)) return false;
  const double value = parameters.at(parameter), inverse = from_dimensionless(kind, parameters).at(quantity);
  quantities[quantity] = other(quantities[quantity]);
  if (to_dimensionless(kind, quantities).at(parameter) != value) return true;
  parameters[parameter] = other(value);
  return from_dimensionless(kind, parameters).at(quantity) != inverse;
}

/// Converts again. Parameters that do not depend on the quantity keep the value of an earlier setting.
void set_quantity(Problem& problem, std::pair<std::string, double>& quantity, double value) {
  ConvertedFrom& from = *problem.converted_from;
  const ExcitationKind& kind = excitation_kind(from.excitation);
  check_parameters({quantity_info(kind, quantity.first)}, Vector{{value}});
  const auto converted = [&] { return to_dimensionless(kind, Values(from.quantities.begin(), from.quantities.end())); };
  const Values before = converted();
  quantity.second = value;
  const Values after = converted();
  from.alpha = after.at("alpha");
  from.length = after.at("length");
  for (const std::string& name : from.obtained)
    if (const double now = after.at(name); now != before.at(name)) problem.parameters = changed(problem, name, now);
}

}  // namespace

void vary_quantities(Problem& problem, const std::vector<std::string>& chosen) {
  if (chosen.empty()) return;
  ConvertedFrom& from = *problem.converted_from;
  const std::vector<ParameterInfo> before = problem.system.parameters;
  const Vector values = problem.parameters;
  take_system(problem,
              read_oscillator(oscillator_kind(problem.oscillator), contact_law(problem.contact), excitation_kind(from.excitation),
                              Values(from.quantities.begin(), from.quantities.end()), chosen));
  from.chosen = chosen;
  for (std::size_t i = 0; i < before.size(); ++i)
    if (!find_tied(problem, before[i].name))
      problem.parameters[index_of(problem, before[i].name)] = values[static_cast<Eigen::Index>(i)];
}

void choose_quantities(Problem& problem, const std::vector<std::string>& names) {
  std::vector<std::string> chosen;
  for (const std::string& name : names)
    if (given_quantity(problem, name) && std::find(chosen.begin(), chosen.end(), name) == chosen.end()) chosen.push_back(name);
  if (chosen.empty()) return;
  const Problem before = problem;
  vary_quantities(problem, chosen);
  constexpr double roundings = 1e-14;
  const ConvertedFrom& from = *problem.converted_from;
  const Values converted =
      to_dimensionless(excitation_kind(from.excitation), Values(from.quantities.begin(), from.quantities.end()));
  for (std::size_t i = 0; i < before.system.parameters.size(); ++i) {
    const std::string& name = before.system.parameters[i].name;
    const bool depends = std::any_of(chosen.begin(), chosen.end(),
                                     [&](const std::string& quantity) { return depend_on_each_other(from, name, quantity); });
    if (!depends) continue;
    const double set = before.parameters[static_cast<Eigen::Index>(i)], given = converted.at(name);
    if (std::abs(given - set) > roundings * std::abs(set))
      throw std::invalid_argument(
          fmt::format("--param {0}: {1} is {2} by --set and {3} by [physical], and it changes with {0}; set "
                      "the quantities of [physical] instead",
                      fmt::join(chosen, ", "), name, exact(set), exact(given)));
  }
}

void apply_settings(Problem& problem, const std::vector<std::string>& settings) {
  std::vector<std::string> physical, dimensionless;  // set so far
  const auto check_apart = [&](const std::string& parameter, const std::string& quantity) {
    if (problem.converted_from && depend_on_each_other(*problem.converted_from, parameter, quantity))
      throw std::invalid_argument(fmt::format(
          "{} and {} depend on each other, and both are set; set the quantities of [physical] only", parameter, quantity));
  };
  for (const std::string& setting : settings) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos || equals == 0)
      throw std::invalid_argument(fmt::format("--set {}: expected name=value, for example --set eta=0.9", setting));
    const std::optional<double> value = parse_number(std::string_view(setting).substr(equals + 1));
    try {
      const std::string name = setting.substr(0, equals);
      if (auto* const quantity = given_quantity(problem, name)) {
        if (!value) throw std::invalid_argument(no_number(setting.substr(equals + 1)));
        for (const std::string& other : dimensionless) check_apart(other, name);
        set_quantity(problem, *quantity, *value);
        physical.push_back(name);
        continue;
      }
      index_of(problem, name);  // if name and value are both wrong, report the name
      if (!value) throw std::invalid_argument(no_number(setting.substr(equals + 1)));
      for (const std::string& other : physical) check_apart(name, other);
      problem.parameters = changed(problem, name, *value);
      dimensionless.push_back(name);
      std::erase(problem.defaulted, name);
      if (&setting == &settings.back()) check_tied(problem, problem.parameters);  // once all are set
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(fmt::format("--set {}: {}", setting, error.what()));
    }
  }
}

namespace {

/// @throws EquationError for a guard, or an equation of the mode at this state, that is not finite there.
void check_finite(const Problem& problem, const Vector& state) {
  if (!problem.written || state.size() != static_cast<Eigen::Index>(problem.system.states) || !state.allFinite()) return;
  const auto mode = mode_at(problem.system, 0.0, state, problem.parameters);
  const auto found = mode ? equations::find_not_finite(*problem.written, *mode, 0.0, state, problem.parameters)
                          : equations::find_not_finite_guard(*problem.written, 0.0, state, problem.parameters);
  if (found) throw equations::not_finite_error(*problem.written, *found, 0.0, state);
}

/// One sentence on a start inside a barrier: a given one, that of the file, or rest.
std::string inside_barrier(const Problem& problem, const Vector& state, bool given) {
  const std::string values = fmt::format("({})", fmt::join(exact_cells(state), ", "));
  const std::string side = is_built_in(problem) ? fmt::format(", x <= r = {}", exact(parameter(problem, "r"))) : "";
  if (given)
    return fmt::format("--start {}: the state {} lies inside the barrier; give one on its free side{}",
                       fmt::join(exact_cells(state), ","), values, side);
  const std::string which = problem.start ? "the [start] state" : "[start] is not given, and rest, the state";
  return fmt::format("{}: {} {}{} lies inside the barrier; give a state on its free side{} by --start or in [start]",
                     problem.file, which, values, problem.start ? "" : ",", side);
}

}  // namespace

Vector start_state(const Problem& problem, const std::optional<Vector>& given) {
  Vector wanted = given ? *given : problem.start ? *problem.start : rest_state(problem, problem.parameters);
  if (!given && !problem.start && is_built_in(problem)) return wanted;
  try {
    check_finite(problem, wanted);
    initial_mode(problem.system, 0.0, wanted, problem.parameters);
  } catch (const equations::EquationError&) {
    throw;
  } catch (const std::invalid_argument& error) {
    const bool right_size = wanted.size() == static_cast<Eigen::Index>(problem.system.states);
    if (right_size && wanted.allFinite()) throw std::invalid_argument(inside_barrier(problem, wanted, given.has_value()));
    const std::string source =
        given ? fmt::format("--start {}", fmt::join(exact_cells(wanted), ",")) : problem.file + ": [start] state";
    const std::string advice =
        wanted.allFinite() ? "" : fmt::format("; give {} that are", wanted.size() == 2 ? "two" : "numbers");
    throw std::invalid_argument(fmt::format("{}: {}{}", source, error.what(), advice));
  }
  return wanted;
}

Vector rest_state(const Problem& problem, const Vector& parameters) {
  Vector rest = Vector::Zero(static_cast<Eigen::Index>(problem.system.states));
  if (is_built_in(problem)) rest[0] = std::min(0.0, parameter_at(problem, parameters, "r"));
  return rest;
}

std::array<std::size_t, 2> plane_of(const Problem& problem, const std::string& given) {
  const std::vector<std::string> names = state_columns(problem);
  if (std::count(given.begin(), given.end(), ',') != 1)
    throw std::invalid_argument(fmt::format("--plane {}: must be two states with a comma between them, for example {},{}", given,
                                            names[0], names[1 % names.size()]));
  const std::size_t comma = given.find(',');
  const std::string chosen[] = {given.substr(0, comma), given.substr(comma + 1)};
  std::array<std::size_t, 2> plane{};
  for (const std::size_t i : {0, 1}) {
    const auto found = std::find(names.begin(), names.end(), chosen[i]);
    if (found == names.end())
      throw std::invalid_argument(fmt::format("--plane {}: {}; give two, for example {},{}", given,
                                              unknown_name("state", chosen[i], names), names[0], names[1 % names.size()]));
    plane[i] = static_cast<std::size_t>(found - names.begin());
  }
  if (plane[0] == plane[1]) throw std::invalid_argument(fmt::format("--plane {}: the two states must differ", given));
  return plane;
}

Vector state_of(const Problem& problem, const StateText& given, const std::string& option) {
  const std::vector<std::string> names = state_columns(problem);
  if (given.names.empty()) {
    if (static_cast<std::size_t>(given.values.size()) == names.size()) return given.values;
    throw std::invalid_argument(fmt::format(
        "{} {}: must be {} numbers {}, or some of them by name, {}=0.5", option, fmt::join(exact_cells(given.values), ","),
        names.size() == 2 ? "two" : fmt::format("{}", names.size()), fmt::join(names, ","), names.front()));
  }
  Vector state = problem.start ? *problem.start : Vector::Zero(static_cast<Eigen::Index>(names.size()));
  for (std::size_t i = 0; i < given.names.size(); ++i) {
    const auto found = std::find(names.begin(), names.end(), given.names[i]);
    if (found == names.end())
      throw std::invalid_argument(fmt::format("{}: {}", option, unknown_name("state", given.names[i], names)));
    if (std::find(given.names.begin(), given.names.begin() + static_cast<std::ptrdiff_t>(i), given.names[i]) !=
        given.names.begin() + static_cast<std::ptrdiff_t>(i))
      throw std::invalid_argument(fmt::format("{}: {} is given twice; give each state once", option, given.names[i]));
    state[found - names.begin()] = given.values[static_cast<Eigen::Index>(i)];
  }
  return state;
}

std::string_view periods_name(const Problem& problem) { return is_forced(problem.system) ? "forcing periods" : "returns"; }

std::string counted_periods(const Problem& problem, std::int64_t count) {
  return counted(static_cast<std::size_t>(count), is_forced(problem.system) ? "forcing period" : "return");
}

std::vector<std::string> state_columns(const Problem& problem) { return state_names(problem.system); }

std::vector<std::string> state_headings(const Problem& problem) {
  return is_built_in(problem) ? std::vector<std::string>{"x", "x'"} : state_names(problem.system);
}

std::string state_text(const Problem& problem, const Vector& state, int digits) {
  const std::vector<std::string> names = state_headings(problem);
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += fmt::format("{}{} = {}", i == 0 ? "" : "   ", names[i], rounded(state[static_cast<Eigen::Index>(i)], digits));
  return text;
}

namespace {

/// Whether a tied parameter depends on the parameter `name`.
bool follows(const equations::TiedParameter& tied, const Problem& problem, std::string_view name) {
  Vector dp = Vector::Zero(problem.parameters.size());
  tied.dp(problem.parameters, dp);
  for (std::size_t i = 0; i < problem.system.parameters.size(); ++i)
    if (problem.system.parameters[i].name == name) return dp[static_cast<Eigen::Index>(i)] != 0.0;
  return false;
}

}  // namespace

std::string title(const Problem& problem) {
  return is_built_in(problem) ? fmt::format("{} oscillator, {} contact", problem.oscillator, problem.contact)
                              : problem.system.name;
}

std::string describe(const Problem& problem, std::string_view except) {
  std::string text = title(problem);
  char separator = ':';
  for (std::size_t i = 0; i < problem.system.parameters.size(); ++i) {
    const std::string& name = problem.system.parameters[i].name;
    if (name == except) continue;
    text += fmt::format("{} {} = {}", separator, name, rounded(problem.parameters[static_cast<Eigen::Index>(i)], 8));
    separator = ',';
  }
  for (const equations::TiedParameter& tied : problem.written->tied)
    if (!follows(tied, problem, except))
      text += fmt::format("; {} = {}", tied.info.name, rounded(tied.value(problem.parameters), 8));
  return text;
}

namespace {

constexpr std::uintmax_t largest_file = 1000000;  // bytes

/// The value, if it is in range; otherwise an error in one sentence. `info` holds name, range and unit.
double checked(const std::string& where, const ParameterInfo& info, double value) {
  try {
    check_parameters({info}, Vector{{value}});
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("{}: {}", where, error.what()));
  }
  return value;
}

void read_parameters(TomlSection& section, Problem& problem) {
  for (std::size_t i = 0; i < problem.system.parameters.size(); ++i) {
    const ParameterInfo& info = problem.system.parameters[i];
    const std::optional<double> value = section.number(info.name);
    if (value)
      problem.parameters[static_cast<Eigen::Index>(i)] = checked(section.where(info.name), info, *value);
    else
      problem.defaulted.push_back(info.name);
  }
  section.finish(problem.contact);
}

/// Reads the physical quantities of the file, by name and in the order in which they are listed to users, and converts them.
void read_physical(TomlSection& section, Problem& problem) {
  const std::optional<std::string> name = section.text("excitation");
  std::vector<std::string> names;
  for (const ExcitationKind& kind : excitation_kinds()) names.push_back(kind.name);
  if (!name)
    throw std::invalid_argument(
        fmt::format("{}: [physical] lacks excitation = \"...\": {}", section.where(), fmt::join(names, ", ")));
  if (std::find(names.begin(), names.end(), *name) == names.end())
    throw std::invalid_argument(fmt::format("{}: {}", section.where("excitation"), unknown_name("excitation", *name, names)));
  const ExcitationKind& kind = excitation_kind(*name);

  ConvertedFrom from;
  from.excitation = kind.name;
  Values values;
  const bool cubic = problem.oscillator == "cantilever";
  const auto read = [&](const ParameterInfo& info, bool required) {
    const std::optional<double> value = section.number(info.name);
    if (!value && required)
      throw std::invalid_argument(fmt::format("{}: [physical] with {} excitation lacks {} ({}, {})", section.where(), kind.name,
                                              info.name, info.meaning, info.unit));
    if (!value) return;
    values[info.name] = checked(section.where(info.name), info, *value);
    from.quantities.emplace_back(info.name, *value);
  };
  for (const ParameterInfo& info : kind.quantities)
    if (info.name != "k_3" || cubic) read(info, true);

  const std::vector<ContactQuantity>& contact = contact_quantities();
  std::vector<std::string> dimensionless;  // parameters of the law without a physical counterpart, such as k_r
  for (std::size_t i = oscillator_parameters().size(); i < problem.system.parameters.size(); ++i) {
    const ParameterInfo& info = problem.system.parameters[i];
    const auto quantity =
        std::find_if(contact.begin(), contact.end(), [&](const ContactQuantity& q) { return q.parameter == info.name; });
    if (quantity != contact.end()) {
      read(quantity->info, quantity->info.lower_open);  // a damping may be left out: 0
    } else {
      read(info, true);
      dimensionless.push_back(info.name);
    }
  }
  section.finish();

  const Values converted = to_dimensionless(kind, values);
  from.alpha = converted.at("alpha");
  from.length = converted.at("length");
  for (std::size_t i = 0; i < problem.system.parameters.size(); ++i) {
    const ParameterInfo& info = problem.system.parameters[i];
    double& target = problem.parameters[static_cast<Eigen::Index>(i)];
    if (std::find(dimensionless.begin(), dimensionless.end(), info.name) != dimensionless.end()) {
      target = values.at(info.name);
    } else if (info.name != "beta" || cubic) {  // the linear oscillator keeps beta = 0, also as a beam
      target = checked(section.where(), info, converted.at(info.name));
      from.obtained.push_back(info.name);
    }
  }
  problem.converted_from = std::move(from);
}

/// The name in [model], checked against the known names.
std::string model_name(TomlSection& section, const std::string& key, const std::vector<std::string>& names) {
  const std::optional<std::string> name = section.text(key);
  if (!name)
    throw std::invalid_argument(fmt::format("{}: [model] lacks {} = \"...\": {}", section.where(), key, fmt::join(names, ", ")));
  if (std::find(names.begin(), names.end(), *name) == names.end())
    throw std::invalid_argument(fmt::format("{}: {}", section.where(key), unknown_name(key, *name, names)));
  return *name;
}

}  // namespace

namespace {

/// Reads a file with a system of its own.
Problem parse_system(const toml::table& root, std::string_view text, const std::string& file) {
  Problem problem;
  problem.file = file;
  problem.text = text;
  auto written = std::make_shared<equations::TextSystem>(equations::make_system(read_system(root, {file, std::string(text)})));
  problem.system = written->system;
  problem.start = written->start;
  problem.written = std::move(written);
  problem.parameters = default_parameters(problem.system.parameters);
  TomlSection start(file, root, "start");
  problem.settle = start.count("settle", 0);
  problem.period = start.count("period", 1, longest_period);
  return problem;
}

}  // namespace

Problem parse_problem(std::string_view text, const std::string& file) {
  const toml::table root = parse_toml(text, file);
  if (has_system(root)) return parse_system(root, text, file);
  check_sections(root, {file, std::string(text)}, {"model", "parameters", "physical", "start"});
  TomlSection model(file, root, "model"), parameters(file, root, "parameters"), physical(file, root, "physical"),
      start(file, root, "start");
  if (!model.present())
    throw std::invalid_argument(fmt::format("{}: the section [model] is missing: it names oscillator and contact of a built-in "
                                            "system; a system of its own has a section [system] instead, with [modes.NAME] or "
                                            "[mechanics]",
                                            file));
  std::vector<std::string> oscillators, contacts;
  for (const OscillatorKind& kind : oscillator_kinds()) oscillators.push_back(kind.name);
  for (const ContactLaw& law : contact_laws()) contacts.push_back(law.name);
  for (const char* key : {"oscillator", "contact"}) model.text(key);
  model.finish();  // report a misspelt key rather than another missing one
  const std::string oscillator = model_name(model, "oscillator", oscillators);
  const std::string contact = model_name(model, "contact", contacts);

  Problem problem = make_problem(oscillator, contact);
  problem.file = file;
  if (parameters.present() == physical.present())
    throw std::invalid_argument(fmt::format("{}: {} [parameters] (dimensionless) and [physical]; it must have one of them", file,
                                            parameters.present() ? "has both" : "has neither of"));
  if (parameters.present())
    read_parameters(parameters, problem);
  else
    read_physical(physical, problem);

  problem.start = start.state("state");
  problem.settle = start.count("settle", 0);
  problem.period = start.count("period", 1, longest_period);
  start.finish();
  return problem;
}

Problem load_problem(const std::string& file) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path path(file);
  if (fs::is_directory(path, error)) throw std::invalid_argument(file + ": is a folder, not a problem file");
  if (!fs::exists(path, error)) {
    std::vector<std::string> others;
    const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
      if (entry.path().extension() == ".toml") others.push_back(entry.path().filename().string());
    std::sort(others.begin(), others.end());
    const std::string nearest = nearest_name(path.filename().string(), others);
    throw std::invalid_argument(fmt::format(
        "{}: no such problem file{}", file,
        nearest.empty()
            ? ""
            : fmt::format(" (did you mean \"{}\"?)", path.has_parent_path() ? (folder / nearest).string() : nearest)));
  }
  if (!fs::is_regular_file(path, error))
    throw std::invalid_argument(file + ": is not a regular file; a problem is read from one, not from a pipe or a device");
  if (fs::file_size(path, error) > largest_file || error)
    throw std::invalid_argument(fmt::format("{}: is larger than {} bytes; a problem file is a page of text", file, largest_file));
  std::ifstream stream(file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (!stream.is_open() || stream.bad()) throw std::invalid_argument(file + ": cannot be read");
  return parse_problem(text, file);
}

}  // namespace graze::apps
