// SPDX-License-Identifier: GPL-3.0-or-later
// Picture of graze.branch/1 as a whole: every branch in the colour of its period, special points marked by type, z along
// branches.
#include <graze/apps/number.hpp>
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/pictures/skeleton.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace graze::apps {

namespace {

/// Longer periods have more and closer curves.
double width_of(int period, Stroke stroke) {
  const double stable = period <= 2 ? 3.0 : period <= 4 ? 2.4 : 1.8;
  return stroke == Stroke::solid ? stable : stroke == Stroke::dotted ? 1.6 : period <= 4 ? 1.5 : 0.9;
}

std::string type_words(const std::string& type) {
  static const std::map<std::string, std::string> words = {
      {"PD", "PD, period doubling"}, {"LP", "LP, fold"},       {"GR", "GR, grazing"},      {"BP", "BP, branch point"},
      {"NS", "NS, Neimark-Sacker"},  {"UZ", "UZ, user value"}, {"MX", "MX, not converged"}};
  const auto found = words.find(type);
  return found == words.end() ? type : found->second;
}

Picture draw_skeleton(const Json& result) { return skeleton_of(result, "Skeleton of periodic orbits", false); }

}  // namespace

void SkeletonAxes::take_in(double at_x, double at_y) {
  x = {std::min(x[0], at_x), std::max(x[1], at_x)};
  y = {std::min(y[0], at_y), std::max(y[1], at_y)};
}

void SkeletonAxes::take_in(const SkeletonCurves& parts) {
  for (const auto& [key, points] : parts.curves)
    for (const SkeletonCurves::Point& point : points)
      if (!std::isnan(point[0])) take_in(point[0], point[1]);
}

void SkeletonAxes::add_margins(const SkeletonCurves& parts) {
  const double aside = 0.01 * std::max(x[1] - x[0], 1e-9), above = 0.08 * std::max(y[1] - y[0], 1e-6);
  x = {x[0] - aside, x[1] + aside};
  // Above, where the largest iterates are, their names need room.
  y = {y[0] - above, y[1] + (parts.named.size() > 6 ? 3.0 : 1.5) * above};
}

Curve legend_line(const SkeletonAxes& axes, const std::string& title, Stroke stroke, const std::string& colour, double size) {
  Curve curve;
  curve.title = title;
  curve.stroke = stroke;
  curve.colour = colour;
  curve.size = size;
  curve.points = {{axes.x[1] + 1.0, axes.y[1] + 1.0, 0.0}};
  return curve;
}

std::vector<Curve> skeleton_legend(const SkeletonCurves& parts, const SkeletonAxes& axes, double widths) {
  std::vector<Curve> list;
  std::set<int> periods;
  std::set<Stroke> strokes;
  for (const auto& [key, points] : parts.curves) {
    periods.insert(key.first);
    strokes.insert(key.second);
  }
  for (const int period : periods)
    list.push_back(legend_line(axes, fmt::format("period {}", period), Stroke::solid, colour_of_period(period), widths * 3.0));
  for (const Stroke stroke : strokes)
    list.push_back(legend_line(axes, stroke_name(stroke), stroke, "#555555", widths * width_of(1, stroke)));
  for (const auto& [type, mark] : parts.mark_types) {
    list.push_back(legend_line(axes, type_words(type), Stroke::marks, mark_colour, 1.1));
    list.back().mark = mark;
  }
  return list;
}

double legend_rows(std::size_t entries) {
  const auto rows = static_cast<double>((entries + 2) / 3);
  return (rows > 5.0 ? 0.9 : rows > 4.0 ? 1.05 : 1.25) * rows;
}

void add_skeleton(Picture& picture, const Json& result, const SkeletonCurves& parts, const SkeletonAxes& axes, double widths,
                  const std::vector<Curve>& samples) {
  // Short periods over long ones, stable over unstable.
  for (const Stroke stroke : {Stroke::dotted, Stroke::dashed, Stroke::solid})
    for (auto entry = parts.curves.rbegin(); entry != parts.curves.rend(); ++entry) {
      if (entry->first.second != stroke) continue;
      Curve curve;
      curve.stroke = stroke;
      curve.colour = colour_of_period(entry->first.first);
      curve.size = widths * width_of(entry->first.first, stroke);
      curve.points = entry->second;
      picture.curves.push_back(std::move(curve));
    }
  SkeletonWords words = skeleton_words(result, parts, axes, picture.barriers, samples);
  picture.labels.insert(picture.labels.end(), words.labels.begin(), words.labels.end());
  picture.curves.push_back(std::move(words.leaders));
  for (const auto& [key, points] : parts.marks) {
    Curve curve;
    curve.stroke = Stroke::marks;
    curve.mark = parts.mark_types.at(key.first);
    curve.colour = mark_colour;
    curve.size = key.second ? 0.45 : 0.9;
    curve.points = points;
    picture.curves.push_back(std::move(curve));
  }
  picture.subtitle += "\nalong the branches: z = impacts/periods";
  if (words.without > 0) picture.subtitle += fmt::format("; {} special points are marked without their labels", words.without);
}

Picture skeleton_of(const Json& result, const std::string& title, bool values) {
  Picture picture;
  const std::string parameter = result.at("parameter");
  picture.title = title;
  picture.subtitle = model_title(result, parameter);
  picture.x_label = parameter + " (dimensionless)";
  picture.y_label = "x at forcing phase 0 (dimensionless)";
  SkeletonCurves parts = skeleton_curves(result);
  if (values)
    for (SkeletonCurves::Named& point : parts.named) point.label += " " + rounded(point.value, 8);
  if (parts.curves.empty()) return picture;
  SkeletonAxes axes;
  axes.take_in(parts);
  axes.add_margins(parts);
  axes.rows = 27.0 - legend_rows(skeleton_legend(parts, axes, 1.0).size());
  picture.x_range = axes.x;
  picture.y_range = axes.y;
  picture.curves = skeleton_legend(parts, axes, 1.0);
  add_skeleton(picture, result, parts, axes, 1.0);
  return picture;
}

PictureKind skeleton_picture() {
  return {"graze.branch/1", "skeleton", "all branches in the colours of their periods, with special points and z along them",
          draw_skeleton,    "diagram",  has_branches};
}

}  // namespace graze::apps
