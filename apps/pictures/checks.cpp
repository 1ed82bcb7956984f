// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of graze.verify/1: disagreements against their bounds, and the hard limit.
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/text/number.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace graze::apps {

namespace {

constexpr double smallest = 1e-17;  // an exact agreement has no logarithm

double number(const Json& json) { return json.is_number() ? json.get<double>() : NAN; }

/// A single value: all checks side by side.
Picture draw_list(const Json& result) {
  Picture picture;
  picture.title = "Checks";
  picture.subtitle = model_title(result);
  picture.y_label = "disagreement";
  picture.logarithmic_y = true;
  Curve disagreement, limit;
  disagreement.stroke = limit.stroke = Stroke::marks;
  disagreement.title = "disagreement";
  disagreement.size = limit.size = 1.5;
  limit.title = "bound";
  limit.mark = 2;
  limit.colour = "#b22222";
  for (const Json& orbit : result.at("orbits"))
    for (const Json& check : orbit.at("checks")) {
      const std::string name = check.at("name");
      const auto known = std::find(picture.x_names.begin(), picture.x_names.end(), name);
      const auto at = static_cast<double>(known - picture.x_names.begin());
      if (known == picture.x_names.end()) picture.x_names.push_back(name);
      if (check.at("disagreement").is_number())
        disagreement.points.push_back({at, std::max(smallest, check.at("disagreement").get<double>()), 0.0});
      limit.points.push_back({at, check.at("bound"), 0.0});
    }
  picture.x_range = {{-0.5, static_cast<double>(picture.x_names.size()) - 0.5}};
  picture.curves = {disagreement, limit};
  return picture;
}

/// A range: each check in units of its bound against the parameter.
Picture draw_range(const Json& result) {
  const std::string parameter = result.at("parameter");
  Picture picture;
  picture.title = "Checks";
  picture.subtitle = model_title(result, parameter);
  picture.x_label = parameter_label(result, parameter);
  picture.y_label = "disagreement over its bound";
  picture.logarithmic_y = true;
  std::vector<std::string> names;
  for (const Json& orbit : result.at("orbits"))
    for (const Json& check : orbit.at("checks")) {
      const double disagreement = number(check.at("disagreement")), limit = check.at("bound");
      if (std::isnan(disagreement)) continue;
      const std::string name = check.at("name");
      const auto known = std::find(names.begin(), names.end(), name);
      const auto at = static_cast<std::size_t>(known - names.begin());
      if (known == names.end()) {
        names.push_back(name);
        static constexpr int marks[] = {7, 5, 9, 11, 13, 15, 4};
        Curve curve;
        curve.title = name;
        for (const auto& [longer, shorter] : {std::pair{"multipliers: ", "mu, "}, {"hard limit: ", "limit: "}})
          if (name.starts_with(longer)) curve.title.replace(0, std::string(longer).size(), shorter);
        curve.stroke = Stroke::marks;
        curve.size = 1.2;
        curve.mark = marks[at % std::size(marks)];
        curve.colour = colour_of(at);
        picture.curves.push_back(curve);
      }
      picture.curves[at].points.push_back({orbit.at("value"), std::max(smallest, disagreement) / limit, 0.0});
    }
  const Json& options = result.at("options");
  const double from = options.at("from"), to = options.at("to"), margin = 0.03 * std::abs(to - from);
  picture.x_range = {{std::min(from, to) - margin, std::max(from, to) + margin}};
  // The axis extends above the bound, where a violation would be seen.
  double highest = 1.0, lowest = 1.0;
  for (const Curve& curve : picture.curves)
    for (const auto& point : curve.points) {
      highest = std::max(highest, point[1]);
      lowest = std::min(lowest, point[1]);
    }
  picture.y_range = {{lowest / 10.0, 100.0 * highest}};
  picture.barriers.push_back({false, 1.0, "bound", false});
  return picture;
}

Picture draw_checks(const Json& result) {
  std::vector<double> values;
  for (const Json& orbit : result.at("orbits")) values.push_back(orbit.value("value", 0.0));
  const bool range = std::adjacent_find(values.begin(), values.end(), std::not_equal_to<>()) != values.end();
  return range ? draw_range(result) : draw_list(result);
}

/// The first orbits with the requested part of the hard limit, and their titles.
std::vector<std::pair<std::string, const Json*>> hard_limits(const Json& result, const char* part) {
  constexpr std::size_t most = 4;  // more cannot be told apart
  std::vector<std::pair<std::string, const Json*>> list;
  for (const Json& orbit : result.at("orbits"))
    if (list.size() < most && orbit.contains("hard_limit") && orbit["hard_limit"].contains(part) &&
        !orbit["hard_limit"][part].empty())
      list.emplace_back(fmt::format("z = {}/{} at {} = {}", orbit.at("impacts").get<int>(), orbit.at("period").get<int>(),
                                    result.at("parameter").get<std::string>(), rounded(orbit.at("value").get<double>(), 6)),
                        &orbit["hard_limit"]);
  return list;
}

bool has_steps(const Json& result) { return !hard_limits(result, "steps").empty(); }
bool has_restitution(const Json& result) { return !hard_limits(result, "restitution").empty(); }

/// The last element. @throws Json::exception if there is none, in contrast to back().
const Json& last_of(const Json& list) { return list.at(list.size() - 1); }

Picture draw_restitution(const Json& result) {
  Picture picture;
  picture.title = "Equivalent coefficient of restitution";
  picture.subtitle = model_title(result);
  picture.x_label = "entry speed (dimensionless)";
  picture.y_label = "exit speed over entry speed";
  const auto list = hard_limits(result, "restitution");
  if (list.empty()) throw std::invalid_argument("there is no restitution in this result: it takes --hard-limit and b_H > 0");
  const Json& hard = *list.front().second;
  Curve computed, stiff, closed;
  computed.title = fmt::format("computed, k_H = {}", rounded(result.at("parameters").at("k_H").get<double>(), 6));
  stiff.title = fmt::format("computed, k_H = {}", rounded(last_of(hard.at("steps")).at("k_H").get<double>(), 6));
  stiff.stroke = Stroke::marks;
  stiff.size = 1.2;
  stiff.mark = 6;
  stiff.colour = colour_of(1);
  closed.title = "closed form of the contact alone";
  closed.colour = colour_of(2);
  for (const Json& point : hard.at("restitution")) {
    const double speed = point.at("speed");
    computed.points.push_back({speed, number(point.at("computed")), 0.0});
    stiff.points.push_back({speed, number(point.at("stiff")), 0.0});
    closed.points.push_back({speed, point.at("closed_form"), 0.0});
  }
  picture.curves = {computed, closed, stiff};
  return picture;
}

Picture draw_hard_limit(const Json& result) {
  Picture picture;
  picture.title = "From Hertz contact to the rigid stop";
  picture.subtitle = model_title(result, "k_H");
  picture.x_label = "contact stiffness k_H (dimensionless)";
  picture.y_label = "relative difference from the rigid stop";
  picture.logarithmic_x = picture.logarithmic_y = true;
  const auto list = hard_limits(result, "steps");
  if (list.empty()) throw std::invalid_argument("there is no hard limit in this result: it takes --hard-limit");
  std::size_t series = 0;
  for (const auto& [title, hard] : list) {
    Curve state, multipliers;
    state.title = "state, " + title;
    multipliers.title = "multipliers, " + title;
    for (Curve* curve : {&state, &multipliers}) {
      curve->stroke = Stroke::marks;
      curve->size = 1.4;
      curve->mark = curve == &state ? 7 : 9;
      curve->colour = colour_of(series++);
    }
    for (const Json& step : hard->at("steps")) {
      const double k_H = step.at("k_H");
      state.points.push_back({k_H, std::max(smallest, number(step.at("state_difference"))), 0.0});
      multipliers.points.push_back({k_H, std::max(smallest, number(step.at("multiplier_difference"))), 0.0});
    }
    if (series == 2) {
      Curve slope;
      slope.title = "slope -2/5";
      slope.stroke = Stroke::dashed;
      slope.colour = "#888888";
      const auto last = state.points.back();
      for (const auto& point : state.points)
        slope.points.push_back({point[0], last[1] * std::pow(point[0] / last[0], -0.4), 0.0});
      picture.curves.push_back(slope);
    }
    picture.curves.push_back(state);
    picture.curves.push_back(multipliers);
  }
  return picture;
}

}  // namespace

PictureKind verify_picture() {
  return {
      "graze.verify/1", "checks", "disagreements against their bounds, over the parameter if there is a range", draw_checks, {}};
}

PictureKind restitution_picture() {
  return {
      "graze.verify/1", "restitution", "equivalent restitution of damped Hertz contact over entry speed", draw_restitution, {},
      has_restitution};
}

PictureKind hard_limit_picture() {
  return {"graze.verify/1", "hard-limit", "differences from the rigid stop over the stiffness", draw_hard_limit, {}, has_steps};
}

}  // namespace graze::apps
