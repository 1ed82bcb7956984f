// SPDX-License-Identifier: GPL-3.0-or-later
// Folders of --out and --resume: one run at a time, no overwriting of another run, no unknown schema. Also: names that are not
// UTF-8.
#include "graze_program.hpp"

#include <graze/apps/console/file_lock.hpp>
#include <graze/apps/console/interrupt.hpp>

#include <catch2/catch.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <filesystem>

using namespace graze;
using namespace graze::apps;
using namespace graze::support;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

/// Each command that has --out, with a short computation.
const std::vector<std::vector<std::string>> commands_with_out = {
    {"orbit"},
    {"continue", "--to", "0.94"},
    {"locate", "--type", "GR", "--near", "0.71"},
    {"lyapunov", "--periods", "100"},
    {"sweep", "--from", "0.9", "--to", "0.91", "--step", "0.005"},
    {"diagram", "--skeleton", "--all", "--from", "0.746", "--to", "0.747", "--max-period", "1"},
    {"attractors", "--random", "4", "--x=-1:1", "--v=-1:1"},
    {"verify"},
    {"trajectory"},
    {"poincare", "--points", "10"},
    {"map", "--param", "eta:0.8:0.9:2", "--param", "xi:1:1.1:2"}};

Outcome run_into(const std::vector<std::string>& command, const std::string& folder, const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments(command.begin() + 1, command.end());
  arguments.insert(arguments.end(), {"--out", folder});
  arguments.insert(arguments.end(), more.begin(), more.end());
  return call(command.front(), "newton-elastic", arguments);
}

const std::vector<std::string> small_sweep = {"sweep", "--from", "0.9", "--to", "0.91", "--step", "0.005"};

}  // namespace

TEST_CASE("a folder with the result of another run is refused by every command unless --overwrite is given") {
  for (const std::vector<std::string>& command : commands_with_out) {
    INFO(command.front());
    const TemporaryFolder folder;
    const std::string out = folder.file("run"),
                      result = out + "/" + command.front() + (command.front() == "map" ? ".h5" : ".json");
    REQUIRE(run_into(command, out).code == 0);
    const std::string first = read_file(result);
    CHECK(run_into(command, out).code == 0);  // the same one, computed again
    CHECK(read_file(result) == first);
    const Outcome other = run_into(command, out, {"--set", "r=1.9"});
    CHECK(other.code == 2);
    CHECK(other.out.empty());
    CHECK_THAT(other.err, Contains("is there, " + result) && Contains("--overwrite to replace it"));
    CHECK(read_file(result) == first);
    CHECK(run_into(command, out, {"--set", "r=1.9", "--overwrite"}).code == 0);
    CHECK(read_file(result) != first);
  }
  CHECK_THAT(call("orbit", "newton-elastic", {"--overwrite"}).err, Contains("--overwrite replaces the result in --out DIR"));
}

TEST_CASE("an unfinished result is not overwritten without an option") {
  const TemporaryFolder folder;
  set_interrupted(true);
  CHECK(run_into(small_sweep, folder.file("run")).code == 130);
  set_interrupted(false);
  const Outcome anew = run_into(small_sweep, folder.file("run"));
  CHECK(anew.code == 2);
  CHECK_THAT(anew.err, Contains("is unfinished; --resume " + folder.file("run") + " goes on with it, --overwrite begins anew"));
  CHECK(run_into(small_sweep, folder.file("run"), {"--overwrite"}).code == 0);
}

TEST_CASE("two runs of a command in one folder do not overwrite each other") {
  const TemporaryFolder folder;
  const std::string out = folder.file("run"), lock = out + "/.sweep.lock", resume = folder.file("left");
  fs::create_directory(out);
  {
    const FileLock held(lock, "busy");
    const Outcome second = run_into(small_sweep, out);
    CHECK(second.code == 2);
    CHECK_THAT(second.err, Contains(out + ": another graze sweep is at work there; wait for it, or end it"));
    CHECK(run_into({"orbit"}, out).code == 0);  // other commands have other file names
  }
  CHECK_FALSE(fs::exists(lock));
  // The lock file that kill -9 leaves does not block the folder.
  folder.write("run/.sweep.lock", "");
  CHECK(run_into(small_sweep, out).code == 0);
  CHECK_FALSE(fs::exists(lock));
}

TEST_CASE("a run that is killed leaves a folder that the next one can use") {
  const TemporaryFolder folder;
  const std::string out = folder.file("run"), lock = out + "/.sweep.lock";
  const std::string program = fmt::format("'{}' sweep '{}' --from 0.7 --to 0.76 --step 0.0000001 --quiet --out '{}'",
                                          GRAZE_PROGRAM, problem("newton-elastic"), out);
  Outcome second;
  const Outcome first = run_shell(program, [&](pid_t child) {
    if (!fs::exists(lock)) return false;
    second = run_shell(program);
    ::kill(child, SIGKILL);
    return true;
  });
  CHECK(first.code == -SIGKILL);
  CHECK(second.code == 2);
  CHECK_THAT(second.err, Contains("another graze sweep is at work there"));
  CHECK(run_into(small_sweep, out).code == 0);
}

TEST_CASE("an unknown schema is refused by --resume and plot in one sentence") {
  const TemporaryFolder folder;
  const std::string out = folder.file("run");
  for (const std::vector<std::string>& command : commands_with_out) {
    const std::string& name = command.front();
    if (name != "sweep" && name != "diagram" && name != "attractors") continue;
    INFO(name);
    REQUIRE(run_into(command, out).code == 0);
    Json result = Json::parse(read_file(out + "/" + name + ".json"));
    result["schema"] = "graze.future/7";
    folder.write("run/" + name + ".json", result.dump());
    std::vector<std::string> arguments(command.begin() + 1, command.end());
    arguments.insert(arguments.end(), {"--resume", out});
    const Outcome resumed = call(name, "newton-elastic", arguments);
    CHECK(resumed.code == 2);
    CHECK_THAT(resumed.err,
               Contains("is of schema graze.future/7, which this graze does not know; it goes on with graze." + name));
    CHECK(std::count(resumed.err.begin(), resumed.err.end(), '\n') == 1);
    const Outcome plotted = call({"plot", out + "/" + name + ".json", "-o", folder.file("x.png")});
    CHECK(plotted.code == 2);
    CHECK_THAT(plotted.err, Contains("unknown schema graze.future/7; known are graze.") &&
                                Contains("compute the result again with this graze"));
  }
}

TEST_CASE("a file name that is not UTF-8 does not prevent the JSON") {
  const TemporaryFolder folder;
  const std::string wrong = folder.file("n\xff.toml");
  fs::copy_file(problem("newton-elastic"), wrong);
  for (const std::vector<std::string>& command : commands_with_out) {
    INFO(command.front());
    std::vector<std::string> arguments = command;
    arguments.insert(arguments.begin() + 1, wrong);
    arguments.insert(arguments.end(), {"--json", folder.file("o.json"), "--out", folder.file("o\xfe")});
    const Outcome outcome = call(arguments);
    CHECK(outcome.code == 0);
    CHECK_THAT(outcome.err, Contains("is not UTF-8"));
    const Json json = Json::parse(read_file(folder.file("o.json")), nullptr, false);
    REQUIRE_FALSE(json.is_discarded());
    CHECK_THAT(json["options"]["problem"].get<std::string>(), Contains("n\xef\xbf\xbd.toml"));
  }
}

TEST_CASE("a command ends after --time with its results so far and reports this") {
  const TemporaryFolder folder;
  const std::string json = folder.file("r.json");
  const auto timed = [&](const std::string& command, std::vector<std::string> more, const std::string& id = "newton-elastic") {
    INFO(command);
    more.insert(more.end(), {"--time", "0.2", "--json", json});
    fs::remove(json);
    const Outcome outcome = call(command, id, more);
    const bool averaged = command == "lyapunov";  // an average over any number of periods is a result
    CHECK(outcome.code == (averaged ? 0 : 1));
    CHECK_THAT(outcome.out, Contains("the 0.2 s of --time were used up"));
    if (!averaged) CHECK_THAT(outcome.err, Contains("the 0.2 s of --time were used up"));
    const Json result = Json::parse(read_file(json), nullptr, false);
    REQUIRE_FALSE(result.is_discarded());
    CHECK(result["status"] == (averaged ? "done" : "interrupted"));
    CHECK_THAT(result["message"].get<std::string>(), Contains("the 0.2 s of --time were used up"));
    return result;
  };
  CHECK(timed("sweep", {"--from", "0.7", "--to", "0.76", "--step", "0.00001"})["rows"].size() > 0);
  timed("orbit", {"--search", "--period", "400"});
  timed("locate", {"--type", "NS", "--near", "0.7", "--period", "400"});
  timed("lyapunov", {"--set", "eta=0.711", "--standard-error", "1e-9", "--periods", "1000000000"});
  timed("attractors", {"--set", "eta=0.711", "--x=-2:2:900", "--v=-2:2:900"}, "hertz-damped");
  timed("diagram", {"--from", "0.5", "--to", "0.95"});
  timed("continue", {"--to", "0.2", "--switch", "12", "--multiples", "8"});
  const Outcome map =
      call("map", "hertz-damped",
           {"--param", "eta:0.65:0.95:900", "--param", "r:1:3:900", "--time", "0.2", "--out", folder.file("map")});
  CHECK(map.code == 1);
  CHECK_THAT(map.err, Contains("the 0.2 s of --time were used up; "));
  // A run that ends in time is not affected.
  const Json whole = json_of(call("orbit", "hertz-damped", {"--time", "1000", "--json", "-"}));
  CHECK_FALSE(whole.contains("message"));
  for (const char* wrong : {"0", "-1", "nan"}) {
    const Outcome misuse = call({"orbit", problem("hertz-damped"), std::string("--time=") + wrong});
    CHECK(misuse.code == 2);
    CHECK_THAT(misuse.err, Contains("--time is ") && Contains("allowed is > 0"));
  }
}

TEST_CASE("a call that is refused leaves no folder behind (fixed)") {
  const TemporaryFolder folder;
  const std::string out = folder.file("results"), good = GRAZE_DATA_DIR "/problems/newton-elastic.toml";
  const std::vector<std::vector<std::string>> refused = {{"orbit", folder.file("not-there.toml")},
                                                         {"orbit", good, "--start", "3,0"},
                                                         {"sweep", good, "--from", "0.9", "--to", "0.91", "--y", "max(q)"},
                                                         {"continue", good, "--param", "q", "--to", "1"}};
  for (std::vector<std::string> command : refused) {
    command.insert(command.end(), {"--out", out});
    INFO(fmt::format("{}", fmt::join(command, " ")));
    CHECK(call(command).code == 2);
    CHECK(!fs::exists(out));
  }
}
