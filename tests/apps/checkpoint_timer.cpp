// SPDX-License-Identifier: GPL-3.0-or-later
// CheckpointTimer: the lengths of the checkpoint intervals, and the checkpoints of the commands. A checkpoint must hold the
// same result as an interruption.
#include "graze_program.hpp"

#include <graze/apps/console/checkpoint_timer.hpp>
#include <graze/apps/program/program.hpp>

#include <catch2/catch.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>
#include <set>
#include <sstream>
#include <thread>

using namespace graze;
using namespace graze::apps;
using namespace graze::support;
using Catch::Matchers::Contains;

namespace {

/// Sets the interval to zero; the usual one is longer than a test.
struct ZeroInterval {
  double usual = interval_length();
  ZeroInterval() { set_interval_length(0.0); }
  ~ZeroInterval() { set_interval_length(usual); }
};

/// Runs a command and collects every version of the JSON file in its folder during the run, as kill -9 would leave it.
std::set<std::string> versions_while(const std::string& file, const std::function<void()>& run) {
  std::set<std::string> seen;
  std::atomic<bool> done = false;
  std::thread reader([&] {
    while (!done) {
      if (std::filesystem::exists(file)) seen.insert(read_file(file));
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  run();
  done = true;
  reader.join();
  return seen;
}

/// Environment variable with the arguments of a child process, which is this test program, and the test case that runs them.
constexpr const char* arguments_of_child = "GRAZE_TEST_ARGUMENTS";
constexpr const char* child_case = "a command in a child process with a checkpoint interval of zero";

/// Runs a command in a child process and kills it as soon as it has written a further part of its result. False: it finished.
bool kill_on_its_way(const std::vector<std::string>& arguments, const std::string& file) {
  std::string text;
  for (const std::string& argument : arguments) text += argument + "\n";
  ::setenv(arguments_of_child, text.c_str(), 1);
  const std::string self = std::filesystem::read_symlink("/proc/self/exe");
  const std::string before = read_file(file);
  const Outcome outcome = run_shell(fmt::format("'{}' '{}'", self, child_case),
                                    [&](pid_t process) { return read_file(file) != before && ::kill(process, SIGKILL) == 0; });
  ::unsetenv(arguments_of_child);
  INFO(outcome.out << outcome.err);
  CHECK((outcome.code == -SIGKILL || outcome.code == 0));
  return outcome.code == -SIGKILL;
}

/// Kills the command, resumes it, kills it again and resumes it. The final result must equal that of an undisturbed run.
void check_killed(const std::vector<std::string>& arguments, const std::string& command) {
  const TemporaryFolder folder;
  const std::string whole = folder.file("whole"), out = folder.file("out"), file = out + "/" + command + ".json";
  const auto with = [&](const std::string& option, const std::string& place) {
    std::vector<std::string> all = {command, "--quiet"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    all.insert(all.end(), {option, place});
    return all;
  };
  REQUIRE(kill_on_its_way(with("--out", out), file));
  for (int k = 0; k < 2; ++k) {
    const Json left = Json::parse(read_file(file), nullptr, false);
    REQUIRE_FALSE(left.is_discarded());  // never an incomplete file
    CHECK(left["status"] == "interrupted");
    if (k == 0) REQUIRE(kill_on_its_way(with("--resume", out), file));
  }
  const Outcome resumed = call(with("--resume", out));
  INFO(resumed.err);
  REQUIRE(resumed.code == 0);
  REQUIRE(call(with("--out", whole)).code == 0);
  for (const std::filesystem::directory_entry& entry : std::filesystem::directory_iterator(whole))
    if (entry.is_regular_file()) {
      const std::string name = entry.path().filename();
      INFO(name);
      if (name.ends_with(".json") || name.ends_with(".csv")) CHECK(read_file(out + "/" + name) == read_file(entry.path()));
    }
  // Temporary files of interrupted writes are removed.
  for (const std::filesystem::directory_entry& entry : std::filesystem::directory_iterator(out))
    CHECK(std::filesystem::exists(whole + "/" + entry.path().filename().string()));
}

/// The command with --out writes checkpoints and gives the same result as without. So does --resume from each checkpoint.
void check_kept(const std::vector<std::string>& arguments, const std::string& command) {
  const TemporaryFolder folder;
  const auto with = [&](const std::string& option, const std::string& name) {
    std::vector<std::string> all = {command, "--quiet"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    all.insert(all.end(), {option, folder.file(name)});
    return all;
  };
  const Outcome plain = call(with("--out", "plain"));
  INFO(plain.err);
  REQUIRE(plain.code == 0);
  const std::string whole = read_file(folder.file("plain/" + command + ".json"));
  const std::string file = folder.file("kept/" + command + ".json");
  std::set<std::string> parts;
  {
    const ZeroInterval checkpoints;
    parts = versions_while(file, [&] { CHECK(call(with("--out", "kept")).code == 0); });
  }
  CHECK(read_file(file) == whole);
  parts.erase(whole);
  REQUIRE_FALSE(parts.empty());
  std::filesystem::create_directory(folder.file("left"));
  std::map<bool, std::size_t> resumed;
  for (const std::string& part : parts) {
    const Json json = Json::parse(part, nullptr, false);
    REQUIRE_FALSE(json.is_discarded());  // never an incomplete file
    CHECK(json["status"] == "interrupted");
    CHECK_THAT(json["message"].get<std::string>(), Contains("kept") && Contains("while it went on"));
    const bool in_skeleton = json.contains("parts") && json["parts"]["skeleton"] != "done";
    if (++resumed[in_skeleton] > 3) continue;
    folder.write("left/" + command + ".json", part);
    CHECK(call(with("--resume", "left")).code == 0);
    const std::string end = read_file(folder.file("left/" + command + ".json"));
    CHECK(end == whole);
    CHECK(read_file(folder.file("left/" + command + ".csv")) == read_file(folder.file("plain/" + command + ".csv")));
  }
  CHECK(resumed[false] > 0);
}

}  // namespace

TEST_CASE("a checkpoint interval ends with the first result after its length and is long relative to the cost of its end") {
  double now = 100.0;
  CheckpointTimer checkpoints(30.0, CheckpointTimer::End::stops, [&] { return now; });
  const auto news_at = [&](double time) {
    now = time;
    checkpoints.news();
    return checkpoints.over();
  };
  checkpoints.begin(0);
  CHECK_FALSE(news_at(129.0));  // its first result: nothing was lost before it
  CHECK(news_at(130.5));
  // The end took 4 s, writing included: the next interval is twenty times as long.
  now = 134.5;
  checkpoints.begin(5);
  CHECK_FALSE(checkpoints.over());
  CHECK_FALSE(news_at(135.5));
  CHECK_FALSE(news_at(214.0));
  CHECK(news_at(214.5));
  // The first result took 10 s, part of which was lost at the end of the last interval.
  checkpoints.begin(9);
  CHECK_FALSE(news_at(224.5));
  CHECK_FALSE(news_at(414.0));
  CHECK(news_at(414.5));
  // That interval kept nothing new: the next one is twice as long.
  checkpoints.begin(9);
  CHECK_FALSE(news_at(415.0));
  CHECK_FALSE(news_at(814.0));
  CHECK(news_at(814.5));
}

TEST_CASE("a checkpoint interval that stops no computation has its length and is long relative to the writing alone") {
  double now = 0.0;
  CheckpointTimer checkpoints(30.0, CheckpointTimer::End::goes_on, [&] { return now; });
  checkpoints.begin(0);
  now = 20.0;
  checkpoints.news();
  CHECK_FALSE(checkpoints.over());
  now = 40.0;
  checkpoints.news();
  CHECK(checkpoints.over());
  now = 42.0;
  checkpoints.begin(0);
  now = 81.0;
  checkpoints.news();
  CHECK_FALSE(checkpoints.over());
  now = 82.0;
  checkpoints.news();
  CHECK(checkpoints.over());
}

TEST_CASE("without a length there is one checkpoint interval") {
  double now = 0.0;
  CheckpointTimer checkpoints(std::nullopt, CheckpointTimer::End::stops, [&] { return now; });
  checkpoints.begin(0);
  for (now = 0.0; now < 1e6; now += 1000.0) checkpoints.news();
  CHECK_FALSE(checkpoints.over());
}

TEST_CASE("a command in a child process with a checkpoint interval of zero", "[.]") {
  const char* const text = std::getenv(arguments_of_child);
  if (text == nullptr) return;  // only other tests run it
  std::istringstream lines(text);
  std::vector<std::string> arguments;
  for (std::string line; std::getline(lines, line);) arguments.push_back(line);
  set_interval_length(0.0);
  CHECK(run_program(arguments, std::cout, std::cerr) == 0);
}

namespace {

const std::vector<std::string> sweep = {
    problem("newton-elastic"), "--from", "0.7", "--to", "0.76", "--step", "0.0005", "--direction", "both", "--threads", "2"};
const std::vector<std::string> attractors = {problem("hertz-damped"), "--set",     "eta=0.711", "--x=-2:1.9:200",
                                             "--v=-2:2:200",          "--threads", "2"};
const std::vector<std::string> diagram = {problem("newton-elastic"),
                                          "--from",
                                          "0.743",
                                          "--to",
                                          "0.747",
                                          "--step",
                                          "0.00005",
                                          "--periods",
                                          "300",
                                          "--samples",
                                          "5",
                                          "--max-period",
                                          "4",
                                          "--multiples",
                                          "1",
                                          "--threads",
                                          "2"};

}  // namespace

TEST_CASE("a sweep writes checkpoints from which a run continues with identical bits") { check_kept(sweep, "sweep"); }

TEST_CASE("attractors writes checkpoints from which a run continues with identical bits") {
  check_kept(attractors, "attractors");
}

TEST_CASE("a diagram writes checkpoints from which a run continues with identical bits") { check_kept(diagram, "diagram"); }

TEST_CASE("a sweep that is killed continues with identical bits") {
  std::vector<std::string> longer = sweep;
  *std::find(longer.begin(), longer.end(), "0.0005") = "0.00005";
  check_killed(longer, "sweep");
}

TEST_CASE("attractors that is killed continues with identical bits") {
  std::vector<std::string> longer = attractors;
  longer.insert(longer.end(), {"--x=-2:1.9:400", "--v=-2:2:400"});
  std::erase_if(longer, [](const std::string& one) { return one.ends_with(":200"); });
  check_killed(longer, "attractors");
}

TEST_CASE("a diagram that is killed continues with identical bits") { check_killed(diagram, "diagram"); }
