// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/pictures/skeleton.hpp>

#include <graze/floquet/periodic_orbit.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace graze::apps {

namespace {

/// Length of a curve from its first point to each, in columns; rows are about twice as high as columns are wide.
std::vector<double> lengths(const std::vector<Cell>& curve) {
  std::vector<double> list = {0.0};
  for (std::size_t i = 0; i + 1 < curve.size(); ++i)
    list.push_back(list.back() + std::hypot(curve[i + 1].column - curve[i].column, 2.0 * (curve[i + 1].row - curve[i].row)));
  return list;
}

/// A stretch of a branch along which z stays the same: its points, by iterate.
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

/// Places along the stretch that may carry its z, from the middle outwards, iterate beside iterate.
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

/// Puts words where there is room for them, and counts those for which there was none.
class Wording {
 public:
  Wording(const SkeletonCurves& parts, const SkeletonAxes& axes, const std::vector<Barrier>& barriers,
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

  /// Names of the special points whose period is within the limits.
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
      // Only where every one of the group has a mark can the words stand for all.
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

  /// Those from one length to another.
  void label_stretches(const std::vector<Stretch>& stretches, double from, double to) {
    for (const Stretch& stretch : stretches) {
      if (const double length = stretch.length(); length < from || length >= to) continue;
      if (const auto placed = places_.along_curve(middle_of(stretch), stretch.z))
        put(*placed, stretch.z, colour_of_period(stretch.period));
    }
  }

  SkeletonWords words() && { return std::move(words_); }

 private:
  /// Marks that cover each other have their words in one place.
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
  Wording wording(parts, axes, barriers, samples);
  const std::vector<Stretch> stretches = stretches_of(result, axes);
  constexpr double conspicuous = 15.0, shortest = 6.0;  // lengths that z comes first on, and that it has room on
  wording.label_stretches(stretches, conspicuous, HUGE_VAL);
  wording.name_points(parts.named, 1, longest_with_words, 22.0);
  wording.label_stretches(stretches, shortest, conspicuous);
  wording.name_points(parts.named, longest_with_words + 1, std::numeric_limits<int>::max(), 5.0);
  return std::move(wording).words();
}

}  // namespace graze::apps
