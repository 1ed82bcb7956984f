// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/pictures/skeleton.hpp>

#include <algorithm>
#include <cmath>

namespace graze::apps {

namespace {

std::size_t nearest_to(double x, const std::vector<double>& list) {
  const auto closer = [x](double a, double b) { return std::abs(a - x) < std::abs(b - x); };
  return static_cast<std::size_t>(std::min_element(list.begin(), list.end(), closer) - list.begin());
}

/// The doubling at which an end of a doubled branch lies, by its nearness; null if there is none. Branches begin and stop a
/// little beside it, which a square root makes a gap that is seen.
const Json* doubling_at(const Json& result, const Json& branch, const Json& end) {
  const int period = branch.at("period");
  const double value = end.at("value");
  const Json* nearest = nullptr;
  double least = 0.2;
  for (const Json& other : result.at("branches")) {
    if (2 * other.at("period").get<int>() != period) continue;
    for (const Json& point : other.at("special_points")) {
      if (point.at("type") != "PD" || std::abs(point.at("value").get<double>() - value) > 1e-3 * std::abs(value)) continue;
      const std::vector<double> at = positions(point);
      double farthest = 0.0;
      for (const double x : positions(end)) farthest = std::max(farthest, std::abs(at[nearest_to(x, at)] - x));
      if (farthest >= least) continue;
      least = farthest;
      nearest = &point;
    }
  }
  return nearest;
}

/// Lines from the ends of a doubled branch to the doublings at which it begins and ends.
void close_gaps(const Json& result, const Json& branch, SkeletonCurves& parts) {
  const Json& points = branch.at("points");
  if (points.empty()) return;
  std::vector<const Json*> ends;
  if (!branch.at("parent").is_null()) ends.push_back(&points.front());
  if (branch.at("stop").at("reason") == "returned") ends.push_back(&points.back());
  for (const Json* end : ends) {
    const Json* doubling = doubling_at(result, branch, *end);
    if (!doubling) continue;
    const std::vector<double> at = positions(*doubling);
    std::vector<SkeletonCurves::Point>& all = parts.curves[{branch.at("period").get<int>(), stroke_of(*end)}];
    for (const double x : positions(*end)) {
      if (!all.empty()) all.push_back({NAN, NAN, 0.0});
      all.push_back({end->at("value"), x, 0.0});
      all.push_back({doubling->at("value"), at[nearest_to(x, at)], 0.0});
    }
  }
}

}  // namespace

std::string colour_of_period(int period) {
  static const std::map<int, std::string> colours = {{1, "#1f4e9c"},  {2, "#d9480f"},  {4, "#2b8a3e"},  {8, "#8e44ad"},
                                                     {16, "#8c564b"}, {32, "#7f7f7f"}, {3, "#0b8fa8"},  {6, "#c2a000"},
                                                     {12, "#d6569a"}, {5, "#5c7c0a"},  {10, "#b07d4f"}, {7, "#4b4b9f"}};
  const auto found = colours.find(period);
  return found == colours.end() ? colour_of(static_cast<std::size_t>(period)) : found->second;
}

SkeletonCurves skeleton_curves(const Json& result) {
  SkeletonCurves parts;
  for (const Json& branch : result.at("branches")) {
    const int period = branch.at("period");
    const std::vector<Drawn> points = points_in_order(branch);
    for (std::size_t k = 0; !points.empty() && k < positions(*points.front().point).size(); ++k)
      for (const Curve& piece : curves_of(points, k)) {
        std::vector<SkeletonCurves::Point>& all = parts.curves[{period, piece.stroke}];
        if (!all.empty()) all.push_back({NAN, NAN, 0.0});
        all.insert(all.end(), piece.points.begin(), piece.points.end());
      }
    close_gaps(result, branch, parts);
    for (const Json& point : branch.at("special_points")) {
      if (!is_marked(point)) continue;
      const std::string type = point.at("type");
      parts.mark_types[type] = mark_of(point);
      std::vector<double> x = positions(point);
      std::sort(x.rbegin(), x.rend());
      for (const double value : x) parts.marks[{type, period > longest_with_words}].push_back({point.at("value"), value, 0.0});
      parts.named.push_back({period, point.at("label"), point.at("value"), x});
    }
  }
  std::stable_sort(parts.named.begin(), parts.named.end(), [](const auto& a, const auto& b) { return a.value < b.value; });
  return parts;
}

}  // namespace graze::apps
