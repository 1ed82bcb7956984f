// SPDX-License-Identifier: GPL-3.0-or-later
#include "graze_program.hpp"

#include "json_schema.hpp"

#include <graze/apps/program/program.hpp>

#include <catch2/catch.hpp>

#include <fmt/format.h>

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

Outcome spawn(const std::string& arguments, int signal, double delay) {
  const TemporaryFolder folder;
  const std::string out = folder.file("out"), err = folder.file("err");
  // exec: the shell makes room for the program, so that a signal reaches it. Redirections in `arguments` come later and win.
  std::string command = "exec '" GRAZE_PROGRAM "' >'" + out + "' 2>'" + err + "' </dev/null " + arguments;
  char shell[] = "/bin/sh", option[] = "-c";
  char* const argv[] = {shell, option, command.data(), nullptr};
  pid_t child = 0;
  if (posix_spawn(&child, shell, nullptr, nullptr, argv, environ) != 0) throw std::runtime_error("the program cannot be started");
  if (signal > 0) {
    std::this_thread::sleep_for(std::chrono::duration<double>(delay));
    ::kill(child, signal);
  }
  int state = 0;
  ::waitpid(child, &state, 0);
  Outcome outcome;
  outcome.code = WIFEXITED(state) ? WEXITSTATUS(state) : -WTERMSIG(state);
  outcome.out = read_file(out);
  outcome.err = read_file(err);
  std::istringstream words(arguments);
  check_results({std::istream_iterator<std::string>(words), {}}, outcome);
  return outcome;
}

Outcome run_shell(const std::string& text, const std::function<bool(pid_t)>& watch) {
  const TemporaryFolder folder;
  const std::string out = folder.file("out"), err = folder.file("err");
  std::string command = "exec >'" + out + "' 2>'" + err + "' </dev/null; exec " + text;
  char shell[] = "/bin/sh", option[] = "-c";
  char* const argv[] = {shell, option, command.data(), nullptr};
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

apps::Json interrupted_json(const std::string& arguments, const std::string& file, double delay) {
  INFO(arguments);
  const Outcome outcome = spawn(arguments + " --json " + file, SIGINT, delay);
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
