// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/models/physical_units.hpp>

#include <graze/lib/equations/functions.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <stdexcept>

namespace graze {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

ParameterInfo positive(std::string name, std::string unit, std::string meaning) {
  return {std::move(name), 0.0, 0.0, infinity, true, std::move(unit), std::move(meaning)};
}

ParameterInfo not_negative(std::string name, std::string unit, std::string meaning) {
  return {std::move(name), 0.0, 0.0, infinity, false, std::move(unit), std::move(meaning)};
}

ParameterInfo any(std::string name, std::string unit, std::string meaning) {
  return {std::move(name), 0.0, -infinity, infinity, false, std::move(unit), std::move(meaning)};
}

/// The quantities in which the kinds of excitation differ. All others follow the same rule.
struct Scales {
  std::string mass, stiffness, length, beta, xi;
};

using Texts = std::vector<std::pair<std::string, std::string>>;

std::vector<equations::Definition> definitions(const Texts& texts) {
  std::vector<equations::Definition> list;
  for (const auto& [name, value] : texts) list.push_back({{name, {}}, {value, {}}});
  return list;
}

std::vector<equations::Definition> conversion(const Scales& kind) {
  return definitions({{"stiffness", kind.stiffness},
                      {"alpha", fmt::format("sqrt(stiffness/{})", kind.mass)},
                      {"length", kind.length},
                      {"b", fmt::format("c/(2*sqrt(stiffness*{}))", kind.mass)},
                      {"beta", kind.beta},
                      {"xi", kind.xi},
                      {"eta", "omega/alpha"},
                      {"r", "rho/length"},
                      {"k_H", "k_h*sqrt(length)/stiffness"},
                      {"b_H", "b_h*length*alpha"},
                      {"k_S", "k_s/stiffness"}});
}

/// `own`: the quantities in which the kinds of excitation differ.
std::vector<equations::Definition> inverse(Texts own) {
  const Texts common = {{"c", "2*b*stiffness/alpha"},
                        {"omega", "alpha*eta"},
                        {"rho", "length*r"},
                        {"k_3", "beta*stiffness/length^2"},
                        {"k_h", "k_H*stiffness/sqrt(length)"},
                        {"b_h", "b_H/(length*alpha)"},
                        {"k_s", "k_S*stiffness"},
                        {"energy", "stiffness*length^2"}};
  own.insert(own.end(), common.begin(), common.end());
  return definitions(own);
}

/// The expressions of definitions in a graph, with other names given by `meaning`.
std::vector<equations::Expression> expressions(equations::Graph& graph, const std::vector<equations::Definition>& definitions,
                                               const std::function<equations::Expression(std::string_view)>& meaning) {
  equations::Scope scope;
  scope.find = [&](std::string_view name) -> std::optional<equations::Expression> {
    const auto one = std::find_if(definitions.begin(), definitions.end(),
                                  [&](const equations::Definition& definition) { return definition.name.text == name; });
    return one == definitions.end() ? std::optional(meaning(name)) : std::nullopt;
  };
  return equations::parse_definitions(graph, {}, definitions, scope, "parameter");
}

double value_in(const Values& values, std::string_view name) {
  const auto found = values.find(name);
  return found == values.end() ? 0.0 : found->second;
}

Values values_of(const std::vector<equations::Definition>& definitions, const Values& given) {
  equations::Graph graph;
  const auto list = expressions(graph, definitions, [&](std::string_view name) { return graph.constant(value_in(given, name)); });
  const std::vector<double> found = equations::values(graph, list, 0.0, Vector(), Vector());
  Values out;
  for (std::size_t i = 0; i < list.size(); ++i) out.emplace(definitions[i].name.text, found[i]);
  return out;
}

}  // namespace

const std::vector<ExcitationKind>& excitation_kinds() {
  static const std::vector<ExcitationKind> list = [] {
    const ParameterInfo mass = positive("m", "kg", "mass"), c = not_negative("c", "N s/m", "damping"),
                        omega = positive("omega", "rad/s", "frequency of excitation"),
                        rho = any("rho", "m", "clearance: the barrier is at X = rho"),
                        F0 = positive("F0", "N", "amplitude of the force"),
                        k_3 = any("k_3", "N/m^3", "cubic stiffness (cantilever only)");
    return std::vector<ExcitationKind>{
        {"kinematic",
         "m X'' + c X' + (k + k_e) X + k_3 X^3 = k_e a cos(omega t)",
         {mass, not_negative("k", "N/m", "stiffness of the spring to the ground"),
          positive("k_e", "N/m", "stiffness of the spring to the moving base"), c, positive("a", "m", "amplitude of the base"),
          omega, rho, k_3},
         conversion({.mass = "m", .stiffness = "k + k_e", .length = "a", .beta = "k_3*a*a/stiffness", .xi = "k_e/stiffness"}),
         inverse({{"m", "stiffness/alpha^2"}, {"k", "(1 - xi)*stiffness"}, {"k_e", "xi*stiffness"}, {"a", "length"}})},
        {"force",
         "m X'' + c X' + k X + k_3 X^3 = F0 cos(omega t)",
         {mass, positive("k", "N/m", "stiffness of the spring"), c, F0, omega, rho, k_3},
         conversion({.mass = "m", .stiffness = "k", .length = "F0/k", .beta = "k_3*length*length/k", .xi = "1"}),
         inverse({{"m", "stiffness/alpha^2"}, {"k", "stiffness"}, {"F0", "xi*stiffness*length"}})},
        {"beam",
         "mass M on two leaf springs, k_1 = 12 EI/L^3, force F0 cos(omega t)",
         {positive("M", "kg", "mass"), positive("L", "m", "length of the leaf springs"),
          positive("EI", "N m^2", "bending stiffness"), c, F0, omega, rho},
         conversion({.mass = "M", .stiffness = "12*EI/(L*L*L)", .length = "L", .beta = "36/35", .xi = "F0/(alpha*alpha*M*L)"}),
         inverse({{"M", "stiffness/alpha^2"}, {"L", "length"}, {"EI", "stiffness*length^3/12"}, {"F0", "xi*stiffness*length"}})},
    };
  }();
  return list;
}

const ExcitationKind& excitation_kind(std::string_view name) {
  std::vector<std::string> names;
  for (const ExcitationKind& kind : excitation_kinds()) {
    if (kind.name == name) return kind;
    names.push_back(kind.name);
  }
  throw std::invalid_argument(unknown_name("excitation", name, names));
}

const std::vector<ContactQuantity>& contact_quantities() {
  static const std::vector<ContactQuantity> list = {
      {positive("k_h", "N/m^(3/2)", "stiffness of the Hertz contact"), "k_H"},
      {not_negative("b_h", "s/m", "damping of the Hertz contact"), "b_H"},
      {positive("k_s", "N/m", "stiffness of the linear stop"), "k_S"},
  };
  return list;
}

const ParameterInfo& quantity_info(const ExcitationKind& kind, std::string_view name) {
  std::vector<std::string> names;
  for (const ParameterInfo& info : kind.quantities) {
    if (info.name == name) return info;
    names.push_back(info.name);
  }
  for (const ContactQuantity& quantity : contact_quantities()) {
    if (quantity.info.name == name) return quantity.info;
    names.push_back(quantity.info.name);
  }
  throw std::invalid_argument(unknown_name("physical quantity", name, names));
}

Values to_dimensionless(const ExcitationKind& kind, const Values& quantities) { return values_of(kind.conversion, quantities); }

Values from_dimensionless(const ExcitationKind& kind, const Values& dimensionless) {
  return values_of(kind.inverse, dimensionless);
}

equations::TextSystem read_oscillator(const OscillatorKind& oscillator, const ContactLaw& law, const ExcitationKind& kind,
                                      const Values& quantities, const std::vector<std::string>& chosen) {
  std::vector<ParameterInfo> infos;
  for (const std::string& name : chosen) {
    infos.push_back(quantity_info(kind, name));
    infos.back().default_value = value_in(quantities, name);
  }
  equations::Graph graph;
  const auto list = expressions(graph, kind.conversion, [&](std::string_view name) {
    const auto place = std::find(chosen.begin(), chosen.end(), name);
    return place == chosen.end() ? graph.constant(value_in(quantities, name))
                                 : graph.parameter(static_cast<std::size_t>(place - chosen.begin()));
  });
  std::vector<ParameterInfo> known = oscillator_parameters();
  known.insert(known.end(), law.parameters.begin(), law.parameters.end());
  std::vector<equations::Definition> tied;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const equations::Definition& one = kind.conversion[i];
    const bool is_parameter = std::any_of(known.begin(), known.end(), [&](const ParameterInfo& info) {
      return info.name == one.name.text &&
             (info.name != "beta" || oscillator.beta != 0.0);  // the linear oscillator has no beta, not even as a beam
    });
    const bool is_scale = one.name.text == "stiffness" || one.name.text == "alpha" || one.name.text == "length";
    if (!(is_parameter || is_scale) || equations::dependence(graph, list[i]).parameters.empty()) continue;
    tied.push_back({one.name, {equations::to_text(graph, list[i], {.states = {}, .parameters = chosen}), {}}});
  }
  return read_oscillator(oscillator, law, infos, tied);
}

}  // namespace graze
