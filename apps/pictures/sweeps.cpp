// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of graze.sweep/1: stroboscopic states against the parameter, and the exponents.
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/pictures/range.hpp>

#include <algorithm>
#include <cmath>
#include <map>

namespace graze::apps {

namespace {

std::array<double, 2> range_of(const Json& result) {
  const double from = result.at("options").at("from"), to = result.at("options").at("to");
  return {std::min(from, to), std::max(from, to)};
}

Picture frame(const Json& result, const std::string& title, const std::string& y_label) {
  Picture picture;
  picture.title = title;
  picture.subtitle = model_title(result, result.at("parameter"));
  picture.x_label = parameter_label(result, result.at("parameter"));
  picture.y_label = y_label;
  picture.x_range = range_of(result);
  return picture;
}

bool has_rows(const Json& result) { return !result.at("rows").empty(); }

Picture draw_states(const Json& result) {
  Picture picture = frame(result, "Attractors", state_label(result, 0, true));
  std::map<std::string, std::vector<std::array<double, 3>>> states;
  for (const Json& row : result.at("rows"))
    for (const Json& state : row.at("states")) states[row.at("direction")].push_back({row.at("value"), state.at(0), 0.0});
  add_sweep_dots(picture, states);
  return picture;
}

/// The colour tells the directions apart, its intensity the first exponent from the others.
std::string exponent_colour(const std::string& direction, std::size_t exponent) {
  static const std::vector<std::string> up = {"#1f77b4", "#9ecae1", "#6a51a3", "#bcbddc", "#238b45", "#a1d99b"};
  static const std::vector<std::string> down = {"#d95f02", "#fdc08a", "#a50f15", "#fcae91", "#7f5f00", "#e7cb94"};
  return direction == "up" ? up[exponent % up.size()] : down[exponent % down.size()];
}

/// The finite exponents.
Range range_of_exponents(const Json& result) {
  Range range;
  for (const Json& row : result.at("rows"))
    for (const Json& exponent : row.at("exponents"))
      if (exponent.is_number()) range.take(exponent.get<double>());
  return range;
}

/// Adds marks at the lower edge where the first exponent is -infinity because the motion sticks.
void add_sticking_marks(Picture& picture, const Json& result, double lowest) {
  Curve marks{.title = "exponent 1 is -infinity", .stroke = Stroke::marks, .colour = "#a0127d", .size = 0.8, .mark = 11};
  for (const Json& row : result.at("rows")) {
    const Json& exponents = row.at("exponents");
    if (!exponents.empty() && exponents[0].is_null())
      marks.points.push_back({row.at("value"), 1.05 * std::min(-0.1, lowest), 0.0});
  }
  if (!marks.points.empty()) picture.curves.push_back(std::move(marks));
}

Picture exponents_within(const Json& result, const std::array<double, 2>& x_range) {
  Picture picture = frame(result, "Lyapunov exponents", exponent_label(result));
  picture.x_range = x_range;
  picture.legend_columns = 2;
  if (!result.at("rows").empty())
    picture.curves.push_back({"", Stroke::solid, "#555555", 1.0, 0, {{x_range[0], 0.0, 0.0}, {x_range[1], 0.0, 0.0}}});
  std::map<std::string, std::vector<Curve>> curves;
  for (const Json& row : result.at("rows")) {
    const std::string direction = row.at("direction");
    std::vector<Curve>& list = curves[direction];
    const Json& exponents = row.at("exponents");
    if (list.size() < exponents.size()) list.resize(exponents.size());
    for (std::size_t i = 0; i < exponents.size(); ++i) {
      Curve& curve = list[i];
      curve.title = "exponent " + std::to_string(i + 1) + ", sweep " + direction;
      curve.colour = exponent_colour(direction, i);
      curve.size = direction == "up" ? 1.3 : 3.0;  // both are visible where they coincide
      curve.points.push_back({row.at("value"), exponents[i].is_null() ? NAN : exponents[i].get<double>(), 0.0});
    }
  }
  const Range range = range_of_exponents(result);
  add_sticking_marks(picture, result, range.low);
  // An exponent that is zero all along lies on the axis, not under the frame.
  constexpr double margin = 0.08;
  if (range.low < 0.0 && std::abs(range.high) < -margin * range.low)
    picture.y_range = {{(1.0 + margin) * range.low, -margin * range.low}};
  std::size_t most = 0;
  for (const auto& [direction, list] : curves) most = std::max(most, list.size());
  for (std::size_t i = most; i-- > 0;)  // the first exponent over the others
    for (auto& [direction, list] : curves)
      if (i < list.size()) picture.curves.push_back(std::move(list[i]));
  return picture;
}

Picture draw_exponents(const Json& result) { return exponents_within(result, range_of(result)); }

/// The attractors above their exponents, on a common axis.
Picture draw_sweep_above_exponents(const Json& result) {
  Picture picture = draw_states(result);
  picture.title = "Attractors and their Lyapunov exponents";
  picture.below.push_back(exponents_below(result, range_of(result)));
  return picture;
}

}  // namespace

void add_sweep_dots(Picture& picture, const std::map<std::string, std::vector<std::array<double, 3>>>& states) {
  // If both directions agree, the wider band of "down" is visible beside "up", which is drawn later.
  std::vector<Curve> curves;
  for (const auto& [direction, points] : states) {
    if (points.empty()) continue;
    const bool wide = direction != "up" && states.size() > 1;
    curves.push_back({.stroke = Stroke::dots, .colour = direction == "up" ? "#1f77b4" : "#fdae6b", .size = wide ? 0.5 : 0.25});
    curves.back().points = points;
    Curve entry = legend_entry("sweep " + direction, curves.back().colour);  // dots this fine would be invisible in the legend
    entry.stroke = Stroke::dots;
    entry.size = 1.2;
    entry.points = {{1e30, points.front()[1], 0.0}};  // far only in x: the range of x is given, that of y is not
    picture.curves.push_back(std::move(entry));
  }
  for (Curve& curve : curves) picture.curves.push_back(std::move(curve));
}

Picture exponents_below(const Json& result, const std::array<double, 2>& x_range) {
  Picture picture = exponents_within(result, x_range);
  picture.title.clear();
  picture.subtitle.clear();
  return picture;
}

PictureKind sweep_diagram_picture() {
  return {"graze.sweep/1",
          "diagram",
          "stroboscopic states above the exponents, against the parameter",
          draw_sweep_above_exponents,
          {},
          has_rows,
          true};
}

PictureKind sweep_picture() {
  return {"graze.sweep/1", "states", "stroboscopic states of the attractors against the parameter", draw_states, {},
          has_rows,        true};
}

PictureKind exponents_picture() {
  return {"graze.sweep/1", "exponents", "Lyapunov exponents against the parameter", draw_exponents, {}, has_rows};
}

}  // namespace graze::apps
