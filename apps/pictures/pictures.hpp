// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of results, by their schema. A new kind is a file in this folder that defines a PictureKind, and one line in
// picture_kinds().
#pragma once

#include <graze/apps/drawing/picture.hpp>
#include <graze/apps/problem/problem.hpp>
#include <graze/apps/text/json.hpp>
#include <graze/apps/text/table.hpp>

#include <array>
#include <map>
#include <string>
#include <vector>

namespace graze::apps {

struct PictureKind {
  std::string schema;  ///< "graze.branch/1"
  std::string name;    ///< for --plot-kind
  std::string summary;
  Picture (*draw)(const Json& result) = nullptr;
  std::string command = {};  ///< the command for whose results this kind is the default
  /// Whether a result has the data that this kind shows; null: every result of the schema has them.
  bool (*applies)(const Json& result) = nullptr;
  /// The vertical axis is that of the first state, which --y replaces with a quantity.
  bool of_state = false;
};

/// All kinds. The first kind of a schema is its default, unless there is a kind for the command that wrote the result.
const std::vector<PictureKind>& picture_kinds();
/// Adds one from outside the library; see run_main (program.hpp). @throws std::invalid_argument if its schema has one of this
/// name.
void add_picture_kind(PictureKind kind);

/// Names of the kinds of a schema.
std::vector<std::string> picture_names(const std::string& schema);

/// Those of them for which this result has data.
std::vector<std::string> pictures_for(const Json& result);

/// The picture of a result. @throws std::invalid_argument for an unknown schema or kind, or a result without the required data.
Picture picture_of(const Json& result, const std::string& kind = {});

/// The picture of a table. A table of branches shows x (or one named column) against the parameter, one colour per branch, with
/// strokes by stability. States of a sweep, starts (coloured by the attractor they reach) and points of a section are dots. Any
/// other table, or named columns, shows columns of numbers against the first column, or the named ones.
/// @throws std::invalid_argument for an unknown column, or a table without data to draw.
Picture picture_of(const Table& table, const std::string& x = {}, const std::vector<std::string>& y = {});

/// Distinguishable colours, in rotation.
std::string colour_of(std::size_t series);

/// The common title of all pictures of a model: its kind and its parameters without `except`.
std::string model_title(const Json& result, const std::string& except = {});

/// The fixed barriers in one of the states: contacts that begin at a value of this state which depends only on parameters.
std::vector<Barrier> barriers_of(const Json& result, std::size_t state, bool vertical);

/// The states on the axes of a phase portrait: the first state and its rate if that is a state (position and velocity), else
/// the first two. `--plane` selects others.
using StatePair = std::array<std::size_t, 2>;
StatePair portrait_plane(const Json& result);

/// The member of a result in which `graze plot --plane` stores the indices of two states.
inline constexpr const char* shown_plane = "shown_plane";

/// The unit after a name on an axis: " / mm", " (dimensionless)"; empty if the file gives no unit.
std::string unit_behind(const Problem& problem, const std::string& name);

/// Whether the result is that of a forced system.
bool has_forcing(const Json& result);

/// Names for axes: "eta (dimensionless)"; for a system written as text "A / mm", or the plain name if no unit is given.
std::string parameter_label(const Json& result, const std::string& name);
std::string time_label(const Json& result);
/// Of Lyapunov exponents: "exponent (dimensionless)", "exponent / (1/s)".
std::string exponent_label(const Json& result);

/// "x", "x'", or the quantity that takes the state's place.
std::string state_name(const Json& result, std::size_t state);

/// The same with its unit: "x (dimensionless)", "x at forcing phase 0 / mm".
std::string state_label(const Json& result, std::size_t state, bool at_phase_0);

/// The exponents of a sweep without title, to be placed below other axes of this range.
Picture exponents_below(const Json& result, const std::array<double, 2>& x_range);

/// Adds states of sweeps ("up", "down") as dots, with their legend; the picture's range of x must be set.
void add_sweep_dots(Picture& picture, const std::map<std::string, std::vector<std::array<double, 3>>>& states);

/// Adds starts as dots in one of the colours, given by their indices; -1: no dot.
void add_start_dots(Picture& picture, const std::vector<std::array<double, 2>>& starts, const std::vector<int>& colour,
                    const std::vector<std::string>& colours);

/// The colour of starts whose motion was lost.
inline constexpr const char* lost_colour = "#000000";

/// A kind of picture for results of another schema that have the required data.
PictureKind of_schema(PictureKind kind, const std::string& schema);

PictureKind branch_picture();
PictureKind multipliers_picture();
PictureKind skeleton_picture();
PictureKind orbit_phase_picture();
PictureKind orbit_time_picture();
PictureKind point_phase_picture();
PictureKind trajectory_time_picture();
PictureKind trajectory_phase_picture();
PictureKind section_picture();
PictureKind verify_picture();
PictureKind restitution_picture();
PictureKind hard_limit_picture();
PictureKind sweep_diagram_picture();
PictureKind sweep_picture();
PictureKind exponents_picture();
PictureKind diagram_picture();
PictureKind basins_picture();
PictureKind map_picture();
PictureKind map_exponent_picture();
PictureKind map_quantity_picture();

}  // namespace graze::apps
