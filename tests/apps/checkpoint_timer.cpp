// SPDX-License-Identifier: GPL-3.0-or-later
// CheckpointTimer: how long they are by the clock, and that what they keep meanwhile is what an interruption would have kept.
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

/// Without it a stint is longer than a test.
struct ShortStints {
  double usual = interval_length();
  ShortStints() { set_interval_length(0.0); }
  ~ShortStints() { set_interval_length(usual); }
};

/// Runs a command and collects what stands in the JSON file of its folder meanwhile, as kill -9 would leave it: every version
/// that is seen.
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

/// Arguments of a process of its own, which is this program again; and the test case there that runs them.
constexpr const char* arguments_of_child = "GRAZE_TEST_ARGUMENTS";
constexpr const char* child = "a command in a process of its own with the shortest stints";

/// Runs a command so, and kills the process as soon as it has left a further part of its result. False: it came to its end.
bool kill_on_its_way(const std::vector<std::string>& arguments, const std::string& file) {
  std::string text;
  for (const std::string& argument : arguments) text += argument + "\n";
  ::setenv(arguments_of_child, text.c_str(), 1);
  const std::string self = std::filesystem::read_symlink("/proc/self/exe");
  const std::string before = read_file(file);
  const Outcome outcome = run_shell(fmt::format("'{}' '{}'", self, child),
                                    [&](pid_t process) { return read_file(file) != before && ::kill(process, SIGKILL) == 0; });
  ::unsetenv(arguments_of_child);
  INFO(outcome.out << outcome.err);
  CHECK((outcome.code == -SIGKILL || outcome.code == 0));
  return outcome.code == -SIGKILL;
}

/// The command is killed, and killed again when it goes on; then it comes to the same end as one that was left alone.
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
    REQUIRE_FALSE(left.is_discarded());  // never half a file
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
  // What was being written is gone.
  for (const std::filesystem::directory_entry& entry : std::filesystem::directory_iterator(out))
    CHECK(std::filesystem::exists(whole + "/" + entry.path().filename().string()));
}

/// The command with --out keeps parts on its way, comes to the same end as without stints, and so does --resume from each part.
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
    const ShortStints checkpoints;
    parts = versions_while(file, [&] { CHECK(call(with("--out", "kept")).code == 0); });
  }
  CHECK(read_file(file) == whole);
  parts.erase(whole);
  REQUIRE_FALSE(parts.empty());
  std::filesystem::create_directory(folder.file("left"));
  std::map<bool, std::size_t> resumed;
  for (const std::string& part : parts) {
    const Json json = Json::parse(part, nullptr, false);
    REQUIRE_FALSE(json.is_discarded());  // never half a file
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

TEST_CASE("a stint is over with the first news after its time, and long against what its end costs") {
  double now = 100.0;
  CheckpointTimer checkpoints(30.0, CheckpointTimer::End::stops, [&] { return now; });
  const auto news_at = [&](double time) {
    now = time;
    checkpoints.news();
    return checkpoints.over();
  };
  checkpoints.begin(0);
  CHECK_FALSE(news_at(129.0));  // its first piece: nothing was lost before it
  CHECK(news_at(130.5));
  // Ending it took 4 s, writing included: the next one is twenty times as long.
  now = 134.5;
  checkpoints.begin(5);
  CHECK_FALSE(checkpoints.over());
  CHECK_FALSE(news_at(135.5));
  CHECK_FALSE(news_at(214.0));
  CHECK(news_at(214.5));
  // Its first piece took 10 s, part of which the last stint had lost.
  checkpoints.begin(9);
  CHECK_FALSE(news_at(224.5));
  CHECK_FALSE(news_at(414.0));
  CHECK(news_at(414.5));
  // That kept nothing new: the next one is twice as long.
  checkpoints.begin(9);
  CHECK_FALSE(news_at(415.0));
  CHECK_FALSE(news_at(814.0));
  CHECK(news_at(814.5));
}

TEST_CASE("a stint at whose end nothing stops is as long as its length, and long against the writing alone") {
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

TEST_CASE("without a length there is one stint") {
  double now = 0.0;
  CheckpointTimer checkpoints(std::nullopt, CheckpointTimer::End::stops, [&] { return now; });
  checkpoints.begin(0);
  for (now = 0.0; now < 1e6; now += 1000.0) checkpoints.news();
  CHECK_FALSE(checkpoints.over());
}

TEST_CASE("a command in a process of its own with the shortest stints", "[.]") {
  const char* const text = std::getenv(arguments_of_child);
  if (text == nullptr) return;  // it is run by others
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

TEST_CASE("a sweep keeps what it has while it goes on, from where another goes on to the last bit") {
  check_kept(sweep, "sweep");
}

TEST_CASE("attractors keeps what it has while it goes on, from where another goes on to the last bit") {
  check_kept(attractors, "attractors");
}

TEST_CASE("a diagram keeps what it has while it goes on, from where another goes on to the last bit") {
  check_kept(diagram, "diagram");
}

TEST_CASE("a sweep that is killed goes on to the last bit") {
  std::vector<std::string> longer = sweep;
  *std::find(longer.begin(), longer.end(), "0.0005") = "0.00005";
  check_killed(longer, "sweep");
}

TEST_CASE("attractors that is killed goes on to the last bit") {
  std::vector<std::string> longer = attractors;
  longer.insert(longer.end(), {"--x=-2:1.9:400", "--v=-2:2:400"});
  std::erase_if(longer, [](const std::string& one) { return one.ends_with(":200"); });
  check_killed(longer, "attractors");
}

TEST_CASE("a diagram that is killed goes on to the last bit") { check_killed(diagram, "diagram"); }
