// SPDX-License-Identifier: GPL-3.0-or-later
// Picture of graze.diagram/1: the sweeps' samples under the skeleton of branches, and the exponents below on the same axis.
#include <graze/apps/pictures/branch_curves.hpp>
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/pictures/skeleton.hpp>

#include <algorithm>

namespace graze::apps {

namespace {

constexpr double branch_widths = 0.6;  // thin, so that the sweeps are visible on both sides
constexpr double upper_height = 1.6, lower_height = 0.85;
constexpr double upper_lines = 35.0;  // lines of text in the height of the upper axes, without title and legend

const char* sweep_colour(const std::string& direction) { return direction == "up" ? "#86aede" : "#dba678"; }

/// States of the sweeps: periodic ones as bands visible on both sides of their branch, others as fine dots.
std::vector<Curve> samples_of(const Json& result) {
  std::vector<Curve> list;
  for (const bool periodic : {false, true})
    for (const char* direction : {"down", "up"}) {  // if both agree, the wider band of "down" is visible beside "up"
      Curve curve;
      curve.stroke = Stroke::dots;
      curve.colour = sweep_colour(direction);
      curve.size = !periodic ? 0.2 : direction == std::string("up") ? 0.6 : 1.0;
      for (const Json& row : result.at("rows")) {
        if (row.at("direction") != direction || (row.at("attractor").at("type") == "periodic") != periodic) continue;
        for (const Json& state : row.at("states")) curve.points.push_back({row.at("value"), state.at(0), 0.0});
      }
      if (!curve.points.empty()) list.push_back(std::move(curve));
    }
  return list;
}

Picture draw_diagram(const Json& result) {
  Picture picture;
  const std::string parameter = result.at("parameter");
  picture.title = "Sweeps, branches of periodic orbits, and Lyapunov exponents";
  picture.subtitle = model_title(result, parameter);
  picture.x_label = parameter_label(result, parameter);
  picture.y_label = state_label(result, 0, true);
  picture.height = upper_height;
  const SkeletonCurves parts = skeleton_curves(result);
  const std::vector<Curve> samples = samples_of(result);
  SkeletonAxes axes;
  axes.take_in(parts);
  for (const Curve& curve : samples)
    for (const auto& point : curve.points) axes.take_in(point[0], point[1]);
  if (axes.x[0] > axes.x[1]) return picture;
  axes.add_margins(parts);
  picture.x_range = axes.x;
  picture.y_range = axes.y;
  for (const char* direction : {"up", "down"})
    if (std::any_of(samples.begin(), samples.end(), [&](const Curve& curve) { return curve.colour == sweep_colour(direction); }))
      picture.curves.push_back(legend_line(axes, std::string("sweep ") + direction, Stroke::dots, sweep_colour(direction), 1.0));
  for (Curve& line : skeleton_legend(parts, axes, branch_widths)) picture.curves.push_back(std::move(line));
  for (const Barrier& barrier : barriers_of(result, 0, false))
    if (axes.y[0] < barrier.position && barrier.position < axes.y[1]) picture.barriers.push_back(barrier);
  axes.rows = upper_lines - 5.0 - legend_rows(picture.curves.size() + picture.barriers.size());
  picture.curves.insert(picture.curves.end(), samples.begin(), samples.end());
  add_skeleton(picture, result, parts, axes, branch_widths, samples);
  if (result.at("rows").empty()) return picture;
  picture.below.push_back(exponents_below(result, axes.x));
  picture.below.back().height = lower_height;
  return picture;
}

}  // namespace

PictureKind diagram_picture() {
  return {"graze.diagram/1",
          "diagram",
          "samples of the sweeps under the branches, above the exponents, against the parameter",
          draw_diagram,
          {},
          [](const Json& result) { return has_branches(result) || !result.at("rows").empty(); },
          true};
}

}  // namespace graze::apps
