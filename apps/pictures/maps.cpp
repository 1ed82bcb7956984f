// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of graze.map/1: a cell for each point, coloured by its attractor or by its first exponent, a panel for each layer.
#include <graze/apps/map_report.hpp>
#include <graze/apps/number.hpp>
#include <graze/apps/pictures/maps.hpp>
#include <graze/apps/pictures/pictures.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace graze::apps {

namespace {

constexpr int most_columns = 800, most_rows = 500;  // cells of a picture: it has no more elements
constexpr int most_panels = 4;
constexpr int exponent_steps = 4;  // colours on either side of zero

/// Colours with their words, in the order of the legend.
struct Class {
  std::string title, colour;
};

const std::vector<Class>& attractor_classes() {
  static const std::vector<Class> classes = {
      {"impactless", "#d8e6f3"},   {"period 1", "#1f77b4"},      {"period 2", "#2ca02c"}, {"period 3", "#f2c80f"},
      {"period 4", "#9467bd"},     {"period 5", "#17becf"},      {"period 6", "#8c564b"}, {"period 7", "#e377c2"},
      {"period 8", "#006400"},     {"longer period", "#7f7f00"}, {"chaotic", "#c0281c"},  {"undecided", "#555555"},
      {"inadmissible", "#eeeeee"}, {"lost", "#000000"},
  };
  return classes;
}

/// Index of a point's class; -1: not computed.
int attractor_class(const MapPoint& point) {
  constexpr int longer = 9;
  switch (point.type) {
  case MapType::periodic:
    return point.impacts == 0 && point.period == 1 ? 0 : std::min(point.period, longer);
  case MapType::chaotic:
    return longer + 1;
  case MapType::undecided:
    return longer + 2;
  case MapType::inadmissible:
    return longer + 3;
  case MapType::lost:
    return longer + 4;
  case MapType::not_run:
    break;
  }
  return -1;
}

/// Exponents in classes of equal width below and above zero, up to the extremes of the map.
struct ExponentScale {
  double lowest = 0.0, highest = 0.0;
  void take(double lambda) {
    if (!std::isfinite(lambda)) return;
    lowest = std::min(lowest, lambda);
    highest = std::max(highest, lambda);
  }
  double bound(int step) const { return (step < 0 ? -lowest : highest) * step / exponent_steps; }
  int index(const MapPoint& point) const {
    if (std::isnan(point.lambda_1)) return -1;
    const double share = point.lambda_1 > 0.0 ? point.lambda_1 / highest : lowest < 0.0 ? point.lambda_1 / -lowest : 0.0;
    const double step = std::clamp(std::floor(share * exponent_steps), -1.0 * exponent_steps, exponent_steps - 1.0);
    return exponent_steps + static_cast<int>(step);
  }
  std::vector<Class> classes() const {
    static const std::vector<std::string> colours = {"#08306b", "#2b6cb0", "#74add1", "#d0e5f2",
                                                     "#fee0a8", "#fdae61", "#e6550d", "#a50f15"};
    std::vector<Class> list;
    for (int step = -exponent_steps; step < exponent_steps; ++step)
      list.push_back({fmt::format("{} to {}", rounded(bound(step), 2), rounded(bound(step + 1), 2)),
                      colours[static_cast<std::size_t>(step + exponent_steps)]});
    return list;
  }
};

/// Every so-many-th index, the middle ones of their neighbourhoods.
std::vector<int> thinned(int count, int most) {
  const int step = (count + most - 1) / most;
  std::vector<int> kept;
  for (int i = (step - 1) / 2; i < count; i += step) kept.push_back(i);
  return kept;
}

/// Values of an axis at these indices; at least two, for cells need a width.
std::vector<double> cell_values(const ParameterAxis& axis, const std::vector<int>& kept) {
  std::vector<double> values;
  for (const int i : kept) values.push_back(axis.at(i));
  if (values.size() > 1) return values;
  const double half = 0.01 * std::max(std::abs(values[0]), 1e-3);
  return {values[0] - half, values[0] + half};
}

std::array<double, 2> range_of(const std::vector<double>& values) {
  const double half = 0.5 * (values.back() - values.front()) / static_cast<double>(values.size() - 1);
  return {values.front() - half, values.back() + half};
}

/// A mark in the legend only: its point lies far outside.
Curve legend_entry(const Class& entry) {
  Curve curve;
  curve.title = entry.title;
  curve.stroke = Stroke::marks;
  curve.mark = 5;
  curve.colour = entry.colour;
  curve.points.push_back({1e30, 1e30, 0.0});
  return curve;
}

Picture draw_json(const Json& result, const std::string& kind) {
  const MapPlan plan = plan_of(result);
  return picture_of_map(plan, rows_from_json(plan, result), kind);
}

Picture draw_attractors(const Json& result) { return draw_json(result, "attractors"); }
Picture draw_exponent(const Json& result) { return draw_json(result, "exponent"); }

}  // namespace

Picture picture_of_map(const MapPlan& plan, const MapRows& rows, const std::string& kind) {
  const bool exponent = kind == "exponent";
  if (!exponent && !kind.empty() && kind != "attractors")
    throw std::invalid_argument(unknown_name("kind of picture for graze.map/1", kind, {"attractors", "exponent"}));
  const std::vector<int> columns = thinned(plan.grid.columns.count, most_columns);
  const std::vector<int> kept_rows = thinned(plan.grid.rows.count, most_rows);
  const int panels = std::min(plan.layers(), most_panels);
  // Row by row: a file is read band by band, and the whole map need not fit into memory.
  std::vector<std::vector<MapPoint>> points(static_cast<std::size_t>(panels));
  ExponentScale scale;
  for (const int row : kept_rows) {
    const std::vector<MapPoint> all = rows(row);
    for (int panel = 0; panel < panels; ++panel)
      for (const int column : columns) {
        points[static_cast<std::size_t>(panel)].push_back(
            all[static_cast<std::size_t>(panel * plan.grid.columns.count + column)]);
        scale.take(points[static_cast<std::size_t>(panel)].back().lambda_1);
      }
  }
  const std::vector<Class> classes = exponent ? scale.classes() : attractor_classes();
  std::vector<std::string> colours;
  for (const Class& entry : classes) colours.push_back(entry.colour);
  const auto index = [&](const MapPoint& point) { return exponent ? scale.index(point) : attractor_class(point); };

  std::vector<Picture> all;
  for (int panel = 0; panel < panels; ++panel) {
    const std::vector<MapPoint>& shown = points[static_cast<std::size_t>(panel)];
    Picture picture;
    picture.title = exponent ? "First Lyapunov exponent" : "Attractors";
    if (plan.layers() > 1) picture.title += ": " + layer_name(plan, panel);
    picture.subtitle = map_model(plan);
    if (panels > 1) {  // narrow
      picture.subtitle.replace(picture.subtitle.find(": "), 2, "\n");
      picture.legend_columns = 2;
    }
    if (plan.layers() == 1) picture.subtitle += "\n" + layer_name(plan, 0);
    if (plan.layers() > panels && panel + 1 == panels)
      picture.subtitle += fmt::format("\n(the first {} of {} layers)", panels, plan.layers());
    picture.x_label = plan.grid.columns.parameter + " (dimensionless)";
    picture.y_label = plan.grid.rows.parameter + " (dimensionless)";
    picture.grid = false;
    Cells cells{cell_values(plan.grid.columns, columns), cell_values(plan.grid.rows, kept_rows), colours, {}};
    std::vector<bool> used(classes.size(), false);
    for (std::size_t j = 0; j < cells.y.size(); ++j)
      for (std::size_t i = 0; i < cells.x.size(); ++i) {
        const std::size_t row = std::min(j, kept_rows.size() - 1), column = std::min(i, columns.size() - 1);
        cells.colour.push_back(index(shown[row * columns.size() + column]));
        if (cells.colour.back() >= 0) used[static_cast<std::size_t>(cells.colour.back())] = true;
      }
    picture.x_range = range_of(cells.x);
    picture.y_range = range_of(cells.y);
    picture.cells = std::move(cells);
    for (std::size_t i = 0; i < classes.size(); ++i)
      if (used[i]) picture.curves.push_back(legend_entry(classes[i]));
    all.push_back(std::move(picture));
  }
  Picture first = std::move(all.front());
  first.beside.assign(std::make_move_iterator(all.begin() + 1), std::make_move_iterator(all.end()));
  return first;
}

PictureKind map_picture() {
  return {"graze.map/1", "attractors", "types and periods of the attractors over two parameters", draw_attractors, {}};
}

PictureKind map_exponent_picture() {
  return {"graze.map/1", "exponent", "the first exponent over two parameters", draw_exponent, {}};
}

}  // namespace graze::apps
