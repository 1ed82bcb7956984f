// SPDX-License-Identifier: GPL-3.0-or-later
// Files that are written completely or not at all: to a temporary file in the same folder, synchronised, renamed. A target that
// is not a regular file (/dev/stdout, a pipe) is written directly.
#pragma once

#include <graze/apps/text/long_text.hpp>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace graze::apps {

/// Checks, before anything is computed, that `file` can be written. Leaves nothing behind. @throws std::invalid_argument with
/// one sentence if not.
void check_writable(const std::string& file);

/// @throws std::invalid_argument if no files can be created in this folder.
void check_writable_folder(const std::string& folder);

/// A requested output: the option, such as "--json", and the file ("" or "-": none).
struct NamedOutput {
  std::string option, file;
};

/// @throws std::invalid_argument if two outputs are the same file, or one is the `input`.
void check_distinct(const std::vector<NamedOutput>& outputs, const std::string& input);

/// @throws std::invalid_argument if the name has the ending of another kind of result; `endings`: those of its own kind.
void check_kind(const std::string& option, const std::string& file, const std::vector<std::string>& endings);

/// Whether the name belongs to something other than a regular file: a device, a pipe, a folder.
bool is_special(const std::string& file);

/// @throws std::invalid_argument if the name belongs to something other than a regular file.
void check_regular(const std::string& option, const std::string& file);

/// Writes `content`. nullopt: done; otherwise one sentence on the failure. On failure, or if `content` throws, the previous
/// file is unchanged.
std::optional<std::string> write_whole(const std::string& file, const LongText& content);
std::optional<std::string> write_whole(const std::string& file, std::string_view content);

/// Removes temporary files that write_whole left in a folder when a command was killed (the command's files are COMMAND.* and
/// COMMAND-*).
void remove_unfinished(const std::string& folder, const std::string& command);

/// The folder into which an output is written: links are followed.
std::string folder_of(const std::string& file);

/// Makes the names in a folder survive a crash of the machine, as write_whole does for contents. nullopt: done; otherwise one
/// sentence on the failure.
std::optional<std::string> sync_folder(const std::string& folder);

/// Creates a folder and its parents. @throws std::invalid_argument with one sentence if it cannot be created.
void make_folder(const std::string& folder);

}  // namespace graze::apps
