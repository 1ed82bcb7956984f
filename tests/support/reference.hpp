// SPDX-License-Identifier: GPL-3.0-or-later
// The independent figures of data/reference.toml (quadruple precision; that file describes the computation): orbits, special
// points and derivatives along families, each with its system. States are those at forcing phase 0 with the largest x; some of
// them lie inside the contact.
#pragma once

#include <graze/lib/models/oscillator.hpp>

#include <complex>
#include <stdexcept>
#include <toml++/toml.h>

namespace graze::support {

struct ReferenceOrbit {
  std::string name;
  HybridSystem system;
  Vector parameters;
  int period = 0, impacts = 0;
  Vector state;
  std::vector<std::complex<double>> multipliers;
  std::vector<double> exponents;
  double log_det = 0.0;
  Matrix monodromy;
  std::vector<double> impact_times, impact_speeds;  ///< entries; a contact in progress at phase 0 is the last
  bool period_doubling = false;
};

struct ReferenceDerivative {
  std::string orbit, parameter;
  Vector state_derivative;
};

namespace detail {

inline std::vector<double> numbers(const toml::array* array) {
  std::vector<double> list;
  for (const auto& item : *array) list.push_back(item.value<double>().value());
  return list;
}

inline Vector as_vector(const std::vector<double>& list) {
  return Eigen::Map<const Vector>(list.data(), static_cast<Eigen::Index>(list.size()));
}

inline ReferenceOrbit read_orbit(const toml::table& table) {
  ReferenceOrbit orbit;
  orbit.name = table["name"].value<std::string>().value();
  const toml::table& values = *table["parameters"].as_table();
  const bool cubic = values["beta"].value<double>().value() != 0.0;
  orbit.system = make_oscillator(cubic ? "cantilever" : "linear", table["contact"].value<std::string>().value());
  orbit.parameters = default_parameters(orbit.system.parameters);
  for (const auto& [key, value] : values)
    orbit.parameters[static_cast<Eigen::Index>(parameter_index(orbit.system.parameters, key.str()))] =
        value.value<double>().value();
  orbit.period = table["period"].value<int>().value();
  orbit.impacts = table["impacts"].value<int>().value();
  orbit.state = as_vector(numbers(table["state"].as_array()));
  for (const auto& pair : *table["multipliers"].as_array()) {
    const std::vector<double> parts = numbers(pair.as_array());
    orbit.multipliers.emplace_back(parts[0], parts[1]);
  }
  orbit.exponents = numbers(table["exponents"].as_array());
  orbit.log_det = table["log_det"].value<double>().value();
  orbit.monodromy.resize(2, 2);
  for (std::size_t row = 0; row < 2; ++row)
    orbit.monodromy.row(static_cast<Eigen::Index>(row)) = as_vector(numbers(table["monodromy"][row].as_array())).transpose();
  orbit.impact_times = numbers(table["impact_times"].as_array());
  orbit.impact_speeds = numbers(table["impact_speeds"].as_array());
  orbit.period_doubling = table["type"].value_or(std::string()) == "PD";
  return orbit;
}

}  // namespace detail

/// All orbits, including those of the special points.
inline const std::vector<ReferenceOrbit>& reference_orbits() {
  static const std::vector<ReferenceOrbit> list = [] {
    std::vector<ReferenceOrbit> orbits;
    const toml::table file = toml::parse_file(GRAZE_DATA_DIR "/reference.toml");
    for (const char* kind : {"orbit", "special_point"})
      for (const auto& table : *file[kind].as_array()) orbits.push_back(detail::read_orbit(*table.as_table()));
    return orbits;
  }();
  return list;
}

inline const ReferenceOrbit& reference_orbit(std::string_view name) {
  for (const ReferenceOrbit& orbit : reference_orbits())
    if (orbit.name == name) return orbit;
  throw std::invalid_argument("data/reference.toml has no orbit " + std::string(name));
}

inline std::vector<ReferenceDerivative> reference_derivatives() {
  std::vector<ReferenceDerivative> list;
  const toml::table file = toml::parse_file(GRAZE_DATA_DIR "/reference.toml");
  for (const auto& item : *file["derivative"].as_array()) {
    const toml::table& table = *item.as_table();
    list.push_back({table["orbit"].value<std::string>().value(), table["parameter"].value<std::string>().value(),
                    detail::as_vector(detail::numbers(table["state_derivative"].as_array()))});
  }
  return list;
}

}  // namespace graze::support
