// SPDX-License-Identifier: GPL-3.0-or-later
// Running the program in tests: as a function (call) or as a process of its own (spawn); and a folder that is gone afterwards.
#pragma once

#include <graze/apps/text/json.hpp>

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace graze::support {

struct Outcome {
  int code = -1;
  std::string out, err;
};

/// run_program within this process. A result that it leaves has to be as its schema says.
Outcome call(const std::vector<std::string>& arguments);

/// A command on a problem that is shipped, without progress and notes.
Outcome call(const std::string& command, const std::string& problem_id, std::vector<std::string> more);

/// What a call that must succeed has put on stdout as JSON.
apps::Json json_of(const Outcome& outcome);

/// The program as a child process: arguments as a shell understands them, redirections included.
Outcome spawn(const std::string& arguments);

/// Any command of a shell, stdout and stderr caught. `watch` is asked every few milliseconds with the process id for as long as
/// the command runs, until it says true.
Outcome run_shell(const std::string& command, const std::function<bool(pid_t)>& watch = {});

/// The program with a terminal for stderr, where it shows its progress: once that says `sign`, the signal is sent. With a sign
/// that is empty, it is sent when there is any progress.
Outcome interrupt(const std::string& arguments, const std::string& sign, int signal);

/// The program, interrupted by Ctrl-C at that sign, has ended as it should: with 130, and with what there is as JSON in `file`.
apps::Json interrupted_json(const std::string& arguments, const std::string& file, const std::string& sign);

/// data/problems/<id>.toml
std::string problem(const std::string& id);

std::string read_file(const std::filesystem::path& file);

class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::string file(const std::string& name) const { return (path_ / name).string(); }
  /// Makes a file and returns its name.
  std::string write(const std::string& name, const std::string& content) const;
  /// Number of files in the folder, hidden ones included.
  std::size_t files() const;

 private:
  std::filesystem::path path_;
};

}  // namespace graze::support
