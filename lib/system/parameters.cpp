// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/system/parameters.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace graze {

namespace {

/// Levenshtein distance in which swapping two neighbouring letters counts as one edit.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before_last(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = a[i - 1] == b[j - 1] ? 0 : 1;
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + change});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
    before_last = last;
    last = row;
  }
  return last[b.size()];
}

}  // namespace

std::string nearest_name(std::string_view given, const std::vector<std::string>& candidates) {
  constexpr std::size_t longest_name = 100;  // the cost of the distance is the product of the lengths
  const auto letters = std::count_if(given.begin(), given.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;  // no continuation byte of UTF-8
  });
  if (letters < 2 || given.size() > longest_name) return {};
  std::string best;
  std::size_t best_distance = std::max<std::size_t>(1, (given.size() + 2) / 3) + 1;
  for (const std::string& candidate : candidates) {
    const std::size_t distance = edit_distance(given, candidate);
    if (distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

std::string unknown_name(std::string_view kind, std::string_view given, const std::vector<std::string>& candidates) {
  const std::string nearest = nearest_name(given, candidates);
  return fmt::format("there is no {} {:?}{}; choose one of {}", kind, given,
                     nearest.empty() ? "" : fmt::format(" (did you mean \"{}\"?)", nearest), fmt::join(candidates, ", "));
}

std::string range_text(const ParameterInfo& parameter) {
  const bool below = std::isfinite(parameter.lower), above = std::isfinite(parameter.upper);
  if (below && above) return fmt::format("{}{}, {}]", parameter.lower_open ? "(" : "[", parameter.lower, parameter.upper);
  if (below) return fmt::format("{} {}", parameter.lower_open ? ">" : ">=", parameter.lower);
  if (above) return fmt::format("<= {}", parameter.upper);
  return "any finite number";
}

std::size_t parameter_index(const std::vector<ParameterInfo>& parameters, std::string_view name) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (parameters[i].name == name) return i;
    names.push_back(parameters[i].name);
  }
  throw std::invalid_argument(unknown_name("parameter", name, names));
}

Vector default_parameters(const std::vector<ParameterInfo>& parameters) {
  Vector values(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t i = 0; i < parameters.size(); ++i) values[static_cast<Eigen::Index>(i)] = parameters[i].default_value;
  return values;
}

void check_parameters(const std::vector<ParameterInfo>& parameters, const Vector& values) {
  if (static_cast<std::size_t>(values.size()) != parameters.size())
    throw std::invalid_argument(
        fmt::format("{} parameter values were given; this model has {}", values.size(), parameters.size()));
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const ParameterInfo& parameter = parameters[i];
    const double value = values[static_cast<Eigen::Index>(i)];
    const bool inside = std::isfinite(value) && value <= parameter.upper &&
                        (parameter.lower_open ? value > parameter.lower : value >= parameter.lower);
    if (inside) continue;
    // "> 0" alone does not explain why infinity is refused.
    const std::string range = range_text(parameter);
    const bool half_open = range.starts_with('>') || range.starts_with('<');
    throw std::invalid_argument(fmt::format("parameter {} is {}; allowed is {}{}", parameter.name, value,
                                            half_open && !std::isfinite(value) ? "a finite number " : "", range));
  }
}

}  // namespace graze
