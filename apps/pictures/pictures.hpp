// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of results, by their schema. To add one: a file in this folder that makes a PictureKind, and one line in
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
  std::string command = {};  ///< it is the default for results of this command
  /// Whether a result has what this kind shows; null: all of its schema have.
  bool (*applies)(const Json& result) = nullptr;
  /// Its vertical axis is that of the first state, where --y puts a quantity.
  bool of_state = false;
};

/// All kinds; the first of a schema is its default, unless a kind is made for the command that gave the result.
const std::vector<PictureKind>& picture_kinds();

/// Names of the kinds that a schema has.
std::vector<std::string> picture_names(const std::string& schema);

/// Of them, those that this result has something for.
std::vector<std::string> pictures_for(const Json& result);

/// The picture of a result. @throws std::invalid_argument for a schema or a kind there is none of, or a result without what it
/// needs.
Picture picture_of(const Json& result, const std::string& kind = {});

/// A table: a table of branches as x (or one column that is named) against the parameter, one colour per branch, by stability;
/// the states of a sweep, starts by the attractor they reach, and points of a section as dots; of any other, and where columns
/// are named, columns of numbers against the first of them, or those named.
/// @throws std::invalid_argument for a column there is none of, or a table without anything to draw.
Picture picture_of(const Table& table, const std::string& x = {}, const std::vector<std::string>& y = {});

/// Colours that are told apart, in turn.
std::string colour_of(std::size_t series);

/// The title that all pictures of a model have: its kind and its parameters but `except`.
std::string model_title(const Json& result, const std::string& except = {});

/// The barriers that stand still before one of the states: where a contact begins at a value of it that depends on parameters
/// alone.
std::vector<Barrier> barriers_of(const Json& result, std::size_t state, bool vertical);

/// The states on the axes of a phase portrait: the first one and its rate if that is a state (position and velocity), else the
/// first two. `--plane` chooses others.
using StatePair = std::array<std::size_t, 2>;
StatePair portrait_plane(const Json& result);

/// The member of a result in which `graze plot --plane` puts two states by their numbers.
inline constexpr const char* seen_plane = "seen_plane";

/// Behind a name on an axis: " / mm", " (dimensionless)"; empty where the file gives no unit.
std::string unit_behind(const Problem& problem, const std::string& name);

/// Names for axes: "eta (dimensionless)"; of a system written as text "A / mm", or the plain name where no unit is given.
std::string parameter_label(const Json& result, const std::string& name);
std::string time_label(const Json& result);

/// "x", "x'"; or the quantity that stands in its place.
std::string state_name(const Json& result, std::size_t state);

/// The same with its unit: "x (dimensionless)", "x at forcing phase 0 / mm".
std::string state_label(const Json& result, std::size_t state, bool at_phase_0);

/// The exponents of a sweep without title, to stand below other axes of this range.
Picture exponents_below(const Json& result, const std::array<double, 2>& x_range);

/// States of sweeps ("up", "down") as dots, with their legend; the picture's range of x is given by then.
void add_sweep_dots(Picture& picture, const std::map<std::string, std::vector<std::array<double, 3>>>& states);

/// Starts as dots in one of the colours, by their indices; -1: none.
void add_start_dots(Picture& picture, const std::vector<std::array<double, 2>>& starts, const std::vector<int>& colour,
                    const std::vector<std::string>& colours);

/// The colour of starts whose motion was lost.
inline constexpr const char* lost_colour = "#000000";

/// A kind of picture for results of another schema that have what it needs.
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
