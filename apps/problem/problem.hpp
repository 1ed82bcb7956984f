// SPDX-License-Identifier: GPL-3.0-or-later
// Problem: the contents of a problem file (TOML): a model, its parameter values, and the start. The file holds
//
//   [model]       oscillator = "linear", contact = "hertz"          (names: graze models)
//   [parameters]  b = 0.05, beta = "36/35", ...                     dimensionless values; a missing one has its default
//   [physical]    excitation = "kinematic", m = 1.0, ...            instead of [parameters]: converted (physical_units.hpp)
//   [start]       state = [x, v], settle = 1000, period = 1         optional; --start, --settle, --period take precedence
//
// or a system of its own, written as text (system_file.hpp).
//
// Every mistake in a file is a std::invalid_argument with one sentence: file, line, given value, allowed values.
#pragma once

#include <graze/apps/console/arguments.hpp>
#include <graze/lib/equations/system_text.hpp>
#include <graze/lib/system/hybrid_system.hpp>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace graze::apps {

/// Physical quantities from which the parameters were converted.
struct ConvertedFrom {
  std::string excitation;
  std::vector<std::pair<std::string, double>> quantities;
  double alpha = 0.0, length = 0.0;   ///< tau = alpha t, x = X / length
  std::vector<std::string> obtained;  ///< names of the parameters converted from them
  std::vector<std::string> chosen;    ///< quantities that --param made parameters of the system
};

/// Longest period of an orbit, in forcing periods: its matrices grow with the square.
inline constexpr int longest_period = 1024;

/// The smallest eta for which motions are computed: a forcing period of 10000 natural periods.
inline constexpr double slowest_forcing = 1e-4;

struct Problem {
  std::string file;
  std::string oscillator, contact;                       ///< of a built-in system
  std::string text;                                      ///< the whole file, if it has a system of its own
  std::shared_ptr<const equations::TextSystem> written;  ///< the system read from text, also for a built-in system
  HybridSystem system;
  Vector parameters;
  std::vector<std::string> defaulted;  ///< parameters given neither by the file nor by a setting
  std::optional<ConvertedFrom> converted_from;
  std::optional<Vector> start;
  std::optional<int> settle, period;
};

/// Whether the system belongs to the built-in family, rather than being a file's own.
inline bool is_built_in(const Problem& problem) { return problem.text.empty(); }

Problem load_problem(const std::string& file);

/// The same from text; `file` is the name used in messages.
Problem parse_problem(std::string_view text, const std::string& file);

/// A model with its default parameters. @throws std::invalid_argument for unknown names.
Problem make_problem(const std::string& oscillator, const std::string& contact);

/// The value of a parameter, tied parameters included.
double parameter(const Problem& problem, std::string_view name);

/// The dimensionless parameters of a built-in system in the order of make_oscillator, tied to physical quantities or not.
Vector built_in_parameters(const Problem& problem);

/// @throws std::invalid_argument for a parameter that the model does not have, or a value out of its range.
void set_parameter(Problem& problem, std::string_view name, double value);

/// Sets several parameters at once.
void set_parameters(Problem& problem, const std::vector<std::pair<std::string, double>>& values);

/// The same for a value given by an option such as "--from", which the message then names.
void set_parameter(Problem& problem, std::string_view name, double value, const std::string& option);

/// The parameter given by --param; if that is empty, the forcing frequency. @throws std::invalid_argument if it is empty and
/// the system has no forcing frequency.
std::string parameter_name(const Problem& problem, const std::string& given);

/// For a file with physical quantities: makes those quantities that are among `names` parameters of the system, and ties the
/// dependent parameters to them. Other names are left to check_parameter_name. @throws std::invalid_argument if a dimensionless
/// parameter was set to a value that differs from the converted one.
void choose_quantities(Problem& problem, const std::vector<std::string>& names);
/// The same for quantities known to be given; dimensionless parameters set before are not checked.
void vary_quantities(Problem& problem, const std::vector<std::string>& chosen);

/// @throws std::invalid_argument for a parameter given by --param that the model does not have.
void check_parameter_name(const Problem& problem, std::string_view name);

/// " (k_H belongs to the hertz contact law)" for a parameter that this model lacks but other laws have, similarly for a
/// physical quantity; otherwise empty.
std::string owner_of(std::string_view parameter, const std::string& contact);

/// Applies settings of the form name=value, in order.
void apply_settings(Problem& problem, const std::vector<std::string>& settings);

/// The default start of a motion: rest at 0, or at the barrier if 0 lies beyond it.
Vector rest_state(const Problem& problem, const Vector& parameters);

/// The state at forcing phase 0 to start from: `given`, else the file's, else rest_state().
/// @throws std::invalid_argument for a state that is not admissible.
Vector start_state(const Problem& problem, const std::optional<Vector>& given);

/// A state given by position or by name; states that are not named are taken from the file, else 0. `option` is the name used
/// in messages. @throws std::invalid_argument for a wrong number of values or an unknown name.
Vector state_of(const Problem& problem, const StateText& given, const std::string& option = "--start");

/// The indices of the two states that --plane names, "x2,v2". @throws std::invalid_argument for anything else.
std::array<std::size_t, 2> plane_of(const Problem& problem, const std::string& given);

/// Names of the states as columns of a table ("x", "v"), and as people read them ("x", "x'" for the built-in oscillators).
std::vector<std::string> state_columns(const Problem& problem);
std::vector<std::string> state_headings(const Problem& problem);

/// "1 forcing period", "2 returns": the unit in which a motion's periods are counted.
std::string counted_periods(const Problem& problem, std::int64_t count);
/// The same without the number, in the plural.
std::string_view periods_name(const Problem& problem);

/// "x = 1.5   x' = 0.2".
std::string state_text(const Problem& problem, const Vector& state, int digits);

/// "linear oscillator, hertz contact", or the name of the file's own system.
std::string title(const Problem& problem);

/// "linear oscillator, hertz contact: b = 0.05, ..., k_H = 100", without the parameter called `except`.
std::string describe(const Problem& problem, std::string_view except = {});

}  // namespace graze::apps
