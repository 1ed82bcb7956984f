// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of CSV tables: graze's own, known by their header, and any other.
#include <graze/apps/number.hpp>
#include <graze/apps/pictures/pictures.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

namespace graze::apps {

namespace {

using Columns = std::vector<std::string>;

std::size_t column(const Table& table, const std::string& name) {
  const auto found = std::find(table.columns.begin(), table.columns.end(), name);
  if (found == table.columns.end()) throw std::invalid_argument(unknown_name("column", name, table.columns));
  return static_cast<std::size_t>(found - table.columns.begin());
}

bool has(const Table& table, const std::string& name) {
  return std::find(table.columns.begin(), table.columns.end(), name) != table.columns.end();
}

double number(const std::vector<std::string>& row, std::size_t i) { return parse_number(row[i]).value_or(std::nan("")); }

/// A table as `graze continue --csv` writes it: the parameter stands between "impacts" and "x".
bool is_branches(const Table& table) {
  for (const char* name : {"branch", "label", "period", "impacts", "x", "stable", "admissible"})
    if (!has(table, name)) return false;
  return column(table, "x") == column(table, "impacts") + 2;
}

Picture draw_branches(const Table& table) {
  const std::size_t branch = column(table, "branch"), label = column(table, "label"), period = column(table, "period"),
                    x = column(table, "x"), value = x - 1, stable = column(table, "stable"),
                    admissible = column(table, "admissible");
  Picture picture;
  picture.title = "Periodic orbits";
  picture.x_label = table.columns[value] + " (dimensionless)";
  picture.y_label = "x at forcing phase 0 (dimensionless)";
  std::map<std::string, std::size_t> colours;  // by branch, in the order in which they come
  std::map<std::string, bool> titled;
  std::string last_branch;
  std::array<double, 3> last{};
  for (const auto& row : table.rows) {
    const std::string& id = row[branch];
    const std::string colour = colour_of(colours.try_emplace(id, colours.size()).first->second);
    const std::array<double, 3> here = {number(row, value), number(row, x), 0.0};
    const bool special = !row[label].empty();
    if (special) picture.labels.push_back({here[0], here[1], row[label], 7, colour});
    const Stroke stroke = row[admissible] == "no" ? Stroke::dotted : row[stable] == "no" ? Stroke::dashed : Stroke::solid;
    const bool goes_on = id == last_branch && !picture.curves.empty();
    // A special point ends one stroke and begins the next; its own stability is that of neither.
    if (!goes_on || (!special && picture.curves.back().stroke != stroke)) {
      Curve curve;
      curve.stroke = stroke;
      curve.colour = colour;
      curve.size = 2.5;
      const char* name = stroke == Stroke::solid ? "stable" : stroke == Stroke::dashed ? "unstable" : "not admissible";
      const std::string title = fmt::format("branch {}: period {}, {}", id, row[period], name);
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

/// The numbers of several columns; a line ends where another branch, orbit or direction begins.
Picture draw_columns(const Table& table, const std::string& x, const Columns& y) {
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
  Columns names;
  for (const std::size_t i : chosen) names.push_back(table.columns[i]);
  const bool drawable = numeric(across) && std::any_of(chosen.begin(), chosen.end(), numeric);
  if (!drawable)
    throw std::invalid_argument(
        fmt::format("there is nothing to draw: of {}, one column of numbers and another against it are needed",
                    fmt::join(table.columns, ", ")));
  Picture picture;
  picture.x_label = table.columns.at(across);
  picture.y_label = names.size() <= 4 ? fmt::format("{}", fmt::join(names, ", ")) : fmt::format("{} columns", names.size());
  const double none = std::nan("");
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    Curve curve;
    curve.title = names[k];
    curve.colour = colour_of(k);
    const std::string* last = nullptr;
    for (const auto& row : table.rows) {
      if (part && last && row[*part] != *last) curve.points.push_back({none, none, none});
      if (part) last = &row[*part];
      curve.points.push_back({number(row, across), number(row, chosen[k]), 0.0});
    }
    picture.curves.push_back(std::move(curve));
  }
  return picture;
}

/// A table as `graze map --csv` writes it.
bool is_map(const Table& table) {
  for (const char* name : {"layer", "type", "period", "impacts", "lambda_1", "standard_error"})
    if (!has(table, name)) return false;
  return true;
}

}  // namespace

Picture picture_of(const Table& table, const std::string& x, const std::vector<std::string>& y) {
  if (table.rows.empty()) throw std::invalid_argument("there is nothing to draw: the table is a header without rows");
  const bool choice = !x.empty() || !y.empty();
  if (!choice && is_branches(table)) return draw_branches(table);
  if (!choice && is_map(table))
    throw std::invalid_argument(
        "this is the table of a map, which is drawn from its .h5 or .json; give one of these, or name columns by --x and --y");
  Picture picture = draw_columns(table, x, y);
  // Points of a section follow each other in time, but lines between them mean nothing.
  if (!choice && (table.columns == Columns{"x", "v"} || table.columns == Columns{"phase", "speed"})) {
    picture.title = "Poincaré section";
    picture.curves.front().stroke = Stroke::dots;
    picture.curves.front().size = table.rows.size() > 5000 ? 0.15 : table.rows.size() > 500 ? 0.35 : 0.8;
    picture.curves.front().title.clear();
  }
  return picture;
}

}  // namespace graze::apps
