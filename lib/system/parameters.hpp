// SPDX-License-Identifier: GPL-3.0-or-later
// Named parameters of a system with their ranges.
//
// Every function that takes a parameter name throws std::invalid_argument if there is no such parameter; the message names the
// nearest valid one. Values are dimensionless unless `unit` says otherwise.
#pragma once

#include <graze/lib/numerics/vector.hpp>

#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace graze {

/// One parameter: its name, default, allowed range (ends included unless `*_open`) and meaning.
struct ParameterInfo {
  std::string name;
  double default_value = 0.0;
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  bool lower_open = false;  ///< true: `lower` itself is not allowed
  std::string unit = "dimensionless";
  std::string meaning;
};

/// The range as text, such as "[0, 1]", "> 0" or "any finite number".
std::string range_text(const ParameterInfo& parameter);

/// Index of the parameter called `name`. @throws std::invalid_argument (with the nearest valid name).
std::size_t parameter_index(const std::vector<ParameterInfo>& parameters, std::string_view name);

/// The default values, in order.
Vector default_parameters(const std::vector<ParameterInfo>& parameters);

/// Checks that there is one finite value in range for each parameter.
/// @throws std::invalid_argument naming parameter, value and allowed range.
void check_parameters(const std::vector<ParameterInfo>& parameters, const Vector& values);

/// The candidate nearest to `given` in edit distance; empty if the distance exceeds a third of the letters of `given`, rounded
/// up. Empty also for a name of one letter, to which every other letter is near.
std::string nearest_name(std::string_view given, const std::vector<std::string>& candidates);

/// "there is no KIND "given" (did you mean "..."?); choose one of ...": the message for every unknown name.
std::string unknown_name(std::string_view kind, std::string_view given, const std::vector<std::string>& candidates);

}  // namespace graze
