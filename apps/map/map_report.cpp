// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/map/map_report.hpp>
#include <graze/apps/results/orbit_report.hpp>
#include <graze/apps/text/number.hpp>
#include <graze/apps/text/table.hpp>
#include <graze/lib/numerics/parallel.hpp>

#include <fmt/compile.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <stdexcept>

namespace graze::apps {

namespace {

constexpr std::size_t most_lines = 12;  // of the overview of a layer

/// The kinds sorted by their number of points, largest first.
template <class Counts> auto ranked(const Counts& counts) {
  std::vector<std::pair<typename Counts::key_type, std::size_t>> list(counts.begin(), counts.end());
  std::stable_sort(list.begin(), list.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  return list;
}

Json counts_json(const MapCounts& counts) {
  Json list = Json::array();
  for (const auto& [kind, count] : ranked(counts)) {
    const auto& [type, period, impacts, sticking] = kind;
    Json entry = {{"type", map_type_name(type)}};
    if (type == MapType::periodic) entry.update({{"period", period}, {"impacts", impacts}});
    if (sticking) entry["sticking"] = true;
    entry["points"] = count;
    list.push_back(std::move(entry));
  }
  return list;
}

void add_row(Json& layer, const MapPlan& plan, const MapPoint* points) {
  const auto add = [&](Json& rows, const Column<MapPoint>& one) {
    Json& row = rows.emplace_back(Json::array());
    for (int column = 0; column < plan.grid.columns.count; ++column) row.push_back(one.json(points[column]));
  };
  for (const Column<MapPoint>& one : map_columns()) add(layer[one.name], one);
  for (const MapField& field : plan.fields)
    if (field.of_quantity()) add(layer["y"][field.column.name], field.column);
}

}  // namespace

std::vector<MapCounts> count_map(const MapPlan& plan, const MapRows& rows) {
  std::vector<MapCounts> counts;
  const MapRows counted = counting(plan, rows, counts);
  for (int row = 0; row < plan.grid.rows.count; ++row) counted(row);
  return counts;
}

MapRows counting(const MapPlan& plan, const MapRows& rows, std::vector<MapCounts>& counts) {
  counts.assign(static_cast<std::size_t>(plan.layers()), {});
  return [&rows, &counts, columns = static_cast<std::size_t>(plan.grid.columns.count)](int row) {
    std::vector<MapPoint> points = rows(row);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const MapPoint& point = points[i];
      ++counts[i / columns][{point.type, point.period, point.impacts, sticks(point)}];
    }
    return points;
  };
}

std::string map_point_name(const MapCounts::key_type& kind) {
  const auto& [type, period, impacts, sticking] = kind;
  if (sticking) return impacts == 0 ? "at rest" : fmt::format("z = ∞/{}", period);
  if (type == MapType::periodic) return impacts == 0 && period == 1 ? "impactless" : z_label(impacts, period);
  return type == MapType::not_run ? "not computed" : std::string(map_type_name(type));
}

std::string layer_name(const MapPlan& plan, int layer) {
  const LayerOrigin origin = layer_origin(plan, layer);
  const std::string from = origin.start ? rounded_state(*origin.start, 6) : std::string("rest");
  if (origin.follow == MapDirection::none) return "each point from " + from;
  return fmt::format("rows followed {}, from {}", map_direction_name(origin.follow), from);
}

std::string map_model(const MapPlan& plan) {
  std::string text = title(plan.problem);
  char separator = ':';
  const auto& parameters = plan.problem.system.parameters;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const std::string& name = parameters[i].name;
    if (name == plan.grid.columns.parameter || name == plan.grid.rows.parameter) continue;
    text += fmt::format("{} {} = {}", separator, name, rounded(plan.problem.parameters[static_cast<Eigen::Index>(i)], 8));
    separator = ',';
  }
  return text;
}

std::string map_overview(const MapPlan& plan, const std::vector<MapCounts>& counts) {
  const ParameterGrid& grid = plan.grid;
  const auto values = [](const ParameterAxis& axis) { return counted(static_cast<std::size_t>(axis.count), "value"); };
  std::string text = fmt::format("{} from {} to {}, {}; {} from {} to {}, {}\n", grid.columns.parameter, exact(grid.columns.from),
                                 exact(grid.columns.to), values(grid.columns), grid.rows.parameter, exact(grid.rows.from),
                                 exact(grid.rows.to), values(grid.rows));
  const double points = plan.points() / plan.layers();
  for (int layer = 0; layer < plan.layers(); ++layer) {
    std::map<std::string, std::size_t> names;  // one name for all numbers of impacts of sticking motions
    for (const auto& [kind, count] : counts[static_cast<std::size_t>(layer)]) names[map_point_name(kind)] += count;
    const auto list = ranked(names);
    Table table{{"attractor", "points", "%"}, {}};
    std::size_t others = 0;
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (i + 1 > most_lines && list.size() > most_lines + 1)
        others += list[i].second;
      else
        table.rows.push_back({list[i].first, std::to_string(list[i].second),
                              fmt::format("{:.2f}", 100.0 * static_cast<double>(list[i].second) / points)});
    }
    if (others > 0)
      table.rows.push_back({fmt::format("{} others", list.size() - most_lines), std::to_string(others),
                            fmt::format("{:.2f}", 100.0 * static_cast<double>(others) / points)});
    text += fmt::format("\n{}\n{}", layer_name(plan, layer), aligned(table));
  }
  return text;
}

Json map_json(const MapPlan& plan, const std::vector<MapCounts>& counts, const MapRows& rows) {
  Json layers = Json::array();
  for (int layer = 0; layer < plan.layers(); ++layer) {
    const LayerOrigin origin = layer_origin(plan, layer);
    layers.push_back({{"start", origin.start ? to_json(*origin.start) : Json(nullptr)},
                      {"follow", map_direction_name(origin.follow)},
                      {"counts", counts_json(counts[static_cast<std::size_t>(layer)])}});
  }
  const int columns = plan.grid.columns.count;
  for (int row = 0; row < plan.grid.rows.count; ++row) {
    const std::vector<MapPoint> points = rows(row);
    for (int layer = 0; layer < plan.layers(); ++layer)
      add_row(layers[static_cast<std::size_t>(layer)], plan, points.data() + static_cast<std::ptrdiff_t>(layer) * columns);
  }
  return layers;
}

Json map_schema() {
  const Json count = JsonForm<int>::schema();
  const Json kind = object_schema({{"type", "of the points", JsonForm<MapType>::schema()},
                                   {"period", "of periodic ones", count, false},
                                   {"impacts", "of periodic ones", count, false},
                                   {"sticking", "true: the mass sticks in every turn", JsonForm<bool>::schema(), false},
                                   {"points", "number of points", count}});
  std::vector<Member> layer = {{"start", "of every row or point; null: at rest", JsonForm<std::optional<Vector>>::schema()},
                               {"follow", "way along the rows", {{"enum", {"none", "up", "down"}}}},
                               {"counts", "of kinds of points", list_schema(kind)}};
  for (const Column<MapPoint>& one : map_columns())
    layer.push_back({one.name, one.meaning, list_schema(list_schema(one.schema)), true, one.unit});
  const Json values = {{"type", "object"},
                       {"additionalProperties", list_schema(list_schema(JsonForm<std::optional<double>>::schema()))}};
  layer.push_back({"y", "quantities that --y asks for", values, false});
  return object_schema({{"layers", "the grid from each start, by row and column", list_schema(object_schema(layer))}});
}

MapRows rows_from_json(const MapPlan& plan, const Json& result) {
  const Json& layers = result.at("layers");
  const auto count = [](const Json& json) { return static_cast<int>(json.size()); };
  bool fits = count(layers) == plan.layers();
  for (const Json& layer : layers) {
    fits = fits && count(layer.at("type")) == plan.grid.rows.count;
    for (const Json& row : layer.at("type")) fits = fits && count(row) == plan.grid.columns.count;
  }
  if (!fits) throw std::invalid_argument("this map does not have the points that its options name");
  return [layers, fields = plan.fields, columns = plan.grid.columns.count](int row) {
    std::vector<MapPoint> points;
    for (const Json& layer : layers)
      for (int column = 0; column < columns; ++column) {
        MapPoint point;
        for (const Column<MapPoint>& one : map_columns())
          if (one.needed || layer.contains(one.name)) one.set(point, layer.at(one.name).at(row).at(column));
        for (const MapField& one : fields)
          if (one.of_quantity()) one.column.set(point, layer.at("y").at(one.column.name).at(row).at(column));
        points.push_back(std::move(point));
      }
    return points;
  };
}

void map_csv(const MapPlan& plan, const MapRows& rows, int threads, const TextSink& sink) {
  const ParameterGrid& grid = plan.grid;
  Table head{{"layer", grid.rows.parameter, grid.columns.parameter}, {}};
  for (const MapField& field : plan.fields) {
    if (field.of_states())
      add_given_headings(head, state_columns(plan.problem));
    else if (field.of_quantity())
      add_quantity_column(head, field.column.name);
    else
      add_heading(head, field.column.name);
  }
  sink(csv(head));
  std::vector<std::string> columns;
  for (int column = 0; column < grid.columns.count; ++column) columns.push_back(exact(grid.columns.at(column)));
  const auto write = [&](int row, const std::vector<MapPoint>& points) {
    std::string lines;
    const auto out = std::back_inserter(lines);
    const std::string value = exact(grid.rows.at(row));
    for (std::size_t i = 0; i < points.size(); ++i) {
      const MapPoint& point = points[i];
      fmt::format_to(out, FMT_COMPILE("{},{},{}"), i / columns.size(), value, columns[i % columns.size()]);
      for (const MapField& field : plan.fields)
        append_cells(lines, field.column, point, field.of_states() ? plan.problem.system.states : 1);
      lines += '\n';
    }
    return lines;
  };
  const int together = 16 * std::max(threads, 1);
  for (int first = 0; first < grid.rows.count; first += together) {
    std::vector<std::vector<MapPoint>> points;
    for (int row = first; row < std::min(first + together, grid.rows.count); ++row) points.push_back(rows(row));
    std::vector<std::string> lines(points.size());
    in_parallel_on(threads, lines.size(), [&](std::size_t k) { lines[k] = write(first + static_cast<int>(k), points[k]); });
    for (const std::string& text : lines) sink(text);
  }
}

}  // namespace graze::apps
