// SPDX-License-Identifier: GPL-3.0-or-later
// Picture of graze.branch/1 as a whole: every branch in the colour of its period, special points marked by type, z written
// along the branches.
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/pictures/skeleton.hpp>
#include <graze/apps/text/number.hpp>
#include <graze/floquet/orbit/periodic_orbit.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace graze::apps {

namespace {

/// Longer periods have more and closer curves, which are drawn thinner.
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
  // The names of the largest iterates need room above.
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
  const std::size_t whole = (entries + 2) / 3;
  const auto rows = static_cast<double>(whole);
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
  picture.x_label = parameter_label(result, parameter);
  picture.y_label = state_label(result, 0, true);
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
  return {"graze.branch/1",
          "skeleton",
          "all branches in the colours of their periods, with special points and z along them",
          draw_skeleton,
          "diagram",
          has_branches,
          true};
}

namespace {

std::size_t nearest_to(double x, const std::vector<double>& list) {
  const auto closer = [x](double a, double b) { return std::abs(a - x) < std::abs(b - x); };
  return static_cast<std::size_t>(std::min_element(list.begin(), list.end(), closer) - list.begin());
}

/// The doubling at one end of a doubled branch, found by distance; null if there is none. Branches begin and stop slightly
/// beside it. A square root turns this distance into a visible gap.
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

/// Adds lines from the ends of a doubled branch to the doublings at which it begins and ends.
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

namespace {

/// Length of a curve from its first point to each point, in columns; rows are about twice as high as columns are wide.
std::vector<double> lengths(const std::vector<Cell>& curve) {
  std::vector<double> list = {0.0};
  for (std::size_t i = 0; i + 1 < curve.size(); ++i)
    list.push_back(list.back() + std::hypot(curve[i + 1].column - curve[i].column, 2.0 * (curve[i + 1].row - curve[i].row)));
  return list;
}

/// A part of a branch along which z is constant: its points, by iterate.
struct Stretch {
  int period = 0;
  std::string z;
  std::vector<std::vector<Cell>> iterates;
  double length() const {
    double longest = 0.0;
    for (const std::vector<Cell>& curve : iterates) longest = std::max(longest, lengths(curve).back());
    return longest;
  }
};

std::vector<Stretch> stretches_of(const Json& result, const SkeletonAxes& axes) {
  std::vector<Stretch> list;
  for (const Json& branch : result.at("branches")) {
    const int period = branch.at("period");
    if (period > longest_with_words) continue;
    std::string last;
    for (const Json& point : branch.at("points")) {
      const std::string z =
          label(point.at("impacts").get<int>(), point.value("isolated_impacts", point.at("impacts").get<int>()), period);
      const std::vector<double> x = positions(point);
      if (z != last) list.push_back({period, z, std::vector<std::vector<Cell>>(x.size())});
      last = z;
      for (std::size_t k = 0; k < x.size() && k < list.back().iterates.size(); ++k)
        list.back().iterates[k].push_back(axes.cell(point.at("value"), x[k]));
    }
  }
  std::stable_sort(list.begin(), list.end(), [](const Stretch& a, const Stretch& b) { return a.period < b.period; });
  return list;
}

/// Places along the part that may carry its z, from the middle outwards, alternating between iterates.
std::vector<Cell> middle_of(const Stretch& stretch) {
  std::vector<std::pair<double, Cell>> found;
  for (const std::vector<Cell>& curve : stretch.iterates) {
    const std::vector<double> length = lengths(curve);
    for (int step = 0; step <= 24 && curve.size() > 1; ++step) {
      const double part = 0.2 + 0.025 * step, at = part * length.back();
      const auto beyond = std::upper_bound(length.begin() + 1, length.end() - 1, at);
      const auto i = static_cast<std::size_t>(beyond - length.begin());
      const Cell &a = curve[i - 1], &b = curve[i];
      const double t = (at - length[i - 1]) / std::max(length[i] - length[i - 1], 1e-12);
      found.push_back({std::abs(part - 0.5), {a.column + t * (b.column - a.column), a.row + t * (b.row - a.row)}});
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Cell> list;
  for (const auto& [distance, cell] : found) list.push_back(cell);
  return list;
}

/// Places words if there is room, and counts those without room.
class WordPlacement {
 public:
  WordPlacement(const SkeletonCurves& parts, const SkeletonAxes& axes, const std::vector<Barrier>& barriers,
                const std::vector<Curve>& samples)
      : axes_(axes), places_(axes.rows) {
    for (const auto& [key, points] : parts.curves)
      for (std::size_t i = 0; i + 1 < points.size(); ++i)
        if (!std::isnan(points[i][0]) && !std::isnan(points[i + 1][0]))
          places_.add_line(axes.cell(points[i][0], points[i][1]), axes.cell(points[i + 1][0], points[i + 1][1]));
    for (const auto& [key, points] : parts.marks)
      for (const SkeletonCurves::Point& point : points) places_.add_mark(axes.cell(point[0], point[1]));
    for (const Curve& curve : samples)
      for (const auto& point : curve.points) places_.add_dot(axes.cell(point[0], point[1]));
    for (const Barrier& barrier : barriers) {
      if (barrier.vertical) continue;
      places_.add_line(axes.cell(axes.x[0], barrier.position), axes.cell(axes.x[1], barrier.position));
    }
    words_.leaders.colour = "#444444";
    words_.leaders.size = 0.7;
  }

  /// Names the special points whose period is within the limits.
  void name_points(const std::vector<SkeletonCurves::Named>& points, int from, int to, double farthest) {
    struct Group {
      std::vector<Cell> marks;
      std::string words;
      int size;
    };
    constexpr std::size_t longest_words = 24;  // of a group
    std::vector<Group> groups;
    for (const SkeletonCurves::Named& point : points) {
      if (point.period < from || point.period > to) continue;
      std::vector<Cell> marks;
      for (const double x : point.x) marks.push_back(axes_.cell(point.value, x));
      const auto same = std::find_if(groups.begin(), groups.end(),
                                     [&](const Group& group) { return one_mark(group.marks.front(), marks.front()); });
      if (same == groups.end() || same->size == 4 || same->words.size() + point.label.size() > longest_words) {
        groups.insert(groups.begin(), {marks, point.label, 1});
        continue;
      }
      // The words can stand for the whole group only at a mark that all its points share.
      std::erase_if(same->marks, [&](const Cell& mark) {
        return std::none_of(marks.begin(), marks.end(), [&](const Cell& other) { return one_mark(mark, other); });
      });
      same->words += " " + point.label;
      ++same->size;
    }
    // Long words first: they need the most room.
    std::stable_sort(groups.begin(), groups.end(), [](const Group& a, const Group& b) { return a.size > b.size; });
    for (const Group& group : groups) {
      const auto placed = places_.beside_mark(group.marks, group.words, farthest);
      words_.without += placed ? 0 : group.size;
      if (placed) put(*placed, group.words, mark_colour);
    }
  }

  /// Labels the parts whose length lies between two limits.
  void label_stretches(const std::vector<Stretch>& stretches, double from, double to) {
    for (const Stretch& stretch : stretches) {
      if (const double length = stretch.length(); length < from || length >= to) continue;
      if (const auto placed = places_.along_curve(middle_of(stretch), stretch.z))
        put(*placed, stretch.z, colour_of_period(stretch.period));
    }
  }

  SkeletonWords words() && { return std::move(words_); }

 private:
  /// Whether two marks overlap, so that their words share one place.
  static bool one_mark(Cell a, Cell b) { return std::abs(a.column - b.column) < 1.0 && std::abs(a.row - b.row) < 0.5; }

  void put(const PlacedWords& placed, const std::string& text, const std::string& colour) {
    const SkeletonCurves::Point at = axes_.point(placed.anchor);
    words_.labels.push_back({at[0], at[1], text, no_mark, colour, true});
    if (placed.leader.empty()) return;
    if (!words_.leaders.points.empty()) words_.leaders.points.push_back({NAN, NAN, 0.0});
    for (const Cell& cell : placed.leader) words_.leaders.points.push_back(axes_.point(cell));
  }

  const SkeletonAxes& axes_;
  WordPlaces places_;
  SkeletonWords words_;
};

}  // namespace

SkeletonWords skeleton_words(const Json& result, const SkeletonCurves& parts, const SkeletonAxes& axes,
                             const std::vector<Barrier>& barriers, const std::vector<Curve>& samples) {
  WordPlacement wording(parts, axes, barriers, samples);
  const std::vector<Stretch> stretches = stretches_of(result, axes);
  constexpr double conspicuous = 15.0, shortest = 6.0;  // lengths: z has priority; z has room
  wording.label_stretches(stretches, conspicuous, HUGE_VAL);
  wording.name_points(parts.named, 1, longest_with_words, 22.0);
  wording.label_stretches(stretches, shortest, conspicuous);
  wording.name_points(parts.named, longest_with_words + 1, std::numeric_limits<int>::max(), 5.0);
  return std::move(wording).words();
}

}  // namespace graze::apps
