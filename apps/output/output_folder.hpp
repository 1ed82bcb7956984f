// SPDX-License-Identifier: GPL-3.0-or-later
// OutputFolder: the folders of --out and --resume, held by one run of a command at a time, and kept from runs of other options.
#pragma once

#include <graze/apps/console/file_lock.hpp>
#include <graze/apps/output/result.hpp>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace graze::apps {

class OutputFolder {
 public:
  /// Finds out before anything is computed whether all outputs can be written, see check_outputs(). Makes the folder of --out and
  /// locks it until the end of this object; likewise that of --resume, whose result is read. `resume`: nullopt for a command
  /// without that option, empty if it is not given.
  /// @throws std::invalid_argument in one sentence.
  OutputFolder(const OutputOptions& options, const std::string& command, const std::string& input = {},
               const std::optional<std::string>& resume = std::nullopt);

  /// A folder that was made for nothing, because the call was refused, does not stay.
  ~OutputFolder();

  /// The result in the folder of --resume; null if that is not given.
  const Json& earlier() const { return earlier_; }

  /// @throws std::invalid_argument if --out holds the result of a run with another head, or an unfinished one, and --overwrite is
  /// not given.
  void check_free_for(const Json& head) const;

 private:
  void lock(const std::string& folder);

  OutputOptions options_;
  std::string command_;
  bool resumable_, resuming_here_ = false, is_new_ = false;
  Json earlier_;
  std::vector<std::unique_ptr<FileLock>> locks_;
};

}  // namespace graze::apps
