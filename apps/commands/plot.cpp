// SPDX-License-Identifier: GPL-3.0-or-later
// graze plot: a picture of a result written earlier.
#include <graze/apps/commands/command.hpp>
#include <graze/apps/console/arguments.hpp>
#include <graze/apps/console/output_file.hpp>
#include <graze/apps/map/map_report.hpp>
#include <graze/apps/pictures/maps.hpp>
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/pictures/seen.hpp>
#include <graze/apps/problem/head.hpp>
#include <graze/apps/results/input_file.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <stdexcept>

namespace graze::apps {

namespace {

struct Options {
  std::string result, output, kind, x, plane;
  std::vector<std::string> y, layers;
};

/// The view of a map: --y names one of its quantities.
MapView view_of(const Options& options) {
  if (options.y.size() > 1) throw std::invalid_argument("--y is given twice; the picture of a map shows one quantity");
  const std::string kind = options.y.empty() ? options.kind : "quantity";
  if (!options.kind.empty() && options.kind != kind)
    throw std::invalid_argument(fmt::format("--y shows a quantity; leave --plot-kind {} away", options.kind));
  return {kind, options.y.empty() ? std::string() : options.y.front(), layer_numbers(options.layers)};
}

Picture picture_of_map_file(const Options& options) {
  if (!options.x.empty()) throw std::invalid_argument("--x is for CSV tables");
  if (!options.plane.empty()) throw std::invalid_argument("--plane is for motions and orbits; a map has none");
  MapFile file(options.result);
  return picture_of_map(
      file.plan(), [&file](int row) { return file.row(row); }, view_of(options));
}

Picture picture_of_result(const Json& result, const Options& options) {
  const bool map = result.value("schema", "") == "graze.map/1";
  if (!map && !options.layers.empty())
    throw std::invalid_argument("--layer chooses a layer of a map, and this is none; leave it away");
  if (!map) return picture_of(result, options.kind);
  const MapPlan plan = plan_of(result);
  return picture_of_map(plan, rows_from_json(plan, result), view_of(options));
}

Picture picture_of_file(const Options& options) {
  const std::string format = ending(options.result);
  if (format == "h5" || format == "hdf5") return picture_of_map_file(options);
  const std::string text = read_whole(options.result);
  try {
    if (format == "csv") {
      if (!options.kind.empty())
        throw std::invalid_argument("--plot-kind is for JSON results; of a table, --x and --y choose columns");
      if (!options.layers.empty())
        throw std::invalid_argument("--layer is for maps as .h5 or .json; of a table, --x and --y choose columns");
      if (!options.plane.empty())
        throw std::invalid_argument("--plane is for JSON results; of a table, --x and --y choose columns");
      return picture_of(parse_csv(text, options.result), options.x, options.y);
    }
    if (format != "json") throw std::invalid_argument("the name must end in .json, .csv or .h5");
    if (!options.x.empty()) throw std::invalid_argument("--x is for CSV tables");
    Json result = parse_json(text);
    if (!options.y.empty() && result.value("schema", "") != "graze.map/1") result = with_quantities(std::move(result), options.y);
    if (!options.plane.empty()) result[shown_plane] = plane_of(problem_of(result), options.plane);
    return picture_of_result(result, options);
  } catch (const std::invalid_argument& error) {
    const std::string message = error.what();  // the error of a table already names file and line
    throw std::invalid_argument(message.starts_with(options.result + ":") ? message : options.result + ": " + message);
  }
}

int run(const Options& options, const Console& console) {
  check_distinct({{"--output", options.output}}, options.result);
  check_writable(options.output);
  check_picture_file(options.output);
  if (!can_draw()) throw std::invalid_argument(fmt::format("{}: {}", options.output, cannot_draw));
  const std::string drawn = draw(picture_of_file(options), ending(options.output));
  if (const auto failure = write_whole(options.output, drawn)) {
    console.err << "graze plot: " << *failure << "\n";
    return 2;
  }
  return 0;
}

/// The kinds of pictures for the help, one line each: name, schema, summary.
std::string kinds_text() {
  std::string text = "Kinds of pictures:";
  for (const PictureKind& kind : picture_kinds())
    text += fmt::format("\n  {:<12} of {:<20} {}", kind.name, kind.schema, kind.summary);
  return text;
}

std::function<int(const Console&)> setup(CLI::App& app) {
  auto options = std::make_shared<Options>();
  begin_group(app, "Picture");
  add_text(app, "RESULT", options->result, "FILE", "a result of graze (.json), a table (.csv) or a map (.h5)", Need::required);
  add_text(app, "-o,--output", options->output, "FILE", "the picture (.png, .svg, .pdf)", Need::required);
  add_text(app, "--plot-kind", options->kind, "KIND", "what it shows (default: the first of its schema)");
  add_texts(app, "--layer", options->layers, "K",
            "of a map: a layer, counted from 0; repeatable, up to 4 stand side by side (default: the first 4)");
  add_text(app, "--plane", options->plane, "A,B",
           "of motions and orbits: the states on the axes of a phase portrait, the first that of a time series (default: a "
           "position and its velocity)");
  add_text(app, "--x", options->x, "COLUMN", "of a table: the horizontal axis (default: the first column of numbers)");
  add_texts(app, "--y", options->y, "COLUMN",
            "of a table: a curve (default: all columns of numbers); of a JSON result: one of its quantities (default: all); "
            "repeatable; of a map: the quantity that it shows");
  return [options](const Console& console) { return run(*options, console); };
}

}  // namespace

Command plot_command() {
  return {"plot",
          "a picture of a result",
          kinds_text(),
          {"graze plot branch.json -o branch.svg", "graze plot branch.json --plot-kind multipliers -o multipliers.png",
           "graze plot orbit.json --plane x2,v2 -o second_mass.png", "graze plot branch.json --y \"max(x)\" -o resonance.png",
           "graze plot trajectory.csv --x x --y v -o phase.pdf", "graze plot run/map.h5 -o map.png",
           "graze plot run/map.h5 --plot-kind exponent --layer 4 --layer 5 -o exponent.png"},
          setup};
}

}  // namespace graze::apps
