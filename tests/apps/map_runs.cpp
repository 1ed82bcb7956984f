// SPDX-License-Identifier: GPL-3.0-or-later
// graze map: runs that are killed, interrupted, damaged and resumed; threads; ranks. A map contains no times, so that equal
// maps are equal files, byte by byte.
#include "graze_program.hpp"

#include <graze/apps/map/ranks.hpp>
#include <graze/apps/text/json.hpp>

#include <catch2/catch.hpp>

#include <fmt/format.h>

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

using namespace graze;
using namespace graze::apps;
using namespace graze::support;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

/// Mostly chaotic points, some hundredths of a second or more for each of 16 rows.
std::string options(int chunk = 1) {
  return fmt::format("map '{}' --param eta:0.70:0.74:8 --param r:1.95:2.1:16 --quiet --settle 6000 --chunk {}",
                     problem("hertz-damped"), chunk);
}

std::string program(const std::string& arguments) { return "'" GRAZE_PROGRAM "' " + arguments; }

int chunks(const std::string& out) {
  std::error_code error;
  int count = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(out + "/chunks", error))
    count += entry.path().extension() == ".chunk" && !entry.path().filename().string().starts_with(".") ? 1 : 0;
  return count;
}

/// The file of the map with these options, computed once on one thread.
const std::string& reference() {
  static const std::string bytes = [] {
    const TemporaryFolder folder;
    const Outcome outcome = run_shell(program(options() + " --threads 1 --h5 '" + folder.file("m.h5") + "'"));
    INFO(outcome.err);
    REQUIRE(outcome.code == 0);
    return read_file(folder.file("m.h5"));
  }();
  return bytes;
}

/// Checks a finished map: identical to the reference, and no chunks left.
void check_finished(const Outcome& outcome, const std::string& out) {
  INFO(outcome.err);
  CHECK(outcome.code == 0);
  CHECK(read_file(out + "/map.h5") == reference());
  CHECK_FALSE(fs::exists(out + "/chunks"));
}

/// Sends a signal when the folder has `count` chunks. The process is looked up before, so that the run does not wait.
std::function<bool(pid_t)> after(int count, const std::string& out, int signal, const std::function<pid_t()>& whom = {}) {
  return [=, target = pid_t(0)](pid_t child) mutable {
    if (target <= 0) target = whom ? whom() : child;
    return target > 0 && chunks(out) >= count && ::kill(target, signal) == 0;
  };
}

bool have_mpirun() {
  if (Ranks::with_mpi() && run_shell("mpirun --version").code == 0) return true;
  skip_test("mpirun is not installed, or graze was built without MPI: nothing was tested over several ranks");
  return false;
}

/// (Open MPI does not free all its memory, which a build with sanitizers would report.)
const std::string mpirun =
    "env ASAN_OPTIONS=detect_leaks=0 OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 mpirun --oversubscribe ";

/// The process of this rank in the run that writes to `out`.
pid_t process_of(int rank, const std::string& out) {
  const std::string variable = fmt::format("OMPI_COMM_WORLD_RANK={}", rank);
  for (const fs::directory_entry& entry : fs::directory_iterator("/proc")) {
    const std::string command = read_file(entry.path() / "cmdline"), name = entry.path().filename();
    if (command.find(out) == std::string::npos || read_file(entry.path() / "environ").find(variable) == std::string::npos)
      continue;
    return std::stoi(name);
  }
  return 0;
}

}  // namespace

TEST_CASE("map: two threads give the file of one") {
  const TemporaryFolder folder;
  const std::string out = folder.file("run");
  check_finished(run_shell(program(options(3) + " --threads 2 --out '" + out + "'")), out);
  CHECK(fs::exists(out + "/map-attractors.png"));
  CHECK(fs::exists(out + "/map-exponent.png"));
  // If it is resumed, it reports that nothing is left, and prints the results again.
  const Outcome again = run_shell(program(options() + " --resume '" + out + "' --json -"));
  CHECK(again.code == 0);
  CHECK(Json::parse(again.out)["layers"][0]["type"].size() == 16);
  // The place of the problem file and the form of its name do not matter.
  fs::copy_file(problem("hertz-damped"), folder.file("same.toml"));
  std::string renamed = options();
  renamed.replace(renamed.find(problem("hertz-damped")), problem("hertz-damped").size(), folder.file("./same.toml"));
  CHECK(run_shell(program(renamed + " --resume '" + out + "'")).code == 0);
  const Outcome other = run_shell(program(options() + " --set b=0.06 --resume '" + out + "'"));
  CHECK(other.code == 2);
  CHECK_THAT(other.err, Contains("is of another run: parameters.b is 0.05 there and 0.06 now; give the same"));
}

TEST_CASE("map: a finished one is replaced only on request and its pictures may be drawn later") {
  const TemporaryFolder folder;
  const std::string out = folder.file("run");
  const auto map = [&](const std::string& more) {
    return run_shell(program("map '" + problem("newton-elastic") + "' --quiet --param eta:0.65:0.95:3 " + more));
  };
  // A picture that cannot be written is reported and affects nothing else.
  fs::create_directories(out + "/map-attractors.png");
  const Outcome without = map("--param r:1:2:2 --out '" + out + "'");
  CHECK(without.code == 2);
  CHECK_THAT(without.err, Contains("map-attractors.png: cannot be written"));
  CHECK(fs::exists(out + "/map-exponent.png"));
  fs::remove(out + "/map-attractors.png");
  REQUIRE(map("--param r:1:2:2 --resume '" + out + "'").code == 0);
  CHECK(fs::exists(out + "/map-attractors.png"));
  const std::string first = read_file(out + "/map.h5");
  const Outcome refused = map("--param r:1:3:3 --out '" + out + "'");
  CHECK(refused.code == 2);
  CHECK_THAT(refused.err, Contains("another map is there") && Contains("--overwrite"));
  CHECK(map("--param r:1:2:2 --out '" + out + "'").code == 0);
  CHECK(read_file(out + "/map.h5") == first);
  CHECK_FALSE(fs::exists(out + "/chunks"));
  CHECK(map("--param r:1:3:3 --overwrite --out '" + out + "'").code == 0);
  CHECK(read_file(out + "/map.h5") != first);
  // The folder is created first, and the path of its map may be given explicitly.
  const std::string other = folder.file("other");
  CHECK(map("--param r:1:3:3 --out '" + other + "' --h5 '" + other + "/map.h5'").code == 0);
  CHECK(read_file(other + "/map.h5") == read_file(out + "/map.h5"));
  for (const std::string& wrong : {std::string("--overwrite"), "--overwrite --resume '" + out + "'"}) {
    const Outcome outcome = map("--param r:1:3:3 " + wrong);
    CHECK(outcome.code == 2);
    CHECK_THAT(outcome.err, Contains("--overwrite replaces the finished map in --out DIR"));
  }
}

TEST_CASE("map: killed at any moment it is resumed and gives the same map") {
  const TemporaryFolder folder;
  const std::string out = folder.file("run");
  for (const int enough : {1, 4, 9}) {  // killed three times with one or two rows in work
    const Outcome killed =
        run_shell(program(options() + " --threads 1 " + (enough == 1 ? "--out" : "--resume") + " '" + out + "'"),
                  after(enough, out, SIGKILL));
    CHECK(killed.code == -SIGKILL);
    CHECK_FALSE(fs::exists(out + "/map.h5"));
    CHECK(chunks(out) >= enough);
  }
  const int kept = chunks(out);
  // A partly written file, a damaged one, and a truncated one.
  std::ofstream(out + "/chunks/.000015.chunk.AbCdEf") << "half";
  std::ofstream(out + "/.map.h5.AbCdEf") << "half";
  std::string bytes = read_file(out + "/chunks/000000.chunk");
  bytes[bytes.size() / 2] ^= 1;
  std::ofstream(out + "/chunks/000000.chunk", std::ios::binary) << bytes;
  fs::resize_file(out + "/chunks/000001.chunk", 100);
  std::string loud = options();
  loud.erase(loud.find(" --quiet"), 8);
  const Outcome resumed = run_shell(program(loud + " --resume '" + out + "'"));
  CHECK_THAT(resumed.err, Contains(fmt::format("{} of 16 chunks are there already", kept - 2)) && Contains("2 damaged chunks"));
  check_finished(resumed, out);
  CHECK_FALSE(fs::exists(out + "/.map.h5.AbCdEf"));
}

TEST_CASE("map: rows that are followed are killed and resumed with many of them in work") {
  const TemporaryFolder folder;
  const std::string out = folder.file("run"), whole = folder.file("whole.h5"),
                    rows = "map '" + problem("hertz-damped") +
                           "' --param eta:0.70:0.74:3 --param r:1.95:2.1:200 --follow up --quiet";
  REQUIRE(run_shell(program(rows + " --h5 " + whole)).code == 0);
  for (const int enough : {1, 40}) {
    const std::string how = enough == 1 ? " --chunk 1 --out '" : " --resume '";
    CHECK(run_shell(program(rows + " --threads 1" + how + out + "'"), after(enough, out, SIGKILL)).code == -SIGKILL);
    CHECK(chunks(out) >= enough);
    CHECK_FALSE(fs::exists(out + "/map.h5"));
  }
  REQUIRE(run_shell(program(rows + " --resume '" + out + "'")).code == 0);
  CHECK(read_file(out + "/map.h5") == read_file(whole));
}

TEST_CASE("map: Ctrl-C ends it with its results so far and the way to resume") {
  const TemporaryFolder folder;
  const std::string out = folder.file("run"), json = folder.file("part.json");
  const Outcome outcome =
      run_shell(program(options() + " --threads 1 --out '" + out + "' --json '" + json + "'"), after(3, out, SIGINT));
  CHECK(outcome.code == 130);
  CHECK_THAT(outcome.err, Contains("interrupted; ") && Contains(" of 16 chunks are finished, --resume " + out + " goes on"));
  const Json part = Json::parse(read_file(json));
  CHECK(part["status"] == "interrupted");
  CHECK(part["layers"][0]["type"][0][0] != "not_run");
  CHECK(part["layers"][0]["type"][15][7] == "not_run");
  // A new map is not computed over it, and another map does not resume it.
  const Outcome anew = run_shell(program(options() + " --out '" + out + "'"));
  CHECK(anew.code == 2);
  CHECK_THAT(anew.err, Contains("holds an unfinished map; --resume"));
  const Outcome other = run_shell(program(options() + " --periods 400 --resume '" + out + "'"));
  CHECK(other.code == 2);
  CHECK_THAT(other.err, Contains("run.json is of another run: options.periods is 5000 there and 400 now; give the same"));
  // Two runs at a time are refused too.
  std::string second;
  const Outcome first = run_shell(program(options() + " --threads 1 --resume '" + out + "'"), [&](pid_t) {
    if (chunks(out) < 6) return false;
    second = run_shell(program(options() + " --resume '" + out + "'")).err;
    return true;
  });
  CHECK_THAT(second, Contains("another graze map is at work there"));
  check_finished(first, out);
}

TEST_CASE("map: interrupted without a folder it reports the place of its part") {
  const TemporaryFolder folder;
  const std::string json = folder.file("part.json"), h5 = folder.file("m.h5");
  const Outcome outcome =
      interrupt("map '" + problem("hertz-damped") +
                    "' --param eta:0.70:0.74:40 --param r:1.95:2.1:4000 --follow up --threads 1 --h5 " + h5 + " --json " + json,
                "mapping", SIGINT);
  CHECK(outcome.code == 130);
  CHECK_THAT(outcome.err,
             Contains("they go to --json and cannot be gone on with; --out DIR would keep them; --h5 is for whole maps"));
  CHECK_FALSE(fs::exists(h5));
  CHECK(Json::parse(read_file(json))["status"] == "interrupted");
}

TEST_CASE("map: a full disk is reported and no incomplete file is left") {
  const TemporaryFolder folder;
  // A limit on the file size has the same effect as a full disk.
  const Outcome outcome =
      run_shell(fmt::format("sh -c \"trap '' XFSZ; ulimit -f 8; exec {} \"",
                            program("map '" + problem("newton-elastic") +
                                    "' --param eta:0.65:0.95:60 --param r:1:3:20 --quiet --h5 '" + folder.file("m.h5") + "'")));
  CHECK(outcome.code == 2);
  CHECK_THAT(outcome.err, Contains("m.h5: cannot be written: File too large"));
  CHECK(folder.files() == 0);
}

TEST_CASE("map: of several that start in a folder at once one runs and the others give the reason") {
  const TemporaryFolder folder;
  const std::string map = program("map '" + problem("newton-elastic") + "' --param eta:0.65:0.95:60 --param r:1:3:50 --out run");
  std::string script = "cd '" + folder.file(".") + "'\n";
  for (int i = 0; i < 4; ++i) script += fmt::format("({} --quiet > out{} 2> error{}; echo $? > code{}) &\n", map, i, i, i);
  folder.write("all.sh", script + "wait\n");
  run_shell("sh '" + folder.file("all.sh") + "'");
  int done = 0;
  for (int i = 0; i < 4; ++i) {
    const int code = std::stoi(read_file(folder.file(fmt::format("code{}", i))));
    const std::string error = read_file(folder.file(fmt::format("error{}", i)));
    INFO(error);
    done += code == 0 ? 1 : 0;
    if (code == 0) continue;
    CHECK(code == 2);
    CHECK_THAT(error, Contains("another graze map is at work there") || Contains("another map is there"));
  }
  CHECK(done >= 1);
  CHECK(fs::exists(folder.file("run/map.h5")));
  CHECK_FALSE(fs::exists(folder.file("run/chunks")));
}

TEST_CASE("map: two ranks give the file of one process") {
  if (!have_mpirun()) return;
  const TemporaryFolder folder;
  const std::string out = folder.file("run");
  const Outcome outcome = run_shell(mpirun + "-n 2 " + program(options() + " --out '" + out + "'"));
  check_finished(outcome, out);
  // Only rank 0 writes messages.
  const std::size_t place = outcome.out.find("16 values");
  CHECK(place != std::string::npos);
  CHECK(outcome.out.find("16 values", place + 1) == std::string::npos);
  if (run_shell("h5diff --version").code != 0) return;
  std::ofstream(folder.file("one.h5"), std::ios::binary) << reference();
  CHECK(run_shell("h5diff '" + folder.file("one.h5") + "' '" + out + "/map.h5'").code == 0);
}

TEST_CASE("map: a rank that dies ends the run and the run can be resumed") {
  if (!have_mpirun()) return;
  const TemporaryFolder folder;
  const std::string out = folder.file("run");
  const Outcome killed = run_shell(mpirun + "-n 2 " + program(options() + " --out '" + out + "'"),
                                   after(3, out, SIGKILL, [&] { return process_of(1, out); }));
  CHECK(killed.code != 0);
  CHECK_THAT(killed.err, Contains("chunks are finished, --resume " + out + " goes on with them"));  // message of rank 0
  CHECK_THAT(killed.err, Contains("rank 1") || Contains("signal 9"));                               // message of mpirun
  CHECK_FALSE(fs::exists(out + "/map.h5"));
  CHECK(chunks(out) >= 3);
  check_finished(run_shell(mpirun + "-n 3 " + program(options() + " --resume '" + out + "'")), out);
}

TEST_CASE("a command of one process stays quiet and on its processors under mpirun") {
  if (!have_mpirun()) return;
  const Outcome outcome = run_shell(
      mpirun + "-n 2 " + program("sweep '" + problem("newton-elastic") + "' --from 0.7 --to 0.71 --step 0.005 --quiet"));
  CHECK(outcome.code == 0);
  CHECK_THAT(outcome.err, !Contains("TBB"));
}

TEST_CASE("map: misuse under mpirun is reported once and ends all ranks") {
  if (!have_mpirun()) return;
  for (const std::string wrong : {" --standard-error 0", " --nonsense"}) {
    const Outcome outcome = run_shell(mpirun + "-n 2 " + program(options() + wrong));
    CHECK(outcome.code == 2);
    const std::size_t place = outcome.err.find("graze map: ");
    CHECK(place != std::string::npos);
    CHECK(outcome.err.find("graze map: ", place + 1) == std::string::npos);
  }
}

TEST_CASE("map: under a launcher a graze without MPI reports this") {
  const TemporaryFolder folder;
  fs::copy_file(GRAZE_PROGRAM, folder.file("graze"));  // without its module
  const std::string map = "'" + folder.file("graze") + "' " + options();
  const Outcome launched = run_shell("env OMPI_COMM_WORLD_RANK=0 OMPI_COMM_WORLD_SIZE=2 " + map);
  CHECK(launched.code == 2);
  CHECK_THAT(launched.err, Contains(Ranks::with_mpi() ? "graze's module for MPI cannot be loaded (graze_mpi.so: "
                                                      : "this graze was built without MPI (-DGRAZE_WITH_MPI=ON)"));
}
