// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/map/map_report.hpp>
#include <graze/apps/pictures/map_colours.hpp>
#include <graze/apps/results/orbit_report.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace graze::apps {

namespace {

using Z = std::pair<int, int>;  // n and p of z = p/n

constexpr std::size_t most_own = 9;  // number of z with colours of their own
constexpr int longest_own = 8;       // longest period with a colour of its own

/// The colours of a period: light to dark by the number of impacts, and one for all other z.
struct Hue {
  std::vector<const char*> shades;
  const char* others;
};

const Hue& hue_of(int period) {
  static const std::vector<Hue> list = {
      {{"#8fd3f4", "#4aa3df", "#1f6fb4", "#0d3f85", "#061a40"}, "#8fa1b3"},
      {{"#9ade7f", "#2ca02c", "#0b5d1e"}, "#8fa58a"},
      {{"#ffe680", "#f2b50f", "#b0780b"}, "#b5a97a"},
      {{"#c9b1e6", "#9467bd", "#4b2a7b"}, "#a398b0"},
      {{}, "#17becf"},
      {{}, "#8c564b"},
      {{}, "#e377c2"},
      {{}, "#f4a6a0"},
      {{}, "#7f7f00"},
  };
  return list[static_cast<std::size_t>(period - 1)];
}

constexpr const char *impactless_colour = "#e3edf5", *sticking_colour = "#a0127d", *chaotic_colour = "#c0281c",
                     *undecided_colour = "#555555", *inadmissible_colour = "#cccccc", *lost_colour = "#000000";

/// Collects classes of points, each with one colour and one line of the legend.
class Classes {
 public:
  explicit Classes(MapColours& out) : out_(out) {}
  int add(const std::string& title, const std::string& colour) {
    out_.legend.push_back(legend_entry(title, colour));
    out_.colours.push_back(colour);
    return static_cast<int>(out_.colours.size()) - 1;
  }
  /// Adds an entry for points that were not computed: white, with a rim in the legend.
  void add_white(const std::string& title) {
    out_.legend.push_back(legend_entry(title, "#808080"));
    out_.legend.back().mark = 4;
  }

 private:
  MapColours& out_;
};

bool is_impactless(const MapPoint& point) { return point.impacts == 0 && point.period == 1; }

/// The common name of all points with these z.
std::string common_name(const std::set<Z>& list, const std::string& name) {
  return list.size() == 1 ? z_label(list.begin()->second, list.begin()->first) : name;
}

/// Assigns colours to the most frequent z, and to the others by period, and adds their lines to the legend.
std::map<Z, int> periodic_classes(const std::map<Z, std::size_t>& counts, Classes& classes) {
  std::vector<std::pair<Z, std::size_t>> list(counts.begin(), counts.end());
  std::stable_sort(list.begin(), list.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  std::map<int, std::set<Z>> own, others;
  std::size_t taken = 0;
  for (const auto& [z, count] : list) {
    const int period = std::min(z.first, longest_own + 1);
    const bool has_own = taken < most_own && own[period].size() < hue_of(period).shades.size();
    (has_own ? own : others)[period].insert(z);
    if (has_own) ++taken;
  }
  std::map<Z, int> found;
  for (int period = 1; period <= longest_own + 1; ++period) {
    const std::vector<const char*>& shades = hue_of(period).shades;
    std::size_t k = 0;
    for (const Z& z : own[period]) {  // the shades are spread over them
      const std::size_t shade = (2 * k++ + 1) * shades.size() / (2 * own[period].size());
      found[z] = classes.add(z_label(z.second, z.first), shades[shade]);
    }
    if (others[period].empty()) continue;
    const std::string name = period > longest_own  ? "longer period"
                             : own[period].empty() ? fmt::format("period {}", period)
                                                   : fmt::format("other z of period {}", period);
    const int index = classes.add(common_name(others[period], name), hue_of(period).others);
    for (const Z& z : others[period]) found[z] = index;
  }
  return found;
}

bool occurs(const std::vector<MapPoint>& points, bool (*is)(const MapPoint&)) {
  return std::any_of(points.begin(), points.end(), is);
}

template <MapType type> bool is_of(const MapPoint& point) { return point.type == type; }

/// The classes that both kinds of pictures show alike: index of a class by type, -1 if there is none.
std::map<MapType, int> classes_without_motion(const std::vector<MapPoint>& points, Classes& classes) {
  std::map<MapType, int> found;
  if (occurs(points, is_of<MapType::inadmissible>))
    found[MapType::inadmissible] = classes.add("start inside the barrier", inadmissible_colour);
  if (occurs(points, is_of<MapType::lost>)) found[MapType::lost] = classes.add("lost", lost_colour);
  if (occurs(points, is_of<MapType::not_run>)) classes.add_white("not computed");
  return found;
}

int at(const std::map<MapType, int>& classes, MapType type) {
  const auto found = classes.find(type);
  return found == classes.end() ? -1 : found->second;
}

unsigned long part(const std::string& colour, int shift) { return std::stoul(colour.substr(1), nullptr, 16) >> shift & 255; }

/// The colour of a value, interpolated as gnuplot does.
std::string colour_at(const std::vector<ColourStop>& scale, double value) {
  std::size_t i = 1;
  while (i + 1 < scale.size() && value > scale[i].value) ++i;
  const ColourStop &a = scale[i - 1], &b = scale[i];
  const double share = std::clamp((value - a.value) / (b.value - a.value), 0.0, 1.0);
  std::string colour = "#";
  for (const int shift : {16, 8, 0})
    colour += fmt::format("{:02x}", std::lround((1.0 - share) * static_cast<double>(part(a.colour, shift)) +
                                                share * static_cast<double>(part(b.colour, shift))));
  return colour;
}

/// From the lowest exponent through zero to the highest.
std::vector<ColourStop> diverging_scale(double lowest, double highest) {
  std::vector<ColourStop> scale;
  if (lowest < 0.0)
    scale = {{lowest, "#08306b"}, {0.6 * lowest, "#2b6cb0"}, {0.25 * lowest, "#74add1"}, {0.04 * lowest, "#d0e5f2"}};
  scale.push_back({0.0, "#f7f7f7"});
  if (highest > 0.0)
    scale.insert(scale.end(),
                 {{0.04 * highest, "#fee0a8"}, {0.25 * highest, "#fdae61"}, {0.6 * highest, "#e6550d"}, {highest, "#a50f15"}});
  if (scale.size() == 1) scale = {{-1e-3, "#d0e5f2"}, {0.0, "#f7f7f7"}};
  return scale;
}

std::vector<ColourStop> sequential_scale(double lowest, double highest) {
  constexpr std::array colours = {"#440154", "#3b528b", "#21918c", "#5ec962", "#fde725"};
  if (!(lowest < highest)) {  // a single value: the scale needs a width
    const double half = 1e-3 * std::max(std::abs(lowest), 1e-3);
    lowest -= half;
    highest += half;
  }
  std::vector<ColourStop> scale;
  for (std::size_t i = 0; i < colours.size(); ++i)
    scale.push_back({lowest + (highest - lowest) * static_cast<double>(i) / (colours.size() - 1), colours[i]});
  return scale;
}

/// Colours of points by their number, on a scale from the lowest to the highest; `none`: the name of points without a number.
MapColours scaled_colours(const std::vector<MapPoint>& points, const std::function<double(const MapPoint&)>& number,
                          std::vector<ColourStop> (*scale_of)(double lowest, double highest), const char* none) {
  constexpr int steps = 400;
  MapColours out;
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  for (const MapPoint& point : points) {
    if (!std::isfinite(number(point))) continue;
    lowest = std::min(lowest, number(point));
    highest = std::max(highest, number(point));
  }
  const bool any = lowest <= highest;
  const std::vector<ColourStop> scale = any ? scale_of(lowest, highest) : scale_of(0.0, 0.0);
  const double first = scale.front().value, width = scale.back().value - first;
  if (any) out.scale = scale;
  for (int i = 0; i <= steps; ++i) out.colours.push_back(colour_at(scale, first + width * i / steps));
  Classes classes(out);
  const auto occurs_as = [&](bool (*is)(double)) {
    return std::any_of(points.begin(), points.end(),
                       [&](const MapPoint& point) { return point.type < MapType::inadmissible && is(number(point)); });
  };
  const int infinite =
      occurs_as([](double value) { return std::isinf(value); }) ? classes.add("-infinity (sticks)", sticking_colour) : -1;
  const std::map<MapType, int> others = classes_without_motion(points, classes);
  const int unknown = occurs_as([](double value) { return std::isnan(value); }) ? classes.add(none, undecided_colour) : -1;
  out.index = [=](const MapPoint& point) {
    const double value = number(point);
    if (std::isinf(value)) return infinite;
    if (std::isfinite(value)) return static_cast<int>(std::lround(steps * (value - first) / width));
    return point.type < MapType::inadmissible ? unknown : at(others, point.type);
  };
  return out;
}

}  // namespace

MapColours attractor_colours(const std::vector<MapPoint>& points) {
  MapColours out;
  Classes classes(out);
  std::map<Z, std::size_t> counts;
  std::set<int> sticking;  // periods of sticking motions
  for (const MapPoint& point : points) {
    if (sticks(point))
      sticking.insert(point.period);
    else if (point.type == MapType::periodic && !is_impactless(point))
      ++counts[{point.period, point.impacts}];
  }
  const bool free = occurs(points, [](const MapPoint& point) { return point.type == MapType::periodic && is_impactless(point); });
  const int impactless = free ? classes.add("impactless", impactless_colour) : -1;
  const std::map<Z, int> periodic = periodic_classes(counts, classes);
  const std::string sticking_name = sticking.size() == 1 ? fmt::format("z = ∞/{}", *sticking.begin()) : std::string("z = ∞/n");
  const int stuck = sticking.empty() ? -1 : classes.add(sticking_name + " (sticks)", sticking_colour);
  std::map<MapType, int> others;
  if (occurs(points, is_of<MapType::chaotic>)) others[MapType::chaotic] = classes.add("chaotic", chaotic_colour);
  if (occurs(points, is_of<MapType::undecided>)) others[MapType::undecided] = classes.add("undecided", undecided_colour);
  others.merge(classes_without_motion(points, classes));
  out.index = [impactless, periodic, stuck, others](const MapPoint& point) {
    if (sticks(point)) return stuck;
    if (point.type != MapType::periodic) return at(others, point.type);
    return is_impactless(point) ? impactless : periodic.at({point.period, point.impacts});
  };
  return out;
}

MapColours exponent_colours(const std::vector<MapPoint>& points) {
  return scaled_colours(
      points, [](const MapPoint& point) { return point.lambda_1; }, diverging_scale, "no exponent");
}

MapColours quantity_colours(const std::vector<MapPoint>& points, Eigen::Index place) {
  return scaled_colours(
      points, [place](const MapPoint& point) { return quantity_of(point, place); }, sequential_scale, "not known");
}

}  // namespace graze::apps
