// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/pictures/branch_curves.hpp>

#include <algorithm>
#include <map>
#include <string>
#include <utility>

namespace graze::apps {

int mark_of_type(const std::string& type) {
  static const std::map<std::string, int> marks = {{"PD", 7},  {"LP", 5}, {"BP", 13}, {"NS", 9},
                                                   {"GR", 11}, {"UZ", 6}, {"MX", 2},  {"EP", 1}};
  const auto found = marks.find(type);
  return found == marks.end() ? 3 : found->second;
}

int mark_of(const Json& special_point) { return mark_of_type(special_point.at("type").get<std::string>()); }

bool is_marked(const Json& special_point) { return special_point.at("type") != "EP"; }

std::vector<double> positions(const Json& point) {
  std::vector<double> list;
  if (point.contains("states"))
    for (const Json& state : point.at("states")) list.push_back(state.at(0));
  else
    list.push_back(point.at("state").at(0));
  return list;
}

bool follows_gap(const Json& point) { return point.value("after_gap", false); }

Stroke stroke_of(const Json& point) {
  if (!point.at("admissible").get<bool>()) return Stroke::dotted;
  return point.at("stable").get<bool>() ? Stroke::solid : Stroke::dashed;
}

const char* stroke_name(Stroke stroke) {
  return stroke == Stroke::solid ? "stable" : stroke == Stroke::dashed ? "unstable" : "not admissible";
}

bool has_branches(const Json& result) {
  const Json& branches = result.at("branches");
  return std::any_of(branches.begin(), branches.end(), [](const Json& branch) { return branch.at("points").size() > 1; });
}

std::vector<Drawn> points_in_order(const Json& branch) {
  std::vector<Drawn> list;
  const Json &points = branch.at("points"), &special = branch.at("special_points");
  for (std::size_t i = 0; i < points.size(); ++i) {
    list.push_back({&points[i], false});
    for (const Json& point : special)
      if (is_marked(point) && point.value("after_point", points.size()) == i) list.push_back({&point, true});
  }
  return list;
}

std::vector<Curve> curves_of(const std::vector<Drawn>& points, std::size_t k) {
  std::vector<Curve> curves;
  bool broken = true;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Drawn &a = points[i], &b = points[i + 1];
    // After a border the stroke is that of the next point that is not a border; the last point never is one.
    std::size_t inside = i;
    while (points[inside].border && inside + 1 < points.size()) ++inside;
    if (points[inside].border) break;
    const Stroke stroke = stroke_of(*points[inside].point);
    const std::vector<double> from = positions(*a.point), to = positions(*b.point);
    if (k >= from.size() || k >= to.size()) continue;
    if (follows_gap(*b.point)) {
      broken = true;
      continue;
    }
    if (std::exchange(broken, false) || curves.back().stroke != stroke) {
      curves.emplace_back();
      curves.back().stroke = stroke;
      curves.back().points.push_back({a.point->at("value"), from[k], 0.0});
    }
    curves.back().points.push_back({b.point->at("value"), to[k], 0.0});
  }
  return curves;
}

}  // namespace graze::apps
