// SPDX-License-Identifier: GPL-3.0-or-later
// graze map: the attractor and its first exponent at every point of a grid over two parameters; threads, or MPI.
#include <graze/apps/commands/command.hpp>
#include <graze/apps/console/arguments.hpp>
#include <graze/apps/console/interrupt.hpp>
#include <graze/apps/console/output_file.hpp>
#include <graze/apps/drawing/draw_files.hpp>
#include <graze/apps/map/map_report.hpp>
#include <graze/apps/map/map_run.hpp>
#include <graze/apps/output/result.hpp>
#include <graze/apps/pictures/maps.hpp>
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/problem/axis.hpp>
#include <graze/apps/problem/flow_choice.hpp>
#include <graze/apps/results/find_orbit.hpp>
#include <graze/apps/results/run_identity.hpp>
#include <graze/apps/text/number.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <mutex>
#include <stdexcept>

namespace graze::apps {

namespace {

struct MapArguments {
  StartOptions start;  // problem, settings, settle
  std::vector<std::string> parameters, starts, layers, quantities;
  std::string follow = "none", resume, h5;
  bool overwrite = false;
  MapOptions map;
  std::optional<double> standard_error;
  std::optional<int> chunk_rows, transient;
  FlowChoice flow;
  OutputOptions output;
};

/// An axis with both ends in the parameter's range.
ParameterAxis parse_parameter(const Problem& problem, const std::string& text) {
  const auto [name, axis] = parse_named_axis("--param", text);
  for (const double end : {axis.from, axis.to}) try {
      Problem at = problem;
      set_parameter(at, name, end);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(fmt::format("--param {}: {}", text, error.what()));
    }
  return {name, axis.from, axis.to, axis.count};
}

/// Rows per chunk: up to a few thousand points, but enough chunks to distribute.
int rows_of_a_chunk(const ParameterGrid& grid) {
  const int columns = std::max(1, grid.columns.count), rows = std::max(1, grid.rows.count);
  return std::clamp(std::min(4096 / columns, rows / 8), 1, 16);
}

MapPlan plan_from(const MapArguments& options, const Console& console) {
  MapPlan plan;
  if (options.parameters.size() != 2)
    throw std::invalid_argument(
        fmt::format("--param is {}; a map is over two parameters, for example --param eta:0.65:0.95:200 --param r:1:3:150",
                    options.parameters.empty() ? "not given" : "given " + counted(options.parameters.size(), "time")));
  std::vector<std::string> names;
  for (const std::string& text : options.parameters) names.push_back(text.substr(0, text.find(':')));
  plan.problem = open_problem(options.start, console, names);
  plan.grid = {parse_parameter(plan.problem, options.parameters[0]), parse_parameter(plan.problem, options.parameters[1])};
  if (!options.starts.empty()) plan.starts.clear();
  for (const std::string& text : options.starts) {
    const std::optional<StateText> state = parse_state(text);
    if (!state) throw std::invalid_argument(fmt::format("--start {}: must be {}", text, state_form(text)));
    plan.starts.emplace_back(state_of(plan.problem, *state));
  }
  if (options.starts.empty() && plan.problem.start) plan.starts = {plan.problem.start};
  plan.follow = options.follow;
  plan.options = options.map;
  set_quantities(plan, options.quantities);
  if (options.transient && options.follow == "none")
    throw std::invalid_argument(
        "--transient is of rows that are followed; give --follow up, down or both too (--settle is of starts)");
  if (options.transient) plan.options.transient = *options.transient;
  plan.options.flow.kind = options.flow.kind();
  plan.options.settle = settle_of(plan.problem, options.start);
  if (options.standard_error) plan.options.standard_error = *options.standard_error;
  if (!(plan.options.standard_error > 0.0))
    throw std::invalid_argument(fmt::format("--standard-error is {}; allowed is > 0", exact(plan.options.standard_error)));
  plan.chunk_rows = options.chunk_rows.value_or(rows_of_a_chunk(plan.grid));
  check_plan(plan);
  return plan;
}

/// The rows of finished chunks; points of the others are marked as not computed.
MapRows rows_of(const MapStore& store) {
  return [&store, number = -1, chunk = MapChunk()](int row) mutable {
    const MapPlan& plan = store.plan();
    const int wanted = plan.chunk_of(row);
    if (wanted != number) {
      chunk = store.has(wanted) ? store.chunk(wanted) : MapChunk();
      number = wanted;
    }
    const std::size_t size = static_cast<std::size_t>(plan.layers()) * static_cast<std::size_t>(plan.grid.columns.count);
    if (chunk.points.empty()) {
      MapPoint none;
      none.state = Vector::Constant(static_cast<Eigen::Index>(plan.problem.system.states), std::nan(""));
      return std::vector<MapPoint>(size, none);
    }
    const auto begin = chunk.points.begin() + static_cast<std::ptrdiff_t>(size) * (row - chunk.first_row);
    return std::vector<MapPoint>(begin, begin + static_cast<std::ptrdiff_t>(size));
  };
}

/// Checks an HDF5 output, which must be a regular file.
void check_map_file(const std::string& option, const std::string& file) {
  if (file == "-") throw std::invalid_argument(option + " -: HDF5 does not go to stdout; give a file name, for example map.h5");
  check_kind(option, file, {".h5", ".hdf5"});
  check_regular(option, file);
  check_writable(file);
}

void check_all_outputs(const MapArguments& options, const MapPlan& plan) {
  if (!options.output.out.empty()) make_folder(options.output.out);
  OutputOptions output = options.output;
  if (!output.out.empty()) output.plot_kind.clear();
  output.out.clear();
  check_outputs(output, options.start.file);
  if (!options.h5.empty()) check_map_file("--h5", options.h5);
  check_layers(plan, layer_numbers(options.layers));
  if (options.output.plot_kind == "quantity" && plan.quantities.empty())
    throw std::invalid_argument("--plot-kind quantity: there is none; give --y too, for example --y \"max(x)\"");
  if (!options.layers.empty() && options.output.plot.empty() && options.output.out.empty())
    throw std::invalid_argument("--layer chooses the layers of a picture; give --plot FILE or --out DIR too");
  check_distinct({{"--h5", options.h5}, {"--json", output.json}, {"--csv", output.csv}, {"--plot", output.plot}},
                 options.start.file);
  if (!output.json.empty() && plan.points() > most_points_in_json)
    throw std::invalid_argument(fmt::format(
        "--json: {:.0f} points are too many for it, a million are allowed; take --h5, --out or --csv", plan.points()));
  if (!options.output.out.empty()) check_map_file("--out", options.output.out + "/map.h5");
}

/// The HDF5 files of the map: --h5, and the one in the folder.
std::vector<std::string> map_files(const MapArguments& options) {
  std::vector<std::string> files;
  if (!options.output.out.empty()) files.push_back(options.output.out + "/map.h5");
  std::error_code error;
  const auto place = [&error](const std::string& file) { return std::filesystem::weakly_canonical(file, error); };
  if (!options.h5.empty() && (files.empty() || place(options.h5) != place(files.front()))) files.push_back(options.h5);
  return files;
}

/// Writes pictures, JSON, table and text. `counts`: if already known. Returns the exit code.
int present(const MapArguments& options, const MapPlan& plan, const Json& head, const MapRows& rows,
            std::vector<MapCounts> counts, const MapRun& run, const Console& console) {
  int code = run.unwritable ? 2 : exit_code(run.status);
  const auto complain = [&](const std::string& sentence) {
    console.err << "graze map: " << sentence << "\n";
    if (code == 0) code = 2;
  };
  const std::vector<int> layers = layer_numbers(options.layers);
  std::mutex reading;  // the rows are read from one file
  std::vector<Drawing> drawings;
  const auto add = [&](const std::string& file, const std::string& kind, const std::string& quantity = {}) {
    drawings.push_back({file, [&, kind, quantity] {
                          const std::lock_guard lock(reading);
                          return picture_of_map(plan, rows, {kind, quantity, layers});
                        }});
  };
  const bool quantities = !plan.quantities.empty();
  if (!options.output.plot.empty())
    add(options.output.plot, quantities && options.output.plot_kind.empty() ? "quantity" : options.output.plot_kind);
  if (!options.output.out.empty() && run.status == Status::done) {
    for (const char* kind : {"attractors", "exponent"}) add(fmt::format("{}/map-{}.png", options.output.out, kind), kind);
    for (std::size_t i = 0; i < plan.quantities.list.size(); ++i)
      add(fmt::format("{}/map-y{}.png", options.output.out, i + 1), "quantity", plan.quantities.list[i].text);
  }
  if (!draw_into_files(drawings, console, complain)) code = 130;
  if (counts.empty()) counts = count_map(plan, rows);
  Result result;
  result.json = head;
  set_status(result.json, run.status, run.message);
  OutputOptions rest;
  rest.json = options.output.json;
  rest.csv = options.output.csv;
  if (!rest.json.empty()) result.json["layers"] = map_json(plan, counts, rows);
  result.csv = [&](const TextSink& sink) { map_csv(plan, rows, console.thread_count(), sink); };
  result.text = map_model(plan) + "\n\n" + map_overview(plan, counts);
  return deliver(result, rest, "map", code, console);
}

/// The finished map of this run, if it already exists.
std::optional<MapFile> finished_map(const MapArguments& options, const Json& head) {
  const std::string file = options.resume + "/map.h5";
  if (options.resume.empty() || !std::filesystem::exists(file) || std::filesystem::exists(options.resume + "/chunks/run.json"))
    return std::nullopt;
  MapFile map(file);
  if (const auto found = difference(map.head(), head, map_identity_parts))
    throw std::invalid_argument(fmt::format("--resume: {} is of another run: {}; give the same", file, *found));
  return map;
}

/// Whether an output takes an unfinished map: HDF5 files hold only finished ones.
bool wants_part(const MapArguments& options) {
  return !options.output.json.empty() || !options.output.csv.empty() || !options.output.plot.empty();
}

/// Tells the user the fate of an unfinished map without a folder.
std::string without_folder(const MapArguments& options) {
  std::string text = "they are lost without --out DIR";
  if (wants_part(options)) {
    std::vector<std::string> outputs;
    for (const auto& [option, file] :
         {std::pair{"--json", options.output.json}, {"--csv", options.output.csv}, {"--plot", options.output.plot}})
      if (!file.empty()) outputs.emplace_back(option);
    text = fmt::format("they go to {} and cannot be gone on with; --out DIR would keep them", fmt::join(outputs, " and "));
  }
  return options.h5.empty() ? text : text + "; --h5 is for whole maps and is not written";
}

MapBeginning beginning_of(const MapArguments& options) {
  if (!options.resume.empty()) return MapBeginning::resuming;
  return options.overwrite ? MapBeginning::overwriting : MapBeginning::anew;
}

int lead(const MapArguments& given, Ranks& ranks, const Console& console) {
  MapArguments options = given;
  if (!options.resume.empty() && !options.output.out.empty() && options.output.out != options.resume)
    throw std::invalid_argument("--resume DIR goes on in its own folder; leave --out away");
  if (options.overwrite && (!options.resume.empty() || options.output.out.empty()))
    throw std::invalid_argument("--overwrite replaces the finished map in --out DIR; give that, and no --resume");
  options.output.out = options.resume.empty() ? options.output.out : options.resume;
  const MapPlan plan = plan_from(options, console);
  const Json head = map_head(plan, options.start.settings);
  if (!options.resume.empty() && !std::filesystem::is_directory(options.resume))
    throw std::invalid_argument(fmt::format(
        "--resume: {}: no such folder; give the one that an interrupted run of graze map wrote with --out", options.resume));
  check_all_outputs(options, plan);
  if (auto map = finished_map(options, head)) {
    dismiss(ranks);
    console.note(options.resume + "/map.h5 is complete; nothing is left to compute");
    MapRun run;
    run.status = Status::done;
    return present(
        options, plan, head, [&map](int row) { return map->row(row); }, {}, run, console);
  }
  std::optional<MapStore> store;
  if (options.output.out.empty())
    store.emplace(plan, head, without_folder(options));
  else
    store.emplace(plan, head, options.output.out, beginning_of(options));
  if (!options.resume.empty()) {
    console.note(fmt::format("{} of {} chunks are there already", store->finished(), store->plan().chunks()));
    if (store->damaged() > 0)
      console.note(counted(static_cast<std::size_t>(store->damaged()), "damaged chunk") + " is computed again");
  }
  const int threads = console.threads > 0 || ranks.count() == 1 ? console.thread_count() : 1;
  const MapRows rows = rows_of(*store);
  std::vector<MapCounts> counts;
  const auto write = [&] {
    for (const std::string& file : map_files(options))
      if (const auto failure = write_map_file(file, plan, head, counting(plan, rows, counts), threads)) {
        console.err << fmt::format("graze map: {}; all chunks are finished, {}\n", *failure, store->advice());
        return false;
      }
    return true;
  };
  const MapRun run = run_map(*store, head, ranks, threads, console, write);
  if (run.status != Status::done || run.unwritable) {
    if (wants_part(options)) return present(options, plan, head, rows, {}, run, console);
    return run.unwritable ? 2 : exit_code(run.status);
  }
  if (map_files(options).empty()) return present(options, plan, head, rows, {}, run, console);
  store->remove();
  std::optional<MapFile> map;  // opened on first use
  const auto row_of_map = [&](int row) {
    if (!map) map.emplace(map_files(options).front());
    return map->row(row);
  };
  return present(options, plan, head, row_of_map, std::move(counts), run, console);
}

int run(const MapArguments& options, const Console& console) {
  Ranks ranks;
  const int helper_threads = console.threads > 0 ? console.threads : 1;
  if (ranks.rank() > 0) return run_map_helper(ranks, helper_threads);
  try {
    return lead(options, ranks, console);
  } catch (...) {
    dismiss(ranks);
    throw;
  }
}

Json map_result_schema() {
  return result_schema("map/1", "the attractor at each point of a grid over two parameters", {map_schema()});
}

std::function<int(const Console&)> set_up_map(CLI::App& app) {
  auto options = std::make_shared<MapArguments>();
  add_problem_options(app, options->start);
  begin_group(app, "Map");
  add_texts(app, "--param", options->parameters, "NAME:A:B:N",
            "N values of a parameter from A to B; given twice: columns, then rows of the map");
  add_texts(app, "--start", options->starts, "x,v",
            "initial state at forcing phase 0; repeatable, each is a layer of the map (default: the file's, else at rest)");
  add_choice(app, "--follow", options->follow, {"none", "up", "down", "both"},
             "along each row, a point starts from the last state of its neighbour (default none: each from the start)");
  add_count(app, "--chunk", options->chunk_rows, 1,
            "rows in a chunk; finished chunks are kept if the program is killed (default 1, up to 16 of short rows)");
  add_quantity_option(app, options->quantities);
  begin_group(app, "Motions");
  add_count(app, "--settle", options->start.settle, 0,
            "most forcing periods (returns without forcing) of transient from a start (default: the file's, else 1000); a stable "
            "orbit that is proved ends it");
  add_count(app, "--transient", options->transient, 0,
            "with --follow: most forcing periods (returns without forcing) of transient from a neighbour's state (default 300)");
  add_count(app, "--max-period", options->map.max_period, 1, "longest period that is recognised (default 64)", longest_period);
  add_count(app, "--periods", options->map.periods, 1,
            "most forcing periods (returns without forcing) of an average (default 5000)");
  add_number(app, "--standard-error", options->standard_error,
             "bound of lambda_1's standard error where it is averaged (default 3e-3, enough for its sign)");
  add_flow_option(app, options->flow);
  begin_group(app, "Results");
  add_text(app, "--out", options->output.out, "DIR", "folder that gets map.h5 and pictures, and meanwhile the finished chunks");
  add_flag(app, "--overwrite", options->overwrite, "replace another map in --out DIR; without, it is kept and the run refused");
  add_text(app, "--resume", options->resume, "DIR", "continue an interrupted or killed run with --out DIR");
  add_text(app, "--h5", options->h5, "FILE", "the map as HDF5");
  add_text(app, "--json", options->output.json, "FILE|-", "the map as JSON, up to a million points");
  add_text(app, "--csv", options->output.csv, "FILE|-", "the map as a table");
  add_text(app, "--plot", options->output.plot, "FILE", "picture of the map (.png, .svg, .pdf)");
  add_choice(app, "--plot-kind", options->output.plot_kind, picture_names("graze.map/1"),
             "kind of picture (default attractors, with --y quantity)");
  add_texts(app, "--layer", options->layers, "K",
            "a layer in the pictures, counted from 0; repeatable, up to 4 stand side by side (default: the first 4)");
  return [options](const Console& console) { return run(*options, console); };
}

}  // namespace

Command map_command() {
  return {
      "map",
      "a two-parameter map of attractors and first exponents, on all threads or under mpirun",
      "At each point: the type of attractor (stable orbits by Newton's method, exponents of their multipliers; the rest by time\n"
      "average), z = p/n and lambda_1. With --out, finished rows are kept in small files, and --resume continues an ended run.\n"
      "Under mpirun -n N the rows are handed out to N processes (of --threads each, 1 by default); the map is the same.",
      {"graze map data/problems/hertz-damped.toml --param eta:0.65:0.95:200 --param r:1:3:150 --out run",
       "graze map data/problems/newton-elastic.toml --param eta:0.65:0.95:90 --param r:1:3:60 --follow both --plot map.png",
       "mpirun -n 4 graze map data/problems/hertz-damped.toml --param eta:0.65:0.95:800 --param r:1:3:800 --out run"},
      set_up_map,
      {{"map", map_result_schema}}};
}

}  // namespace graze::apps
