// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers as people write and read them, on the command line and in problem files.
#pragma once

#include <graze/lib/numerics/vector.hpp>

#include <complex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace graze::apps {

/// Factors joined by * and /, each a decimal number or pi: "0.05", "-1e-3", "36/35", "2*pi". "nan" and "inf" are read as well,
/// so that a caller that knows the allowed range can refuse them by name. nullopt: not a number.
std::optional<double> parse_number(std::string_view text);

/// A whole number: "1000", "1e3". nullopt: not a whole number, or too large for int.
std::optional<int> parse_count(std::string_view text);

/// Numbers separated by commas: "-0.169,-0.962". nullopt: an entry is not a number.
std::optional<Vector> parse_numbers(std::string_view text);

inline constexpr const char* beyond_double =
    "too large or too small for a double, which holds 0 and magnitudes from 4.9e-324 to 1.8e308";

/// Whether the text is a number too large or too small for a double. The functions above do not read such numbers.
bool is_beyond_double(std::string_view text);

/// One sentence on why the text cannot be read.
std::string no_number(std::string_view text);

/// The shortest text that reads back to the same double.
std::string exact(double value);

/// Rounded to `digits` significant digits, for people.
std::string rounded(double value, int digits = 12);

/// exact() of each number.
std::vector<std::string> exact_cells(const Vector& values);
/// The same for a table: an unknown number is an empty cell.
std::vector<std::string> table_cells(const Vector& values);

/// "(1.5, 0.2)".
std::string rounded_state(const Vector& state, int digits = 12);

/// "1 orbit", "2 orbits".
std::string counted(std::size_t count, std::string_view noun);

/// "0.609 + 0.366 i", or one number if the imaginary part is 0.
std::string rounded(std::complex<double> value, int digits = 12);

}  // namespace graze::apps
