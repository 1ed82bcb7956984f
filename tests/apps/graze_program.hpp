// SPDX-License-Identifier: GPL-3.0-or-later
// Runs the program in tests: as a function (call) or as a separate process (spawn). Also: a temporary folder.
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

/// run_program within this process. Its result must agree with its schema.
Outcome call(const std::vector<std::string>& arguments);

/// A command on a shipped problem, without progress and notes.
Outcome call(const std::string& command, const std::string& problem_id, std::vector<std::string> more);

/// The JSON on stdout of a call that must succeed.
apps::Json json_of(const Outcome& outcome);

/// The program as a child process: arguments in shell syntax, with redirections.
Outcome spawn(const std::string& arguments);

/// Runs any shell command and captures stdout and stderr. `watch` is called every few milliseconds with the process id, until
/// it returns true or the command ends.
Outcome run_shell(const std::string& command, const std::function<bool(pid_t)>& watch = {});

/// Runs the program with a terminal for stderr, where it shows its progress. The signal is sent when the progress contains
/// `sign`, or, if `sign` is empty, at the first progress.
Outcome interrupt(const std::string& arguments, const std::string& sign, int signal);

/// Interrupts the program by Ctrl-C at that sign. It must end with 130 and leave its results so far as JSON in `file`.
apps::Json interrupted_json(const std::string& arguments, const std::string& file, const std::string& sign);

/// data/problems/<id>.toml
std::string problem(const std::string& id);

std::string read_file(const std::filesystem::path& file);

/// For a test that needs a program or module which is not there: fails, or only warns if the environment variable
/// GRAZE_TESTS_MAY_SKIP is set.
void skip_test(const std::string& reason);

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
