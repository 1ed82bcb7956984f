// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/map/map_report.hpp>
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/pictures/shown_quantity.hpp>
#include <graze/apps/pictures/written_result.hpp>
#include <graze/apps/problem/head.hpp>
#include <graze/apps/results/input_file.hpp>
#include <graze/lib/equations/source.hpp>

#include <fmt/format.h>

#include <stdexcept>

namespace graze::apps {

namespace {

Picture picture_of_table(const std::string& text, const std::string& file, const ResultView& view) {
  if (!view.kind.empty()) throw std::invalid_argument("--plot-kind is for JSON results; of a table, --x and --y choose columns");
  if (!view.layers.empty())
    throw std::invalid_argument("--layer is for maps as .h5 or .json; of a table, --x and --y choose columns");
  if (!view.plane.empty()) throw std::invalid_argument("--plane is for JSON results; of a table, --x and --y choose columns");
  return picture_of(parse_csv(text, file), view.x, view.y);
}

Picture picture_of_json(const std::string& text, const ResultView& view) {
  if (!view.x.empty()) throw std::invalid_argument("--x is for CSV tables");
  Json result = parse_json(text);
  const bool map = schema_of(result) == "graze.map/1";
  if (!view.y.empty() && !map) result = with_quantities(std::move(result), view.y);
  if (!view.plane.empty()) result[shown_plane] = plane_of(problem_of(result), view.plane);
  if (!map && !view.layers.empty())
    throw std::invalid_argument("--layer chooses a layer of a map, and this is none; leave it away");
  if (!map) return picture_of(result, view.kind);
  const MapPlan plan = plan_of(result);
  return picture_of_map(plan, rows_from_json(plan, result), map_view(view));
}

}  // namespace

MapView map_view(const ResultView& view) {
  if (view.y.size() > 1) throw std::invalid_argument("--y is given twice; the picture of a map shows one quantity");
  const std::string kind = view.y.empty() ? view.kind : "quantity";
  if (!view.kind.empty() && view.kind != kind)
    throw std::invalid_argument(fmt::format("--y shows a quantity; leave --plot-kind {} away", view.kind));
  return {kind, view.y.empty() ? std::string() : view.y.front(), layer_numbers(view.layers)};
}

Picture picture_of_text(const std::string& text, const std::string& file, const ResultView& view) {
  const std::string format = ending(file);
  try {
    if (format == "csv") return picture_of_table(text, file, view);
    if (format != "json") throw std::invalid_argument("the name must end in .json, .csv or .h5");
    return picture_of_json(text, view);
  } catch (const Json::exception& error) {
    throw std::invalid_argument(fmt::format("{}: the picture cannot be drawn: {}", file, plain(error)));
  } catch (const equations::EquationError& error) {  // its line is one of a text within the result
    throw std::invalid_argument(fmt::format("{}: {}", file, error.sentence()));
  } catch (const std::invalid_argument& error) {
    const std::string message = error.what();  // that of a table names file and line itself
    throw std::invalid_argument(message.starts_with(file + ":") ? message : file + ": " + message);
  }
}

}  // namespace graze::apps
