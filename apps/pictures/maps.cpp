// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of graze.map/1: a cell for each point, coloured by its attractor, its first exponent or a quantity; one panel per
// layer.
#include <graze/apps/map/map_report.hpp>
#include <graze/apps/pictures/map_colours.hpp>
#include <graze/apps/pictures/maps.hpp>
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/text/number.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace graze::apps {

namespace {

constexpr int most_columns = 800, most_rows = 500;  // cells of a picture: it has no more pixels
constexpr std::size_t most_panels = 4;

/// Every k-th index, each in the middle of its group.
std::vector<int> thinned(int count, int most) {
  const int step = (count + most - 1) / most;
  std::vector<int> kept;
  for (int i = (step - 1) / 2; i < count; i += step) kept.push_back(i);
  return kept;
}

/// The values of an axis at these indices; at least two, because cells need a width.
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

/// A percentage that is 0 or 100 only if that is exact.
std::string percent(std::size_t part, std::size_t whole) {
  const double share = 100.0 * static_cast<double>(part) / static_cast<double>(whole);
  return fmt::format("{:.0f}", part == whole ? share : std::clamp(share, 1.0, 99.0));
}

Picture draw_json(const Json& result, const std::string& kind) {
  const MapPlan plan = plan_of(result);
  return picture_of_map(plan, rows_from_json(plan, result), {.kind = kind});
}

Picture draw_attractors(const Json& result) { return draw_json(result, "attractors"); }
Picture draw_exponent(const Json& result) { return draw_json(result, "exponent"); }
Picture draw_quantity(const Json& result) { return draw_json(result, "quantity"); }

bool has_quantities(const Json& result) { return result.at("options").contains("y"); }

/// The colours of the points, the title and the label of the scale.
struct Shading {
  MapColours colours;
  std::string title, label;
};

Shading shading_of(const MapPlan& plan, const std::vector<MapPoint>& points, const MapView& view) {
  if (view.kind == "exponent") {
    const auto unit = plan.problem.written->units.find("t");
    const bool given = unit != plan.problem.written->units.end() && !is_built_in(plan.problem);
    return {exponent_colours(points), "First Lyapunov exponent",
            is_built_in(plan.problem) ? "lambda_1 per unit of dimensionless time"
            : given                   ? fmt::format("lambda_1 / (1/{})", unit->second)
                                      : std::string("lambda_1 per unit of time")};
  }
  if (view.kind != "quantity") return {attractor_colours(points), "Attractors", {}};
  const std::vector<Quantity>& list = plan.quantities.list;
  const auto found = view.quantity.empty()
                         ? list.begin()
                         : std::find_if(list.begin(), list.end(), [&](const Quantity& one) { return one.text == view.quantity; });
  return {quantity_colours(points, found - list.begin()), found->text, quantity_label(plan.problem, found->text, true)};
}

void check_view(const MapPlan& plan, const MapView& view) {
  if (!view.kind.empty() && view.kind != "attractors" && view.kind != "exponent" && view.kind != "quantity")
    throw std::invalid_argument("of graze.map/1 " +
                                unknown_name("kind of picture", view.kind, {"attractors", "exponent", "quantity"}));
  if (view.kind != "quantity") return;
  if (plan.quantities.empty())
    throw std::invalid_argument("this map has no quantities to draw; compute it with --y, for example --y \"max(x)\"");
  std::vector<std::string> names;
  for (const Quantity& one : plan.quantities.list) names.push_back(one.text);
  if (!view.quantity.empty() && std::find(names.begin(), names.end(), view.quantity) == names.end())
    throw std::invalid_argument("--y: " + unknown_name("quantity of this map", view.quantity, names));
}

}  // namespace

std::vector<int> layer_numbers(const std::vector<std::string>& texts) {
  std::vector<int> layers;
  for (const std::string& text : texts) {
    const std::optional<int> layer = parse_count(text);
    if (!layer) throw std::invalid_argument(fmt::format("--layer {}: must be a whole number, the layers count from 0", text));
    layers.push_back(*layer);
  }
  return layers;
}

void check_layers(const MapPlan& plan, const std::vector<int>& layers) {
  for (const int layer : layers)
    if (layer < 0 || layer >= plan.layers())
      throw std::invalid_argument(plan.layers() == 1
                                      ? fmt::format("--layer {}: this map has one layer, 0; leave --layer away", layer)
                                      : fmt::format("--layer {}: this map has {} layers; give one from 0 to {}", layer,
                                                    plan.layers(), plan.layers() - 1));
  if (layers.size() > most_panels)
    throw std::invalid_argument(fmt::format(
        "--layer is given {} times; a picture shows {} layers at most, draw the others in another", layers.size(), most_panels));
}

Picture picture_of_map(const MapPlan& plan, const MapRows& rows, const MapView& view) {
  const std::vector<int>& layers = view.layers;
  check_view(plan, view);
  check_layers(plan, layers);
  const std::vector<int> columns = thinned(plan.grid.columns.count, most_columns);
  const std::vector<int> kept_rows = thinned(plan.grid.rows.count, most_rows);
  std::vector<int> panels = layers;
  for (int layer = 0; layers.empty() && layer < std::min(plan.layers(), static_cast<int>(most_panels)); ++layer)
    panels.push_back(layer);
  // Row by row, panel by panel in each row: a file is read band by band, and the whole map need not fit into memory.
  std::vector<MapPoint> points;
  for (const int row : kept_rows) {
    const std::vector<MapPoint> all = rows(row);
    for (const int layer : panels)
      for (const int column : columns) points.push_back(all[static_cast<std::size_t>(layer * plan.grid.columns.count + column)]);
  }
  const auto& [colours, title, scale_label] = shading_of(plan, points, view);
  const auto missing = static_cast<std::size_t>(
      std::count_if(points.begin(), points.end(), [](const MapPoint& point) { return point.type == MapType::not_run; }));

  std::vector<Picture> all;
  for (std::size_t panel = 0; panel < panels.size(); ++panel) {
    Picture picture;
    picture.title = title;
    if (plan.layers() > 1) picture.title += fmt::format(", layer {}: {}", panels[panel], layer_name(plan, panels[panel]));
    picture.subtitle = map_model(plan);
    if (panels.size() > 1) picture.subtitle.replace(picture.subtitle.find(": "), 2, "\n");  // panels are narrow: break the line
    if (plan.layers() == 1) picture.subtitle += "\n" + layer_name(plan, 0);
    if (missing > 0)
      picture.subtitle += fmt::format("\nincomplete: {} % of the points are not computed", percent(missing, points.size()));
    if (layers.empty() && plan.layers() > static_cast<int>(panels.size()) && panel + 1 == panels.size())
      picture.subtitle += fmt::format("\n(the first {} of {} layers; --layer draws others)", panels.size(), plan.layers());
    picture.x_label = plan.grid.columns.parameter + unit_behind(plan.problem, plan.grid.columns.parameter);
    picture.y_label = plan.grid.rows.parameter + unit_behind(plan.problem, plan.grid.rows.parameter);
    picture.grid = false;
    picture.common_legend = true;
    if (panels.size() > 1) picture.legend_columns = 2 * panels.size();
    Cells cells{cell_values(plan.grid.columns, columns), cell_values(plan.grid.rows, kept_rows), colours.colours, {}};
    for (std::size_t j = 0; j < cells.y.size(); ++j)
      for (std::size_t i = 0; i < cells.x.size(); ++i) {
        const std::size_t row = std::min(j, kept_rows.size() - 1), column = std::min(i, columns.size() - 1);
        cells.colour.push_back(colours.index(points[(row * panels.size() + panel) * columns.size() + column]));
      }
    picture.x_range = range_of(cells.x);
    picture.y_range = range_of(cells.y);
    picture.cells = std::move(cells);
    picture.curves = colours.legend;
    if (!colours.scale.empty()) {
      picture.colour_label = scale_label;
      picture.colour_range = {{colours.scale.front().value, colours.scale.back().value}};
      picture.palette = colours.scale;
    }
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

PictureKind map_quantity_picture() {
  return {"graze.map/1", "quantity", "the first quantity of --y over two parameters", draw_quantity, {}, has_quantities};
}

}  // namespace graze::apps
