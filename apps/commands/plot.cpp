// SPDX-License-Identifier: GPL-3.0-or-later
// graze plot: a picture of a result written earlier.
#include <graze/apps/commands/command.hpp>
#include <graze/apps/console/arguments.hpp>
#include <graze/apps/console/output_file.hpp>
#include <graze/apps/pictures/maps.hpp>
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/pictures/written_result.hpp>
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

struct PlotArguments {
  std::string result, output;
  ResultView view;
};

Picture picture_of_map_file(const PlotArguments& options) {
  if (!options.view.x.empty()) throw std::invalid_argument("--x is for CSV tables");
  if (!options.view.plane.empty()) throw std::invalid_argument("--plane is for motions and orbits; a map has none");
  MapFile file(options.result);
  return picture_of_map(
      file.plan(), [&file](int row) { return file.row(row); }, map_view(options.view));
}

Picture picture_of_file(const PlotArguments& options) {
  const std::string format = ending(options.result);
  if (format == "h5" || format == "hdf5") return picture_of_map_file(options);
  return picture_of_text(read_whole(options.result), options.result, options.view);
}

int run(const PlotArguments& options, const Console& console) {
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

std::function<int(const Console&)> set_up_plot(CLI::App& app) {
  auto options = std::make_shared<PlotArguments>();
  begin_group(app, "Picture");
  add_text(app, "RESULT", options->result, "FILE", "a result of graze (.json), a table (.csv) or a map (.h5)", Need::required);
  add_text(app, "-o,--output", options->output, "FILE", "the picture (.png, .svg, .pdf)", Need::required);
  add_text(app, "--plot-kind", options->view.kind, "KIND", "kind of picture (default: the first of its schema)");
  add_texts(app, "--layer", options->view.layers, "K",
            "of a map: a layer, counted from 0; repeatable, up to 4 stand side by side (default: the first 4)");
  add_text(app, "--plane", options->view.plane, "A,B",
           "of motions and orbits: the states on the axes of a phase portrait, the first that of a time series (default: a "
           "position and its velocity)");
  add_text(app, "--x", options->view.x, "COLUMN", "of a table: the horizontal axis (default: the first column of numbers)");
  add_texts(app, "--y", options->view.y, "COLUMN",
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
          set_up_plot};
}

}  // namespace graze::apps
