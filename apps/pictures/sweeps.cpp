// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of graze.sweep/1: stroboscopic states against the parameter, and the exponents.
#include <graze/apps/pictures/pictures.hpp>

#include <algorithm>
#include <cmath>
#include <map>

namespace graze::apps {

namespace {

Picture frame(const Json& result, const std::string& title, const std::string& y_label) {
  Picture picture;
  picture.title = title;
  picture.subtitle = model_title(result, result.at("parameter"));
  picture.x_label = result.at("parameter").get<std::string>() + " (dimensionless)";
  picture.y_label = y_label;
  const Json& options = result.at("options");
  picture.x_range = {{options.at("from").get<double>(), options.at("to").get<double>()}};
  return picture;
}

Picture draw_states(const Json& result) {
  Picture picture = frame(result, "Attractors", "x at forcing phase 0 (dimensionless)");
  std::map<std::string, Curve> curves;
  for (const Json& row : result.at("rows")) {
    const std::string direction = row.at("direction");
    Curve& curve = curves[direction];
    curve.title = "sweep " + direction;
    curve.stroke = Stroke::dots;
    curve.colour = direction == "up" ? colour_of(0) : colour_of(1);
    curve.size = 0.25;
    for (const Json& state : row.at("states")) curve.points.push_back({row.at("value"), state.at(0), 0.0});
  }
  for (auto& [direction, curve] : curves) picture.curves.push_back(std::move(curve));
  return picture;
}

Picture draw_exponents(const Json& result) {
  Picture picture = frame(result, "Lyapunov exponents", "exponent (per unit of dimensionless time)");
  std::map<std::string, std::vector<Curve>> curves;
  for (const Json& row : result.at("rows")) {
    const std::string direction = row.at("direction");
    std::vector<Curve>& list = curves[direction];
    const Json& exponents = row.at("exponents");
    if (list.size() < exponents.size()) list.resize(exponents.size());
    for (std::size_t i = 0; i < exponents.size(); ++i) {
      Curve& curve = list[i];
      curve.title = "exponent " + std::to_string(i + 1) + ", sweep " + direction;
      curve.colour = colour_of(2 * i + (direction == "up" ? 0 : 1));
      curve.size = 1.5;
      curve.points.push_back({row.at("value"), exponents[i].is_null() ? NAN : exponents[i].get<double>(), 0.0});
    }
  }
  for (auto& [direction, list] : curves)
    for (Curve& curve : list) picture.curves.push_back(std::move(curve));
  picture.barriers.push_back({false, 0.0, "", false});
  return picture;
}

/// The attractors above their exponents, on one axis.
Picture draw_diagram(const Json& result) {
  Picture picture = draw_states(result), exponents = draw_exponents(result);
  picture.title = "Attractors and their Lyapunov exponents";
  exponents.title.clear();
  exponents.subtitle.clear();
  picture.below.push_back(std::move(exponents));
  return picture;
}

}  // namespace

PictureKind sweep_diagram_picture() {
  return {"graze.sweep/1", "diagram", "stroboscopic states above the exponents, against the parameter", draw_diagram, {}};
}

PictureKind sweep_picture() {
  return {"graze.sweep/1", "states", "stroboscopic states of the attractors against the parameter", draw_states, {}};
}

PictureKind exponents_picture() {
  return {"graze.sweep/1", "exponents", "Lyapunov exponents against the parameter", draw_exponents, {}};
}

}  // namespace graze::apps
