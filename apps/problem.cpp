// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/number.hpp>
#include <graze/apps/problem.hpp>

#include <graze/lib/oscillator.hpp>
#include <graze/lib/physical_units.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace graze::apps {

namespace {

Eigen::Index index_of(const Problem& problem, std::string_view name) {
  try {
    return static_cast<Eigen::Index>(parameter_index(problem.system.parameters, name));
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(error.what() + owner_of(name, problem.contact));
  }
}

/// Whether a section [physical] may give it.
bool is_physical(std::string_view name) {
  const auto named = [name](const ParameterInfo& info) { return info.name == name; };
  return std::any_of(
             excitation_kinds().begin(), excitation_kinds().end(),
             [&](const ExcitationKind& kind) { return std::any_of(kind.quantities.begin(), kind.quantities.end(), named); }) ||
         std::any_of(contact_quantities().begin(), contact_quantities().end(),
                     [&](const ContactQuantity& quantity) { return named(quantity.info); });
}

}  // namespace

Problem make_problem(const std::string& oscillator, const std::string& contact) {
  Problem problem;
  problem.oscillator = oscillator;
  problem.contact = contact;
  problem.system = make_oscillator(oscillator, contact);
  ParameterInfo& eta = problem.system.parameters[parameter_index(problem.system.parameters, "eta")];
  eta.lower = slowest_forcing;  // motions could be computed for slower forcing, if anybody waited for them
  eta.lower_open = false;
  problem.parameters = default_parameters(problem.system.parameters);
  return problem;
}

double parameter(const Problem& problem, std::string_view name) { return problem.parameters[index_of(problem, name)]; }

void set_parameter(Problem& problem, std::string_view name, double value) {
  Vector changed = problem.parameters;
  changed[index_of(problem, name)] = value;
  check_parameters(problem.system.parameters, changed);
  problem.parameters = changed;
}

void check_parameter_name(const Problem& problem, std::string_view name) {
  try {
    index_of(problem, name);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("--param {}: {}", name, error.what()));
  }
}

void set_parameter(Problem& problem, std::string_view name, double value, const std::string& option) {
  check_parameter_name(problem, name);  // an unknown name is not the fault of this option
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
    return fmt::format(" ({} is a physical quantity, which a problem file gives in its section [physical]; parameters are what "
                       "it is turned into)",
                       parameter);
  return {};
}

void apply_settings(Problem& problem, const std::vector<std::string>& settings) {
  for (const std::string& setting : settings) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos || equals == 0)
      throw std::invalid_argument(fmt::format("--set {}: expected name=value, for example --set eta=0.9", setting));
    const std::optional<double> value = parse_number(std::string_view(setting).substr(equals + 1));
    try {
      const std::string name = setting.substr(0, equals);
      index_of(problem, name);  // a wrong name is the better thing to say where both are wrong
      if (!value) throw std::invalid_argument(no_number(setting.substr(equals + 1)));
      set_parameter(problem, name, *value);
      std::erase(problem.defaulted, name);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(fmt::format("--set {}: {}", setting, error.what()));
    }
  }
}

Vector start_state(const Problem& problem, const std::optional<Vector>& given) {
  const std::optional<Vector>& wanted = given ? given : problem.start;
  const double barrier = parameter(problem, "r");
  if (!wanted) return Vector{{std::min(0.0, barrier), 0.0}};
  try {
    initial_mode(problem.system, 0.0, *wanted, problem.parameters);
  } catch (const std::invalid_argument& error) {
    const std::string source =
        given ? fmt::format("--start {},{}", exact((*given)[0]), exact((*given)[1])) : problem.file + ": [start] state";
    const bool inside = wanted->allFinite();
    throw std::invalid_argument(fmt::format("{}: {}{}", source, error.what(),
                                            inside ? fmt::format(", x <= r = {}", exact(barrier)) : "; give two that are"));
  }
  return *wanted;
}

std::string describe(const Problem& problem, std::string_view except) {
  std::string text = fmt::format("{} oscillator, {} contact", problem.oscillator, problem.contact);
  char separator = ':';
  for (std::size_t i = 0; i < problem.system.parameters.size(); ++i) {
    const std::string& name = problem.system.parameters[i].name;
    if (name == except) continue;
    text += fmt::format("{} {} = {}", separator, name, rounded(problem.parameters[static_cast<Eigen::Index>(i)], 8));
    separator = ',';
  }
  return text;
}

}  // namespace graze::apps
