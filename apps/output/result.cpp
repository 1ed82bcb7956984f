// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/console/arguments.hpp>
#include <graze/apps/console/checkpoint_timer.hpp>
#include <graze/apps/console/output_file.hpp>
#include <graze/apps/drawing/draw_files.hpp>
#include <graze/apps/output/result.hpp>
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/text/json_member.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <functional>
#include <memory>
#include <stdexcept>

namespace graze::apps {

namespace {

/// Default format of pictures in a folder of results.
constexpr const char* folder_format = "png";

struct OutputFile {
  std::string file;
  LongText content;
};

/// The files that receive the JSON.
std::vector<std::string> json_files(const OutputOptions& options, const std::string& command) {
  std::vector<std::string> list;
  if (!options.json.empty() && options.json != "-") list.push_back(options.json);
  if (!options.out.empty()) list.push_back(fmt::format("{}/{}.json", options.out, command));
  return list;
}

void write_table(const Result& result, const TextSink& sink) {
  if (result.csv) return result.csv(sink);
  sink(csv(result.table));
}

/// The files to be written, each with its content.
std::vector<OutputFile> files(const Result& result, const OutputOptions& options, const std::string& command, int threads) {
  std::vector<OutputFile> list;
  const auto table = [&result](const TextSink& sink) { write_table(result, sink); };
  for (const std::string& file : json_files(options, command))
    list.push_back({file, [&result, threads](const TextSink& sink) { pretty(result.json, result.list, threads, sink); }});
  if (!options.csv.empty() && options.csv != "-") list.push_back({options.csv, table});
  if (!options.out.empty()) list.push_back({fmt::format("{}/{}.csv", options.out, command), table});
  return list;
}

std::vector<Drawing> drawings(const Result& result, const OutputOptions& options, const std::string& command, int threads) {
  if (options.plot.empty() && options.out.empty()) return {};
  std::shared_ptr<const Json> whole(std::shared_ptr<const Json>(), &result.json);
  if (!result.list.name.empty()) whole = std::make_shared<const Json>(with_items(result.json, result.list, threads));
  std::vector<Drawing> list;
  const auto add = [&](const std::string& file, const std::string& kind) {
    list.push_back({file, [whole, kind] { return picture_of(*whole, kind); }});
  };
  if (!options.plot.empty()) add(options.plot, options.plot_kind);
  if (!options.out.empty())
    for (const std::string& kind : pictures_for(*whole))
      add(fmt::format("{}/{}-{}.{}", options.out, command, kind, folder_format), kind);
  return list;
}

/// The last line of an interrupted run's text.
std::string unfinished(const Json& json) {
  const bool is_whole = text_of(json, "status") != status_name(Status::interrupted);
  return is_whole || !json.contains("message") ? "" : fmt::format("\nnot finished: {}\n", json["message"].get<std::string>());
}

}  // namespace

void add_output_options(CLI::App& app, OutputOptions& options, const std::string& schema, const std::string& other) {
  begin_group(app, "Results");
  add_text(app, "--json", options.json, "FILE|-", "result as JSON, to a file or to stdout (then nothing else goes there)");
  add_text(app, "--csv", options.csv, "FILE|-", "result as a table, to a file or to stdout");
  std::vector<std::string> kinds = picture_names("graze." + schema);
  for (const std::string& kind : picture_names("graze." + other))
    if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end()) kinds.push_back(kind);
  options.pictures = !kinds.empty();
  if (options.pictures) add_text(app, "--plot", options.plot, "FILE", "picture of the result (.png, .svg, .pdf)");
  if (kinds.size() > 1)
    add_choice(app, "--plot-kind", options.plot_kind, kinds, fmt::format("kind of picture (default {})", kinds.front()));
  add_text(app, "--out", options.out, "DIR",
           options.pictures ? "folder that gets JSON, table and all pictures" : "folder that gets JSON and table");
  add_flag(app, "--overwrite", options.overwrite,
           "replace the result of another run in --out DIR; without, it is kept and the run refused");
}

bool wants_json(const OutputOptions& options) { return !options.json.empty() || !options.plot.empty() || !options.out.empty(); }

bool writes_files(const OutputOptions& options) { return wants_json(options) || !options.csv.empty(); }

bool wants_table(const OutputOptions& options) { return !options.csv.empty() || !options.out.empty(); }

void check_outputs(const OutputOptions& options, const std::string& input) {
  if (options.json == "-" && options.csv == "-") throw std::invalid_argument("--json - and --csv - cannot both go to stdout");
  if (!options.plot_kind.empty() && options.plot.empty() && options.out.empty())
    throw std::invalid_argument(fmt::format("--plot-kind {}: there is no picture; give --plot FILE too", options.plot_kind));
  for (const std::string& file : {options.json, options.csv, options.plot})
    if (!file.empty() && file != "-") check_writable(file);
  if (!options.plot.empty()) check_picture_file(options.plot);
  check_distinct({{"--json", options.json}, {"--csv", options.csv}, {"--plot", options.plot}}, input);
  check_kind("--json", options.json, {".json"});
  check_kind("--csv", options.csv, {".csv"});
}

std::optional<double> checkpoint_interval(const OutputOptions& options) {
  const bool kept = !options.out.empty() || (!options.json.empty() && options.json != "-" && !is_special(options.json));
  return kept ? std::optional(interval_length()) : std::nullopt;
}

void keep(const Json& part, const OutputOptions& options, const std::string& command, const Console& console,
          const LongList& list) {
  for (const std::string& file : json_files(options, command)) {
    if (is_special(file)) continue;  // a pipe receives one result only
    const auto text = [&](const TextSink& sink) { pretty(part, list, console.thread_count(), sink); };
    if (const auto failure = write_whole(file, text)) console.err << "graze " << command << ": " << *failure << "\n";
  }
}

std::string resume_advice(Status status, const OutputOptions& options) {
  if (status != Status::interrupted || options.out.empty()) return "";
  return fmt::format("; --resume {} goes on from there", options.out);
}

int deliver(const Result& result, const OutputOptions& options, const std::string& command, int code, const Console& console) {
  bool complete = true;
  const auto complain = [&](const std::string& sentence) {
    complete = false;
    console.err << "graze " << command << ": " << sentence << "\n";
  };
  // Files first: if stdout is a pipe that closes early, they are already written. Pictures last: a launcher that has told the
  // program to end allows it only a limited time.
  const int threads = console.thread_count();
  for (const OutputFile& output : files(result, options, command, threads)) {
    try {
      if (const auto failure = write_whole(output.file, output.content)) complain(*failure);
    } catch (const std::exception& error) {
      complain(fmt::format("{}: {}", output.file, error.what()));
    }
  }
  if (!draw_into_files(drawings(result, options, command, threads), console, complain)) code = 130;
  errno = 0;
  const TextSink out = [&console](std::string_view piece) { console.out << piece; };
  if (options.json == "-")
    pretty(result.json, result.list, threads, out);
  else if (options.csv == "-")
    write_table(result, out);
  else
    out(result.text + unfinished(result.json));
  console.out << std::flush;
  if (!console.out) complain(cannot_write_stdout(errno));
  return complete || code != 0 ? code : 2;
}

}  // namespace graze::apps
