// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of CSV tables: graze's own, recognised by their header, and any other.
#include <graze/apps/pictures/branch_curves.hpp>
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/pictures/range.hpp>
#include <graze/apps/pictures/skeleton.hpp>
#include <graze/apps/text/number.hpp>
#include <graze/lib/system/parameters.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

namespace graze::apps {

namespace {

using Names = std::vector<std::string>;

std::size_t column(const Table& table, const std::string& name) {
  const auto found = std::find(table.columns.begin(), table.columns.end(), name);
  if (found == table.columns.end()) throw std::invalid_argument(unknown_name("column", name, table.columns));
  return static_cast<std::size_t>(found - table.columns.begin());
}

bool has(const Table& table, const std::string& name) {
  return std::find(table.columns.begin(), table.columns.end(), name) != table.columns.end();
}

double number(const std::vector<std::string>& row, std::size_t i) { return parse_number(row[i]).value_or(std::nan("")); }

/// Whether the table has the form of `graze continue --csv`: the parameter stands between "impacts" and "x".
bool is_branches(const Table& table) {
  for (const char* name : {"branch", "label", "period", "impacts", "x", "stable", "admissible"})
    if (!has(table, name)) return false;
  return column(table, "x") == column(table, "impacts") + 2;
}

/// Column `up` against column `across`: x against the parameter if they are not named.
Picture draw_branches(const Table& table, const std::string& across, const std::string& up) {
  const std::size_t branch = column(table, "branch"), label = column(table, "label"), period = column(table, "period"),
                    x = column(table, up.empty() ? "x" : up),
                    value = across.empty() ? column(table, "x") - 1 : column(table, across), stable = column(table, "stable"),
                    admissible = column(table, "admissible");
  Picture picture;
  picture.title = "Periodic orbits";
  picture.x_label = table.columns[value] + (across.empty() ? " (dimensionless)" : "");
  picture.y_label = up.empty() ? "x at forcing phase 0 (dimensionless)" : up;
  std::map<std::string, std::size_t> colours;  // by branch, in order of appearance
  std::map<std::string, bool> titled;
  std::set<std::string> branches;
  for (const auto& row : table.rows) branches.insert(row[branch]);
  const bool by_period = branches.size() > most_branch_colours;
  std::string last_branch;
  std::array<double, 3> last{};
  for (const auto& row : table.rows) {
    const std::string& id = row[branch];
    const std::string colour = by_period ? colour_of_period(parse_count(row[period]).value_or(0))
                                         : colour_of(colours.try_emplace(id, colours.size()).first->second);
    const std::array<double, 3> here = {number(row, value), number(row, x), 0.0};
    const bool special = !row[label].empty();
    if (special) picture.labels.push_back({here[0], here[1], row[label], mark_of_type(row[label].substr(0, 2)), colour});
    const Stroke stroke = row[admissible] == "no" ? Stroke::dotted : row[stable] == "no" ? Stroke::dashed : Stroke::solid;
    const bool goes_on = id == last_branch && !picture.curves.empty();
    // A special point ends one stroke and begins the next; its own stability belongs to neither.
    if (!goes_on || (!special && picture.curves.back().stroke != stroke)) {
      Curve curve;
      curve.stroke = stroke;
      curve.colour = colour;
      curve.size = by_period ? 1.5 : 2.5;
      const char* name = stroke == Stroke::solid ? "stable" : stroke == Stroke::dashed ? "unstable" : "not admissible";
      const std::string title =
          fmt::format("{}period {}, {}", by_period ? "" : fmt::format("branch {}: ", id), row[period], name);
      if (!titled[title]) curve.title = title;
      titled[title] = true;
      if (goes_on) curve.points.push_back(last);
      picture.curves.push_back(std::move(curve));
    }
    picture.curves.back().points.push_back(here);
    last = here;
    last_branch = id;
  }
  return picture;
}

/// Whether the table has the form of `graze trajectory --csv`.
bool is_trajectory(const Table& table) { return table.columns == Names{"tau", "x", "v"}; }

/// Whether v jumps between a row and the previous one, as at a hard impact: it changes by far more than in the adjacent steps.
bool jumps_at(const Table& table, std::size_t row) {
  const auto change = [&](std::size_t i) {
    return i >= 1 && i < table.rows.size() ? std::abs(number(table.rows[i], 2) - number(table.rows[i - 1], 2)) : 0.0;
  };
  return table.rows.size() > 3 && row >= 1 && change(row) > 5.0 * std::max(change(row - 1), change(row + 1));
}

/// The error that a table cannot be drawn. `tried`: the columns that could be drawn if they had numbers.
std::invalid_argument not_two_columns(const Table& table, const std::vector<std::size_t>& tried) {
  const std::string needed = "a picture needs two columns of numbers; ";
  if (tried.empty()) return std::invalid_argument(needed + fmt::format("the table has only {}", fmt::join(table.columns, ", ")));
  const std::string& cell = table.rows.front()[tried.front()];
  return std::invalid_argument(
      needed + fmt::format("{} {} in row 1", table.columns[tried.front()], cell.empty() ? "is empty" : "has text"));
}

/// The numbers of several columns. A line ends where another branch, orbit or direction begins, and where v of a trajectory
/// jumps.
Picture draw_columns(const Table& table, const std::string& x, const Names& y) {
  const auto numeric = [&](std::size_t i) {
    return std::any_of(table.rows.begin(), table.rows.end(), [&](const auto& row) { return std::isfinite(number(row, i)); });
  };
  std::optional<std::size_t> part;
  for (const char* name : {"branch", "orbit", "direction"})
    if (!part && has(table, name)) part = column(table, name);
  std::size_t across = 0;
  while (across + 1 < table.columns.size() && (!numeric(across) || across == part)) ++across;
  if (!x.empty()) across = column(table, x);
  std::vector<std::size_t> chosen(y.size());
  std::transform(y.begin(), y.end(), chosen.begin(), [&](const std::string& name) { return column(table, name); });
  if (y.empty())
    for (std::size_t i = 0; i < table.columns.size(); ++i)
      if (i != across && i != part && numeric(i)) chosen.push_back(i);
  Names names;
  for (const std::size_t i : chosen) names.push_back(table.columns[i]);
  if (!numeric(across) || std::none_of(chosen.begin(), chosen.end(), numeric)) {
    std::vector<std::size_t> tried(chosen);
    for (std::size_t i = 0; y.empty() && i < table.columns.size(); ++i)
      if (i != across && i != part) tried.push_back(i);
    if (!numeric(across)) tried.insert(x.empty() ? tried.end() : tried.begin(), across);
    throw not_two_columns(table, tried);
  }
  Picture picture;
  picture.x_label = table.columns.at(across);
  picture.y_label = names.size() <= 4 ? fmt::format("{}", fmt::join(names, ", ")) : fmt::format("{} columns", names.size());
  const double none = std::nan("");
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    Curve curve;
    curve.title = names[k];
    curve.colour = colour_of(k);
    const std::string* last = nullptr;
    const bool of_v = is_trajectory(table) && (table.columns[across] == "v" || names[k] == "v");
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
      const auto& row = table.rows[i];
      if ((part && last && row[*part] != *last) || (of_v && jumps_at(table, i))) curve.points.push_back({none, none, none});
      if (part) last = &row[*part];
      curve.points.push_back({number(row, across), number(row, chosen[k]), 0.0});
    }
    picture.curves.push_back(std::move(curve));
  }
  return picture;
}

/// The range of an axis that shows a column. @throws std::invalid_argument if the column has no numbers.
std::array<double, 2> axis(const Range& range, const std::string& column) {
  if (range.empty()) throw std::invalid_argument(fmt::format("there is nothing to draw: the column {} has no numbers", column));
  return range.with_margin(0.02);
}

/// Whether the table has the form of `graze sweep --csv`: the parameter comes first.
bool is_sweep(const Table& table) {
  const Names rest = {"direction", "attractor", "period", "impacts", "exponent1", "exponent2", "x", "v"};
  return !table.columns.empty() && Names(table.columns.begin() + 1, table.columns.end()) == rest;
}

Picture draw_sweep(const Table& table) {
  const std::size_t direction = column(table, "direction"), x = column(table, "x");
  Picture picture;
  picture.title = "Attractors";
  picture.x_label = table.columns.front() + " (dimensionless)";
  picture.y_label = "x at forcing phase 0 (dimensionless)";
  std::map<std::string, std::vector<std::array<double, 3>>> states;
  Range range;
  for (const auto& row : table.rows) {
    const double value = number(row, 0);
    range.take(value);
    states[row[direction]].push_back({value, number(row, x), 0.0});
  }
  picture.x_range = axis(range, table.columns.front());
  add_sweep_dots(picture, states);
  return picture;
}

/// Whether the table has the form of `graze attractors --csv`.
bool is_starts(const Table& table) { return table.columns == Names{"x", "v", "attractor", "type", "period", "impacts"}; }

Picture draw_starts(const Table& table) {
  const std::size_t attractor = column(table, "attractor"), type = column(table, "type"), period = column(table, "period"),
                    impacts = column(table, "impacts");
  Picture picture;
  picture.title = "Starts by the attractor they reach";
  picture.x_label = "x at forcing phase 0 (dimensionless)";
  picture.y_label = "x' at forcing phase 0 (dimensionless)";
  std::map<int, std::string> titles;  // by colour
  std::vector<std::array<double, 2>> starts;
  std::vector<int> colour;
  Range x, v;
  for (const auto& row : table.rows) {
    starts.push_back({number(row, 0), number(row, 1)});
    x.take(starts.back()[0]);
    v.take(starts.back()[1]);
    const int id = parse_count(row[attractor]).value_or(0);
    if (id > static_cast<std::ptrdiff_t>(table.rows.size()))
      throw std::invalid_argument(
          fmt::format("attractor {} in a table of {} starts; the attractors are numbered from 1", id, table.rows.size()));
    // 0 is for lost motions; starts beyond the barrier and those that were not run get no dot.
    colour.push_back(id > 0 || row[type] == "lost" ? id : -1);
    if (colour.back() < 0) continue;
    titles[id] = row[period].empty() ? row[type] : fmt::format("z = {}/{}", row[impacts], row[period]);
    if (id > 0) titles[id] = fmt::format("attractor {}: {}", id, titles[id]);
  }
  picture.x_range = axis(x, "x");
  picture.y_range = axis(v, "v");
  std::vector<std::string> colours = {lost_colour};
  for (int id = 1; !titles.empty() && id <= titles.rbegin()->first; ++id)
    colours.push_back(colour_of(static_cast<std::size_t>(id - 1)));
  add_start_dots(picture, starts, colour, colours);
  for (const auto& [id, title] : titles) picture.curves.push_back(legend_entry(title, colours[static_cast<std::size_t>(id)]));
  return picture;
}

/// Whether the table has the form of `graze map --csv`.
bool is_map(const Table& table) {
  for (const char* name : {"layer", "type", "period", "impacts", "lambda_1", "standard_error"})
    if (!has(table, name)) return false;
  return true;
}

}  // namespace

Picture picture_of(const Table& table, const std::string& x, const std::vector<std::string>& y) {
  if (table.rows.empty()) throw std::invalid_argument("there is nothing to draw: the table is a header without rows");
  const bool choice = !x.empty() || !y.empty();
  if (is_branches(table) && (!choice || y.size() == 1)) return draw_branches(table, x, choice ? y.front() : "");
  if (!choice && is_map(table))
    throw std::invalid_argument(
        "this is the table of a map, which is drawn from its .h5 or .json; give one of these, or name columns by --x and --y");
  if (!choice && is_sweep(table)) return draw_sweep(table);
  if (!choice && is_starts(table)) return draw_starts(table);
  Picture picture = draw_columns(table, x, y);
  // Points of a section or of an attractor follow each other in time, but lines between them would have no meaning.
  const bool section = table.columns == Names{"x", "v"} || table.columns == Names{"phase", "speed"};
  if (!section && !is_sweep(table) && !is_starts(table)) return picture;
  for (Curve& curve : picture.curves) {
    curve.stroke = Stroke::dots;
    curve.size = table.rows.size() > 5000 ? 0.15 : table.rows.size() > 500 ? 0.35 : 0.8;
    if (section && !choice) curve.title.clear();
  }
  if (section && !choice) picture.title = "Poincaré section";
  return picture;
}

}  // namespace graze::apps
