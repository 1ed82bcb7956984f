// SPDX-License-Identifier: GPL-3.0-or-later
// Problem: what a problem file (TOML) says: a model, its parameter values, and where to start. The file holds
//
//   [model]       oscillator = "linear", contact = "hertz"          (names: graze models)
//   [parameters]  b = 0.05, beta = "36/35", ...                     dimensionless values; what is missing has its default
//   [physical]    excitation = "kinematic", m = 1.0, ...            instead of [parameters]: converted (physical_units.hpp)
//   [start]       state = [x, v], settle = 1000, period = 1         optional; --start, --settle, --period go before it
//
// or a system of its own, written as text (system_file.hpp).
//
// Every mistake in a file is a std::invalid_argument with one sentence: file, line, what was given, what is allowed.
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

/// Physical quantities that the parameters were converted from.
struct ConvertedFrom {
  std::string excitation;
  std::vector<std::pair<std::string, double>> quantities;
  std::vector<std::string> units;     ///< one per quantity
  double alpha = 0.0, length = 0.0;   ///< tau = alpha t, x = X / length
  std::vector<std::string> obtained;  ///< names of the parameters they gave
  std::vector<std::string> chosen;    ///< those that are parameters of the system, by --param
};

/// Of an orbit, in forcing periods: its matrices grow with the square.
inline constexpr int longest_period = 1024;

/// The smallest eta for which motions are computed: a forcing period of 10000 natural ones.
inline constexpr double slowest_forcing = 1e-4;

struct Problem {
  std::string file;
  std::string oscillator, contact;                       ///< of a built-in system
  std::string text;                                      ///< of a file with a system of its own, whole
  std::shared_ptr<const equations::TextSystem> written;  ///< what the text says, a built-in system's too
  HybridSystem system;
  Vector parameters;
  std::vector<std::string> defaulted;  ///< parameters that neither the file nor a setting gives
  std::optional<ConvertedFrom> converted_from;
  std::optional<Vector> start;
  std::optional<int> settle, period;
};

/// Whether the system is of the built-in family, rather than a file's own.
inline bool is_built_in(const Problem& problem) { return problem.text.empty(); }

Problem load_problem(const std::string& file);

/// The same from text; `file` is what messages call it.
Problem parse_problem(std::string_view text, const std::string& file);

/// A model with its default parameters. @throws std::invalid_argument for unknown names.
Problem make_problem(const std::string& oscillator, const std::string& contact);

/// The value of a parameter, of one that is tied to others, too.
double parameter(const Problem& problem, std::string_view name);

/// Of a built-in system: its dimensionless parameters in the order of make_oscillator, whichever are tied to physical quantities.
Vector built_in_parameters(const Problem& problem);

/// @throws std::invalid_argument for a parameter the model does not have, or a value out of its range.
void set_parameter(Problem& problem, std::string_view name, double value);

/// Several at once.
void set_parameters(Problem& problem, const std::vector<std::pair<std::string, double>>& values);

/// The same for a value given by an option such as "--from", which the message then names.
void set_parameter(Problem& problem, std::string_view name, double value, const std::string& option);

/// The parameter that was given by --param; empty: the forcing frequency. @throws std::invalid_argument if it is empty and the
/// system has none.
std::string parameter_name(const Problem& problem, const std::string& given);

/// Makes physical quantities among the names, of a file that gives its parameters so, parameters of the system; what depends on
/// them is tied to them. Other names are left to check_parameter_name. @throws std::invalid_argument where a dimensionless
/// parameter was set to another value than the quantities give.
void choose_quantities(Problem& problem, const std::vector<std::string>& names);
/// The same for quantities that are known to be given, whatever the dimensionless parameters were.
void vary_quantities(Problem& problem, const std::vector<std::string>& chosen);

/// @throws std::invalid_argument for a parameter that was given by --param and that the model does not have.
void check_parameter_name(const Problem& problem, std::string_view name);

/// " (k_H belongs to the hertz contact law)" for a parameter that the model lacks and other laws have, or the like for a physical
/// quantity; else empty.
std::string owner_of(std::string_view parameter, const std::string& contact);

/// Applies settings of the form name=value, in order.
void apply_settings(Problem& problem, const std::vector<std::string>& settings);

/// Where a motion starts if nobody says where: rest at 0, or at the barrier if 0 lies beyond it.
Vector rest_state(const Problem& problem, const Vector& parameters);

/// The state at forcing phase 0 to start from: `given`, else the file's, else rest_state().
/// @throws std::invalid_argument for a state that is not admissible.
Vector start_state(const Problem& problem, const std::optional<Vector>& given);

/// A state that was given by position or by name; states that are not named are those of the file, else 0. `option` is what
/// messages call it. @throws std::invalid_argument for a wrong number of values or an unknown name.
Vector state_of(const Problem& problem, const StateText& given, const std::string& option = "--start");

/// The numbers of the two states that --plane names, "x2,v2". @throws std::invalid_argument for anything else.
std::array<std::size_t, 2> plane_of(const Problem& problem, const std::string& given);

/// Names of the states as columns of a table ("x", "v"), and as people read them ("x", "x'" for the built-in oscillators).
std::vector<std::string> state_columns(const Problem& problem);
std::vector<std::string> state_headings(const Problem& problem);

/// "1 forcing period", "2 returns": what a motion's periods are.
std::string counted_periods(const Problem& problem, std::int64_t count);
/// The same without the number, for many.
std::string_view periods_name(const Problem& problem);

/// "x = 1.5   x' = 0.2".
std::string state_text(const Problem& problem, const Vector& state, int digits);

/// "linear oscillator, hertz contact", or the name of the file's own system.
std::string title(const Problem& problem);

/// "linear oscillator, hertz contact: b = 0.05, ..., k_H = 100", without the parameter called `except`.
std::string describe(const Problem& problem, std::string_view except = {});

}  // namespace graze::apps
