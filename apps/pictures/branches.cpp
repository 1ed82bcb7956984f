// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of graze.branch/1: the state against the parameter, and the multipliers against the unit circle.
#include <graze/apps/pictures/branch_curves.hpp>
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/pictures/skeleton.hpp>
#include <graze/apps/text/number.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <string>
#include <vector>

namespace graze::apps {

namespace {

/// Whether a multiplier of the point lies on the unit circle.
bool has_critical_multiplier(const Json& point) {
  const std::string type = point.at("type");
  return type == "PD" || type == "LP" || type == "BP" || type == "NS";
}

Picture draw_branches(const Json& result) {
  const std::string x_label = parameter_label(result, result.at("parameter"));
  if (result.at("branches").size() > most_branch_colours) return skeleton_of(result, "Periodic orbits", true);
  Picture picture;
  picture.title = "Periodic orbits";
  picture.subtitle = model_title(result, result.at("parameter"));
  picture.x_label = x_label;
  picture.y_label = state_label(result, 0, true);
  for (std::size_t b = 0; b < result.at("branches").size(); ++b) {
    const Json& branch = result.at("branches").at(b);
    const std::vector<Drawn> points = points_in_order(branch);
    std::map<Stroke, bool> titled;
    for (std::size_t k = 0; !points.empty() && k < positions(*points.front().point).size(); ++k)
      for (Curve& curve : curves_of(points, k)) {
        curve.colour = colour_of(b);
        curve.size = 2.5;
        if (!titled[curve.stroke])
          curve.title = fmt::format("branch {}: period {}, {}", branch.at("id").dump(), branch.at("period").dump(),
                                    stroke_name(curve.stroke));
        titled[curve.stroke] = true;
        picture.curves.push_back(std::move(curve));
      }
    for (const Json& point : branch.at("special_points")) {
      if (!is_marked(point)) continue;
      std::string text = fmt::format("{} {}", point.at("label").get<std::string>(), rounded(point.at("value"), 8));
      for (const double x : positions(point)) {
        picture.labels.push_back({point.at("value"), x, text, mark_of(point), colour_of(b)});
        text.clear();  // the other iterates are marked without words
      }
    }
  }
  // The parameter's range ends with the branches; above and below there is room for the labels.
  std::array<double, 2> x = {HUGE_VAL, -HUGE_VAL}, y = x;
  for (const Curve& curve : picture.curves)
    for (const auto& point : curve.points) {
      x = {std::min(x[0], point[0]), std::max(x[1], point[0])};
      y = {std::min(y[0], point[1]), std::max(y[1], point[1])};
    }
  if (x[0] < x[1]) picture.x_range = x;
  const double size = std::max(std::abs(y[0]), std::abs(y[1]));
  const bool flat = y[1] - y[0] <= 1e-9 * size;  // such as the largest x of a mass that reaches its stop
  const double margin = 0.08 * (flat ? size : std::max(y[1] - y[0], 1e-6));
  if (y[0] <= y[1]) picture.y_range = {{y[0] - margin, y[1] + margin}};
  return picture;
}

/// Special points with their critical multiplier in one place: all doublings at -1, all folds at 1.
struct CriticalPoint {
  double re, im;
  int mark;
  std::vector<std::string> names;
};

/// The mark stands at the critical multiplier: the one nearest to the unit circle.
void add_critical(std::vector<CriticalPoint>& list, const Json& point) {
  const Json* critical = nullptr;
  double distance = 0.0;
  for (const Json& mu : point.at("multipliers")) {
    const double d = std::abs(std::hypot(mu.at(0).get<double>(), mu.at(1).get<double>()) - 1.0);
    if (!critical || d < distance) {
      critical = &mu;
      distance = d;
    }
  }
  if (!critical) return;
  const double re = critical->at(0), im = critical->at(1);
  const int mark = mark_of(point);
  const auto same = std::find_if(list.begin(), list.end(), [&](const CriticalPoint& other) {
    return other.mark == mark && std::hypot(other.re - re, other.im - im) < 0.03;
  });
  if (same == list.end())
    list.push_back({re, im, mark, {point.at("label")}});
  else
    same->names.push_back(point.at("label"));
}

Curve multiplier_curve(std::size_t series, const std::string& title) {
  static constexpr int marks[] = {7, 5, 9, 13, 11, 15, 6, 4, 8, 12, 10, 14, 1, 2, 3};
  Curve curve;
  curve.title = title;
  curve.stroke = Stroke::marks;
  curve.mark = marks[series % std::size(marks)];
  curve.size = 0.8;
  curve.coloured = true;
  return curve;
}

Picture draw_multipliers(const Json& result) {
  constexpr double farthest = 2.5;  // beyond it, the unit circle would shrink to a dot
  Picture picture;
  picture.title = "Floquet multipliers";
  picture.subtitle = model_title(result, result.at("parameter"));
  picture.x_label = "Re mu";
  picture.y_label = "Im mu";
  picture.colour_label = parameter_label(result, result.at("parameter"));
  picture.unit_circle = picture.equal_axes = true;
  const bool by_period = result.at("branches").size() > most_branch_colours;
  std::map<int, std::size_t> curves;  // index of the curve of each period, if all branches of a period share one
  if (by_period) {
    for (const Json& branch : result.at("branches")) curves[branch.at("period")];
    for (auto& [period, curve] : curves) {
      curve = picture.curves.size();
      picture.curves.push_back(multiplier_curve(curve, fmt::format("period {}", period)));
    }
  }
  std::vector<CriticalPoint> critical;
  double right = 1.0, up = 1.0;
  std::array<double, 2> values = {HUGE_VAL, -HUGE_VAL};
  bool outside = false;
  for (std::size_t b = 0; b < result.at("branches").size(); ++b) {
    const Json& branch = result.at("branches").at(b);
    const int period = branch.at("period");
    const std::size_t at = by_period ? curves.at(period) : b;
    if (!by_period)
      picture.curves.push_back(multiplier_curve(b, fmt::format("branch {}: period {}", branch.at("id").dump(), period)));
    for (const Json& point : branch.at("points"))
      for (const Json& mu : point.at("multipliers")) {
        const double re = mu.at(0), im = mu.at(1), value = point.at("value");
        values = {std::min(values[0], value), std::max(values[1], value)};
        if (std::max(std::abs(re), std::abs(im)) > farthest) {
          outside = true;
          continue;
        }
        picture.curves[at].points.push_back({re, im, value});
        right = std::max(right, std::abs(re));
        up = std::max(up, std::abs(im));
      }
    for (const Json& point : branch.at("special_points")) {
      if (!has_critical_multiplier(point)) continue;
      add_critical(critical, point);
    }
  }
  for (const CriticalPoint& point : critical) {
    const std::size_t named = point.names.size() > 5 ? 3 : point.names.size();
    std::string text =
        fmt::format("{}", fmt::join(point.names.begin(), point.names.begin() + static_cast<std::ptrdiff_t>(named), " "));
    if (named < point.names.size()) text += fmt::format(" and {} more", point.names.size() - named);
    picture.labels.push_back({point.re, point.im, text, point.mark, "black"});
  }
  up = std::max(up, 0.65 * right);  // the aspect ratio of the page
  picture.x_range = {{-1.15 * right, 1.15 * right}};
  picture.y_range = {{-1.15 * up, 1.15 * up}};
  if (values[0] < values[1]) picture.colour_range = values;
  if (outside) picture.title += fmt::format(" (those beyond {} are not shown)", rounded(farthest, 3));
  return picture;
}

}  // namespace

PictureKind branch_picture() {
  return {
      "graze.branch/1", "branch", "x at forcing phase 0 against the parameter; stable solid, unstable dashed", draw_branches, {},
      has_branches,     true};
}

PictureKind multipliers_picture() {
  return {"graze.branch/1", "multipliers", "multipliers along the branches against the unit circle", draw_multipliers, {},
          has_branches};
}

}  // namespace graze::apps
