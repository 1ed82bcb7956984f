// SPDX-License-Identifier: GPL-3.0-or-later
// OutputFolder: the folders of --out and --resume. One run of a command at a time holds them, and they are protected from runs
// with other options.
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
  /// Checks before anything is computed that all outputs can be written, see check_outputs(). Creates the folder of --out and
  /// locks it for the lifetime of this object; likewise the folder of --resume, whose result is read. `resume`: nullopt for a
  /// command without that option, empty if it is not given.
  /// @throws std::invalid_argument in one sentence.
  OutputFolder(const OutputOptions& options, const std::string& command, const std::string& input = {},
               const std::optional<std::string>& resume = std::nullopt);

  /// Removes a folder that was created but not used, because the call was refused.
  ~OutputFolder();

  /// The result in the folder of --resume; null if that is not given.
  const Json& earlier() const { return earlier_; }

  /// @throws std::invalid_argument if --out holds the result of a run with another head, or an unfinished one, and --overwrite
  /// is not given.
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
