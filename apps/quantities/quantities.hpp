// SPDX-License-Identifier: GPL-3.0-or-later
// Quantities: values of an orbit or an attractor that --y requests. E is any expression of states, their rates (v'),
// parameters, t, definitions and outputs.
//
//     E                                       at forcing phase 0: of an orbit of n periods n values
//     max(E), min(E), amplitude(E), mean(E)   over the orbit; the amplitude is (max - min)/2
//     impact_speed_max, impact_speed_min      of impacts and entries into contact; NaN without any
//     impacts, impacts_per_period             their number, over the orbit and per forcing period
//     energy_lost                             per forcing period, in contacts
//     period                                  the duration of the orbit
//
// For a problem given in physical quantities X and V are displacement and velocity, and the quantities of the file are names
// too; impact speeds, energy_lost and period are in m/s, J and s.
// With two arguments, max and min are functions within E. A name of the problem takes precedence over a word of this list.
#pragma once

#include <graze/apps/problem/problem.hpp>
#include <graze/apps/text/json_text.hpp>
#include <graze/apps/text/table.hpp>

#include <graze/floquet/attractor/attractor.hpp>
#include <graze/floquet/orbit/periodic_orbit.hpp>
#include <graze/lib/equations/motion_functions.hpp>

#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace graze::apps {

enum class QuantityKind {
  at_phase_0,
  largest,
  smallest,
  amplitude,
  mean,
  impact_speed_max,
  impact_speed_min,
  impacts,
  impacts_per_period,
  energy_lost,
  period
};

struct Quantity {
  std::string text;  ///< as given by the user
  QuantityKind kind = QuantityKind::at_phase_0;
  std::size_t function = 0;               ///< index of E in Quantities::functions
  std::optional<std::size_t> scale = {};  ///< function whose value, a constant of the motion, turns the quantity into its unit
  bool moves = false;                     ///< E depends on the motion, not only on parameters
  std::string unit = {};                  ///< empty: unknown
};

struct Quantities {
  std::vector<Quantity> list;
  equations::MotionFunctions functions;
  bool empty() const { return list.empty(); }
};

/// Adds the option --y.
void add_quantity_option(CLI::App& app, std::vector<std::string>& texts);

/// @throws std::invalid_argument in one sentence, with the allowed forms, for a text that is not a quantity.
Quantities read_quantities(const Problem& problem, const std::vector<std::string>& texts);

/// Adds the texts to a result's options as "y", unless there are none.
void put_quantity_option(Json& options, const std::vector<std::string>& texts);

/// Label of an axis: "max(x1) / mm", "x1 at forcing phase 0 / mm"; for built-in systems "max(x) (dimensionless)". `at_phase_0`:
/// whether expressions belong to states at forcing phase 0.
std::string quantity_label(const Problem& problem, const std::string& text, bool at_phase_0);

/// The same for the states of one motion, which has values of expressions only.
Quantities read_expressions(const Problem& problem, const std::vector<std::string>& texts);

/// Appends the values of the expressions to rows of states. If `timed`, the time precedes the states; otherwise the forcing
/// phase is 0.
void append_values(const Quantities& expressions, const Problem& problem, bool timed, std::vector<Vector>& rows);

/// A quantity of one motion: one value, or one for each forcing period. NaN: unknown.
struct QuantityValue {
  std::string name;
  std::vector<double> values;
};
using QuantityValues = std::vector<QuantityValue>;

/// A motion given by its states at forcing phase 0, one for each period (for an autonomous system by its initial state).
/// `duration`: of all periods together.
struct MeasuredMotion {
  std::vector<Vector> states;
  double duration = 0.0;
  bool closes = true;  ///< it leads from the last state back to the first
};

/// The values of the quantities. All are NaN if a free run does not reach the next state: for an inadmissible orbit, or for one
/// so close to grazing that it cannot be reproduced.
QuantityValues measure(const Quantities& quantities, const HybridSystem& system, const Vector& p, const MeasuredMotion& motion);

QuantityValues measure(const Quantities& quantities, const HybridSystem& system, const PeriodicOrbit& orbit);

/// For an attractor that is not an orbit: the quantities of the motion over 64 forcing periods from its state. Without forcing
/// they are unknown, because its returns do not give its duration.
QuantityValues measure(const Quantities& quantities, const HybridSystem& system, const Vector& p, const Attractor& attractor);

/// Sets "y": {"max(x)": 1.2, "x": [0.3, 0.5]}, a number or a list of several. Without values an existing "y" is removed.
void put_quantities(Json& json, const QuantityValues& values);
/// The schema of an object to which quantities are added.
Json with_quantities(Json schema);
void write_quantities(const QuantityValues& values, JsonText& json);

/// The value of each quantity in a period: that period's value, or the only one.
std::vector<double> values_at(const QuantityValues& values, std::size_t period = 0);

/// The names as further columns, and their cells: rounded for people, or exact and empty if a value is unknown.
void add_columns(Table& table, const QuantityValues& values);
/// One further column. A name that the table has already, such as "period", becomes "period (--y)".
void add_quantity_column(Table& table, const std::string& name);
void add_cells(std::vector<std::string>& row, const QuantityValues& values, bool for_people);

}  // namespace graze::apps
