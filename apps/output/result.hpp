// SPDX-License-Identifier: GPL-3.0-or-later
// Result: what a command hands over at its end, and the options that say where it goes: --json, --csv, --plot, --out.
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
  LongList list = {};  ///< one of its members
  Table table;         ///< for --csv
  LongText csv = {};   ///< its text, where it is too long to be a Table
  std::string text;    ///< for people
};

struct OutputOptions {
  std::string json, csv;   ///< files, or "-" for stdout
  std::string plot;        ///< picture; its ending says the format
  std::string plot_kind;   ///< empty: the first that fits the result
  std::string out;         ///< folder for all of it
  bool overwrite = false;  ///< of another result in it
  bool pictures = true;    ///< whether its results have any
};

/// Adds --json, --csv, --plot, --out; and --plot-kind where pictures of `schema` come in several kinds. `other`: a second schema
/// that the command may give its result in; its kinds are allowed too.
void add_output_options(CLI::App& app, OutputOptions& options, const std::string& schema, const std::string& other = {});

/// Finds out before anything is computed whether all output files can be written, and none of them over another or over the
/// `input`. Of the folder see OutputFolder.
/// @throws std::invalid_argument.
void check_outputs(const OutputOptions& options, const std::string& input = {});

/// Whether the result goes anywhere but, as a text, to stdout.
bool writes_files(const OutputOptions& options);

/// Whether all of its JSON goes anywhere, or into a picture; whether its table goes anywhere.
bool wants_json(const OutputOptions& options);
bool wants_table(const OutputOptions& options);

/// How long a stint (stints.hpp) is in seconds, after which keep() has something to do; nullopt: it never has.
std::optional<double> keeping_stints(const OutputOptions& options);

/// Writes the JSON files, and nothing else, with what there is by now. One that cannot be written is told on console.err.
void keep(const Json& part, const OutputOptions& options, const std::string& command, const Console& console,
          const LongList& list = {});

/// What to add to the message of a run that was interrupted and can be gone on with: "; --resume DIR goes on from there". Else
/// nothing.
std::string how_to_go_on(Status status, const OutputOptions& options);

/// Writes the files, then prints the result on console.out: the text, or the JSON or CSV if that was sent there. Returns `code`,
/// or instead of 0, 2 if something could not be written (each with a sentence on console.err), 130 if drawing was interrupted.
int deliver(const Result& result, const OutputOptions& options, const std::string& command, int code, const Console& console);

}  // namespace graze::apps
