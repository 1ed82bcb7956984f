// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/console/output_file.hpp>
#include <graze/apps/results/input_file.hpp>
#include <graze/apps/results/run_identity.hpp>
#include <graze/apps/text/json_member.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <stdexcept>

namespace graze::apps {

namespace {

/// The schemas of a command's results that --resume accepts.
std::vector<std::string> schemas_of(const std::string& command) {
  std::vector<std::string> list = {fmt::format("graze.{}/1", command)};
  if (command == "diagram") list.emplace_back("graze.branch/1");  // the skeleton only
  return list;
}

}  // namespace

std::string read_whole(const std::string& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) throw std::invalid_argument(file + ": no such file");
  if (std::filesystem::is_directory(file, error)) throw std::invalid_argument(file + ": is a folder, not a result");
  if (!std::filesystem::is_regular_file(file, error))
    throw std::invalid_argument(file + ": is not a regular file; a result is read from one, not from a pipe or a device");
  std::ifstream stream(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (!stream.is_open() || stream.bad()) throw std::invalid_argument(file + ": cannot be read");
  return text;
}

namespace {

/// Lists and objects inside one another: results have some ten of them, and their readers go as deep by recursion.
constexpr int deepest = 100;

/// Where they are more; nullopt: nowhere.
std::optional<std::size_t> too_deep(const std::string& text) {
  int depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted && c == '\\')
      ++i;
    else if (c == '"')
      quoted = !quoted;
    else if (!quoted && (c == '[' || c == '{') && ++depth > deepest)
      return i;
    else if (!quoted && (c == ']' || c == '}'))
      --depth;
  }
  return std::nullopt;
}

std::ptrdiff_t line_of(const std::string& text, std::size_t place) {
  return 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(place), '\n');
}

}  // namespace

Json parse_json(const std::string& text) {
  if (const auto place = too_deep(text))
    throw std::invalid_argument(
        fmt::format("invalid JSON in line {}: more than {} nested lists and objects", line_of(text, *place), deepest));
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& error) {
    const std::size_t place = std::min(text.size(), error.byte > 0 ? error.byte - 1 : 0);
    const auto line = line_of(text, place);
    throw std::invalid_argument(place < text.size() ? fmt::format("invalid JSON in line {}", line)
                                                    : fmt::format("invalid JSON: the file ends early, in line {}", line));
  } catch (const Json::exception& error) {
    throw std::invalid_argument(fmt::format("invalid JSON: {}", plain(error)));  // a number beyond a double
  }
}

void check_to_resume(const std::string& folder, const std::string& command) {
  const std::string file = folder + "/" + command + ".json";
  std::error_code error;
  if (std::filesystem::exists(file, error)) return;
  if (std::filesystem::exists(folder + "/." + command + ".lock", error))
    throw std::invalid_argument(
        fmt::format("--resume {}: the run there was stopped before its first results; begin anew with --out {}", folder, folder));
  throw std::invalid_argument(fmt::format(
      "--resume: {}: no such file; give the folder that an interrupted run of graze {} wrote with --out", file, command));
}

Json read_to_resume(const std::string& folder, const std::string& command) {
  check_to_resume(folder, command);
  const std::string file = folder + "/" + command + ".json";
  const std::string text = read_whole(file);
  Json result;
  try {
    result = parse_json(text);
  } catch (const std::invalid_argument& refused) {
    throw std::invalid_argument(fmt::format("--resume: {}: {}; compute it anew", file, refused.what()));
  }
  if (text_of(result, "command") != command) throw_not_resumable(folder, command, "is not a result of graze " + command);
  const std::vector<std::string> known = schemas_of(command);
  if (const std::string schema = schema_of(result); std::find(known.begin(), known.end(), schema) == known.end())
    throw_not_resumable(folder, command,
                        fmt::format("is {}, which this graze does not know; it goes on with {}; begin anew with --out, or go on "
                                    "with the graze that wrote it",
                                    schema.empty() ? "of no schema" : "of schema " + schema, fmt::join(known, " and ")));
  remove_unfinished(folder, command);
  return result;
}

void check_same_run(const Json& earlier, const Json& head, const std::string& folder) {
  if (const auto found = difference(earlier, head, run_identity_parts))
    throw_not_resumable(folder, head["command"], fmt::format("is of another run: {}; give the same", *found));
}

void throw_not_resumable(const std::string& folder, const std::string& command, const std::string& why) {
  throw std::invalid_argument(fmt::format("--resume: {}/{}.json {}", folder, command, why));
}

}  // namespace graze::apps
