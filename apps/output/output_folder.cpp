// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/console/output_file.hpp>
#include <graze/apps/output/output_folder.hpp>
#include <graze/apps/results/input_file.hpp>
#include <graze/apps/results/run_identity.hpp>
#include <graze/apps/text/json_member.hpp>

#include <fmt/format.h>

#include <filesystem>
#include <stdexcept>

namespace graze::apps {

namespace {

/// The result in a file; null if the file holds no result.
Json result_in(const std::string& file) {
  try {
    Json result = parse_json(read_whole(file));
    return result.is_object() ? result : Json();
  } catch (const std::invalid_argument&) {
    return {};
  }
}

}  // namespace

OutputFolder::OutputFolder(const OutputOptions& options, const std::string& command, const std::string& input,
                           const std::optional<std::string>& resume)
    : options_(options), command_(command), resumable_(resume.has_value()) {
  const bool resuming = resume && !resume->empty();
  std::error_code error;
  resuming_here_ = resuming && (*resume == options.out || std::filesystem::equivalent(*resume, options.out, error));
  if (options.overwrite && (options.out.empty() || resuming_here_))
    throw std::invalid_argument(fmt::format("--overwrite replaces the result in --out DIR; give that{}",
                                            resumable_ ? ", and no --resume of the same folder" : ""));
  if (resuming) {
    check_to_resume(*resume, command);
    lock(*resume);
    earlier_ = read_to_resume(*resume, command);
  }
  check_outputs(options, input);
  if (options.out.empty()) return;
  is_new_ = !std::filesystem::exists(options.out, error);
  make_folder(options.out);
  check_writable_folder(options.out);
  if (!resuming_here_) lock(options.out);
}

OutputFolder::~OutputFolder() {
  locks_.clear();
  std::error_code error;
  if (is_new_) std::filesystem::remove(options_.out, error);  // only if it is empty
}

void OutputFolder::lock(const std::string& folder) {
  locks_.push_back(
      std::make_unique<FileLock>(fmt::format("{}/.{}.lock", folder, command_),
                                 fmt::format("{}: another graze {} is at work there; wait for it, or end it", folder, command_)));
}

void OutputFolder::check_free_for(const Json& head) const {
  if (options_.out.empty() || options_.overwrite || resuming_here_) return;
  const std::string file = fmt::format("{}/{}.json", options_.out, command_);
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return;
  const Json there = result_in(file);
  // As it would be read back: in a file, a number that is not finite is null.
  const auto found = difference(there, parse_json(flat(head)), run_identity_parts);
  if (found || there.is_null())
    throw std::invalid_argument(
        fmt::format("--out {}: another result is there, {}{}; give another folder, or --overwrite to replace it", options_.out,
                    file, found && !there.is_null() ? fmt::format(", whose {}", *found) : ""));
  if (resumable_ && text_of(there, "status") == status_name(Status::interrupted))
    throw std::invalid_argument(
        fmt::format("--out {0}: {1} is unfinished; --resume {0} goes on with it, --overwrite begins anew", options_.out, file));
}

}  // namespace graze::apps
