// SPDX-License-Identifier: GPL-3.0-or-later
// Result: the complete output of a command, and the options that select its destinations: --json, --csv, --plot, --out.
#pragma once

#include <graze/apps/console/console.hpp>
#include <graze/apps/problem/head.hpp>
#include <graze/apps/text/table.hpp>

#include <functional>
#include <optional>
#include <string>

namespace CLI {
class App;
}

namespace graze::apps {

struct Result {  // NOLINT(bugprone-exception-escape): of nlohmann's move constructor
  Json json;
  LongList list = {};  ///< one of the JSON's members
  Table table;         ///< for --csv
  LongText csv = {};   ///< the CSV text, if it is too long for a Table
  std::string text;    ///< for people
};

struct OutputOptions {
  std::string json, csv;   ///< files, or "-" for stdout
  std::string plot;        ///< picture; its file ending selects the format
  std::string plot_kind;   ///< empty: the first kind that fits the result
  std::string out;         ///< folder for all outputs
  bool overwrite = false;  ///< another result in that folder
  bool pictures = true;    ///< whether the results of this command have pictures
};

/// Adds --json, --csv, --plot, --out, and --plot-kind if there are several kinds of pictures of `schema` ("orbit/1"). `other`: a
/// second schema in which the command may write its result; its kinds are allowed as well.
void add_output_options(CLI::App& app, OutputOptions& options, const std::string& schema, const std::string& other = {});

/// Checks before anything is computed that all output files can be written, and that none overwrites another or the `input`.
/// For the folder see OutputFolder.
/// @throws std::invalid_argument.
void check_outputs(const OutputOptions& options, const std::string& input = {});

/// Whether the result goes anywhere else than, as text, to stdout.
bool writes_files(const OutputOptions& options);

/// Whether any output needs the whole JSON (a file or a picture), and whether any needs the table.
bool wants_json(const OutputOptions& options);
bool wants_table(const OutputOptions& options);

/// Shortest time between checkpoints in seconds (checkpoint_timer.hpp); nullopt: keep() has nothing to write.
std::optional<double> checkpoint_interval(const OutputOptions& options);

/// Writes the JSON files only, with the results so far. A file that cannot be written is reported on console.err.
void keep(const Json& part, const OutputOptions& options, const std::string& command, const Console& console,
          const LongList& list = {});

/// The addition to the message of an interrupted run that can be resumed: "; --resume DIR goes on from there". Otherwise empty.
std::string resume_advice(Status status, const OutputOptions& options);

/// Writes the files, then prints the result on console.out: the text, or the JSON or CSV if that was directed to stdout.
/// Returns `code`. Instead of 0 it returns 2 if something could not be written (each with a sentence on console.err), and 130
/// if drawing was interrupted.
int deliver(const Result& result, const OutputOptions& options, const std::string& command, int code, const Console& console);

}  // namespace graze::apps
