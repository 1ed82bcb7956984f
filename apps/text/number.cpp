// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/text/number.hpp>

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace graze::apps {

namespace {

void skip_blanks(std::string_view& text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
}

/// Removes one factor, with its sign, from the front of the text.
std::optional<double> take_factor(std::string_view& text, bool& beyond) {
  skip_blanks(text);
  double sign = 1.0;
  if (!text.empty() && (text.front() == '-' || text.front() == '+')) {
    if (text.front() == '-') sign = -1.0;
    text.remove_prefix(1);
    if (!text.empty() && (text.front() == '-' || text.front() == '+')) return std::nullopt;
  }
  if (text.substr(0, 2) == "pi") {
    text.remove_prefix(2);
    return sign * std::numbers::pi;
  }
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  beyond = beyond || error == std::errc::result_out_of_range;
  if (error != std::errc{}) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return sign * value;
}

/// `beyond` becomes true if a factor has the form of a number but is too large or too small for a double.
std::optional<double> parse(std::string_view text, bool& beyond) {
  std::optional<double> value = take_factor(text, beyond);
  for (skip_blanks(text); value && !text.empty(); skip_blanks(text)) {
    const char sign = text.front();
    if (sign != '*' && sign != '/') return std::nullopt;
    text.remove_prefix(1);
    const std::optional<double> factor = take_factor(text, beyond);
    if (!factor) return std::nullopt;
    value = sign == '*' ? *value * *factor : *value / *factor;
  }
  return value;
}

}  // namespace

std::optional<double> parse_number(std::string_view text) {
  bool beyond = false;
  return parse(text, beyond);
}

bool is_beyond_double(std::string_view text) {
  bool beyond = false;
  return !parse(text, beyond) && beyond;
}

std::string no_number(std::string_view text) {
  return is_beyond_double(text) ? fmt::format("{:?} is {}; give another number", text, beyond_double)
                                : fmt::format("{:?} is not a number (0.05, 36/35 and 2*pi are)", text);
}

std::optional<int> parse_count(std::string_view text) {
  const std::optional<double> value = parse_number(text);
  if (!value || *value != std::floor(*value) || std::abs(*value) > std::numeric_limits<int>::max()) return std::nullopt;
  return static_cast<int>(*value);
}

std::optional<Vector> parse_numbers(std::string_view text) {
  std::vector<double> values;
  for (;;) {
    const std::size_t comma = text.find(',');
    const std::optional<double> value = parse_number(text.substr(0, comma));
    if (!value) return std::nullopt;
    values.push_back(*value);
    if (comma == std::string_view::npos) break;
    text.remove_prefix(comma + 1);
  }
  return Vector(Eigen::Map<const Vector>(values.data(), static_cast<Eigen::Index>(values.size())));
}

std::string exact(double value) { return fmt::format("{}", value); }

std::string rounded(double value, int digits) { return fmt::format("{:.{}g}", value, digits); }

std::vector<std::string> exact_cells(const Vector& values) {
  std::vector<std::string> cells;
  for (const double value : values) cells.push_back(exact(value));
  return cells;
}

std::vector<std::string> table_cells(const Vector& values) {
  std::vector<std::string> cells = exact_cells(values);
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (std::isnan(values[static_cast<Eigen::Index>(i)])) cells[i].clear();
  return cells;
}

std::string rounded_state(const Vector& state, int digits) {
  std::vector<std::string> values;
  for (const double value : state) values.push_back(rounded(value, digits));
  return fmt::format("({})", fmt::join(values, ", "));
}

std::string counted(std::size_t count, std::string_view noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

std::string rounded(std::complex<double> value, int digits) {
  if (value.imag() == 0.0) return rounded(value.real(), digits);
  return fmt::format("{} {} {} i", rounded(value.real(), digits), value.imag() < 0.0 ? "-" : "+",
                     rounded(std::abs(value.imag()), digits));
}

}  // namespace graze::apps
