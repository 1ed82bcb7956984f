// SPDX-License-Identifier: GPL-3.0-or-later
#include "graze_program.hpp"

#include "json_schema.hpp"

#include <graze/apps/program/program.hpp>

#include <catch2/catch.hpp>

#include <fmt/format.h>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace graze::support {

Outcome call(const std::vector<std::string>& arguments) {
  std::ostringstream out, err;
  Outcome outcome;
  outcome.code = apps::run_program(arguments, out, err);
  outcome.out = out.str();
  outcome.err = err.str();
  check_results(arguments, outcome);
  return outcome;
}

Outcome call(const std::string& command, const std::string& problem_id, std::vector<std::string> more) {
  more.insert(more.begin(), {command, problem(problem_id), "--quiet"});
  return call(more);
}

apps::Json json_of(const Outcome& outcome) {
  INFO(outcome.err);
  REQUIRE(outcome.code == 0);
  return apps::Json::parse(outcome.out);
}

Outcome spawn(const std::string& arguments) {
  // Redirections in `arguments` take precedence over those of run_shell.
  const Outcome outcome = run_shell("'" GRAZE_PROGRAM "' " + arguments);
  std::istringstream words(arguments);
  check_results({std::istream_iterator<std::string>(words), {}}, outcome);
  return outcome;
}

void skip_test(const std::string& reason) {
  if (std::getenv("GRAZE_TESTS_MAY_SKIP"))
    WARN(reason);
  else
    FAIL(reason);
}

namespace {

/// A terminal whose output can be read here.
class Terminal {
 public:
  Terminal() : here_(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
    if (here_ < 0 || ::grantpt(here_) != 0 || ::unlockpt(here_) != 0) throw std::runtime_error("no terminal can be opened");
    name_ = ::ptsname(here_);
    there_ = ::open(name_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);  // keeps the terminal open between two writers
  }
  ~Terminal() {
    ::close(there_);
    ::close(here_);
  }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;
  const std::string& name() const { return name_; }
  /// The output since the last call.
  std::string read() {
    std::string text;
    char buffer[4096];
    for (ssize_t size = 0; (size = ::read(here_, buffer, sizeof buffer)) > 0;)
      text.append(buffer, static_cast<std::size_t>(size));
    return text;
  }

 private:
  int here_ = -1, there_ = -1;
  std::string name_;
};

}  // namespace

Outcome interrupt(const std::string& arguments, const std::string& sign, int signal) {
  Terminal terminal;
  std::string said;
  Outcome outcome = run_shell("'" GRAZE_PROGRAM "' " + arguments + " 2>'" + terminal.name() + "'", [&](pid_t child) {
    said += terminal.read();
    return said.find(sign.empty() ? "\r" : sign) != std::string::npos && ::kill(child, signal) == 0;
  });
  outcome.err = said + terminal.read();
  return outcome;
}

Outcome run_shell(const std::string& command, const std::function<bool(pid_t)>& watch) {
  const TemporaryFolder folder;
  const std::string out = folder.file("out"), err = folder.file("err");
  std::string redirected = "exec >'" + out + "' 2>'" + err + "' </dev/null; exec " + command;
  char shell[] = "/bin/sh", option[] = "-c";
  char* const argv[] = {shell, option, redirected.data(), nullptr};
  pid_t child = 0;
  if (posix_spawn(&child, shell, nullptr, nullptr, argv, environ) != 0) throw std::runtime_error("the shell cannot be started");
  int state = 0;
  bool watching = static_cast<bool>(watch);
  while (::waitpid(child, &state, watching ? WNOHANG : 0) == 0) {
    watching = !watch(child);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  Outcome outcome;
  outcome.code = WIFEXITED(state) ? WEXITSTATUS(state) : -WTERMSIG(state);
  outcome.out = read_file(out);
  outcome.err = read_file(err);
  return outcome;
}

apps::Json interrupted_json(const std::string& arguments, const std::string& file, const std::string& sign) {
  INFO(arguments);
  const Outcome outcome = interrupt(arguments + " --json " + file, sign, SIGINT);
  INFO(outcome.err);
  CHECK(outcome.code == 130);
  CHECK_THAT(outcome.err, Catch::Matchers::Contains("interrupted"));
  apps::Json json = apps::Json::parse(read_file(file), nullptr, false);
  REQUIRE_FALSE(json.is_discarded());
  CHECK(json["status"] == "interrupted");
  return json;
}

std::string problem(const std::string& id) { return fmt::format("{}/problems/{}.toml", GRAZE_DATA_DIR, id); }

std::string read_file(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TemporaryFolder::TemporaryFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "graze-test-XXXXXX").string();
  if (!::mkdtemp(name.data())) throw std::runtime_error("no temporary folder can be made");
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code error;
  std::filesystem::remove_all(path_, error);
}

std::string TemporaryFolder::write(const std::string& name, const std::string& content) const {
  std::ofstream(file(name), std::ios::binary) << content;
  return file(name);
}

std::size_t TemporaryFolder::files() const {
  return static_cast<std::size_t>(
      std::distance(std::filesystem::directory_iterator(path_), std::filesystem::directory_iterator()));
}

}  // namespace graze::support
