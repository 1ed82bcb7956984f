// SPDX-License-Identifier: GPL-3.0-or-later
// Files that are written whole or not at all: to a temporary file in the same folder, synchronised, renamed. What is not a
// regular file (/dev/stdout, a pipe) is written to directly.
#pragma once

#include <graze/apps/text/long_text.hpp>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace graze::apps {

/// Finds out, before anything is computed, whether `file` can be written. Leaves nothing behind.
/// @throws std::invalid_argument with one sentence if not.
void check_writable(const std::string& file);

/// @throws std::invalid_argument if no files can be made in this folder.
void check_writable_folder(const std::string& folder);

/// An output as it was asked for: "--json", and the file ("" or "-": none).
struct NamedOutput {
  std::string option, file;
};

/// @throws std::invalid_argument if two outputs are one file, or one is the `input`.
void check_distinct(const std::vector<NamedOutput>& outputs, const std::string& input);

/// @throws std::invalid_argument if the name ends as another kind of result does: `endings` are those of its own kind.
void check_kind(const std::string& option, const std::string& file, const std::vector<std::string>& endings);

/// Whether something that is no regular file is there: a device, a pipe, a folder.
bool is_special(const std::string& file);

/// @throws std::invalid_argument if something that is no regular file is there.
void check_regular(const std::string& option, const std::string& file);

/// Writes `content`. nullopt: done; else one sentence why not, and what was there before is still there; as it is if `content`
/// throws.
std::optional<std::string> write_whole(const std::string& file, const LongText& content);
std::optional<std::string> write_whole(const std::string& file, std::string_view content);

/// Removes what write_whole was writing into a folder for a command (its files are COMMAND.* and COMMAND-*) when it was killed.
void remove_unfinished(const std::string& folder, const std::string& command);

/// The folder that an output is written into: links are followed.
std::string folder_of(const std::string& file);

/// Makes sure that the names in a folder survive a crash of the machine, as write_whole does for contents. nullopt: done; else
/// one sentence why not.
std::optional<std::string> sync_folder(const std::string& folder);

/// Makes a folder, and those above it. @throws std::invalid_argument with one sentence if it cannot be made.
void make_folder(const std::string& folder);

}  // namespace graze::apps
