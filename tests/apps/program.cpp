// SPDX-License-Identifier: GPL-3.0-or-later
// The installed program: exit codes, one sentence per mistake, and no loss of computed results.
#include "graze_program.hpp"

#include <graze/apps/text/json.hpp>

#include <catch2/catch.hpp>

#include <fmt/format.h>

#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <thread>

using namespace graze;
using namespace graze::apps;
using namespace graze::support;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

/// Misuse: exit 2, nothing on stdout, one line on stderr.
std::string misuse(const std::string& arguments) {
  const Outcome outcome = spawn(arguments);
  INFO(arguments << "\n" << outcome.err);
  CHECK(outcome.code == 2);
  CHECK(outcome.out.empty());
  CHECK(std::count(outcome.err.begin(), outcome.err.end(), '\n') == 1);
  return outcome.err;
}

const std::string hertz = problem("hertz-damped"), newton = problem("newton-elastic");

}  // namespace

TEST_CASE("bare graze prints its usage on stderr with exit 2") {
  const Outcome outcome = spawn("");
  CHECK(outcome.code == 2);
  CHECK(outcome.out.empty());
  CHECK_THAT(outcome.err, Contains("Usage: graze") && Contains("orbit") && Contains("locate"));
}

TEST_CASE("version and help go to stdout with exit 0") {
  for (const char* arguments : {"--version", "orbit --version"}) CHECK_THAT(spawn(arguments).out, Contains("graze 0."));
  const Outcome help = spawn("--help");
  CHECK(help.code == 0);
  CHECK_THAT(help.out, Contains("Usage: graze") && Contains("continue"));
}

TEST_CASE("wrong commands and options are misuse") {
  CHECK_THAT(misuse("obrit " + hertz), Contains("no command \"obrit\"") && Contains("did you mean \"orbit\""));
  CHECK_THAT(misuse("orbit " + hertz + " --perod 2"), Contains("no option --perod") && Contains("did you mean --period"));
  CHECK_THAT(misuse("orbit " + hertz + " --grid 3"), Contains("there is no option --grid; `graze orbit --help` lists all"));
  CHECK_THAT(misuse("--foo"), Contains("there is no option --foo; `graze --help` lists all"));
  CHECK_THAT(misuse("orbit"), Contains("graze orbit: PROBLEM is required; give a FILE: problem file"));
  CHECK_THAT(misuse("orbit " + hertz + " again"), Contains("\"again\" is one argument too many; `graze orbit --help` lists all"));
  CHECK_THAT(misuse("orbit " + hertz + " --set b=0.06 r=2"),
             Contains("\"r=2\" is one argument too many") && Contains("behind a --set of its own: --set r=2"));
  CHECK_THAT(misuse("orbit " + hertz + " --period two"), Contains("--period two") && Contains("whole number >= 1"));
  CHECK_THAT(misuse("orbit " + hertz + " --period 0"), Contains("whole number >= 1"));
  CHECK_THAT(misuse("orbit " + hertz + " --settle -5"), Contains("whole number >= 0"));
  CHECK_THAT(misuse("orbit " + hertz + " --settle"), Contains("--settle"));
  CHECK_THAT(misuse("orbit " + hertz + " --start 1"), Contains("--start 1") && Contains("two numbers x,v"));
  CHECK_THAT(misuse("orbit " + hertz + " --start nan,0"), Contains("--start nan,0: the state holds a value that is not"));
  CHECK_THAT(misuse("continue " + hertz), Contains("--to is required; give --to VALUE: last value of the parameter"));
  CHECK_THAT(misuse("continue " + hertz + " --to"), Contains("--to lacks its value; give --to VALUE"));
  CHECK_THAT(misuse("continue " + hertz + " --to 0.95"), Contains("eta is 0.95 at the start already"));
  CHECK_THAT(misuse("continue " + hertz + " --to -1"), Contains("--to -1: parameter eta is -1; allowed is >= 0.0001"));
  CHECK_THAT(misuse("continue " + hertz + " --from nan --to 0.9"), Contains("--from nan: parameter eta is nan"));
  CHECK_THAT(misuse("continue " + hertz + " --to 0.9 --max-step 0"), Contains("--max-step is 0; allowed is > 0"));
  CHECK_THAT(misuse("locate " + hertz + " --type PD --near 0.9 --reach 0"), Contains("--reach 0: must be > 0"));
  CHECK_THAT(misuse("locate " + hertz + " --type PD --near -1"), Contains("--near -1: parameter eta is -1"));
  CHECK_THAT(misuse("locate " + hertz + " --type pd --near 0.9"), Contains("did you mean PD?"));
  CHECK_THAT(misuse("orbit " + hertz + " --period 1 --period 2"), Contains("--period is given 2 times; give it once"));
  CHECK_THAT(misuse("orbit " + hertz + " --settle"), Contains("--settle lacks its value"));
  CHECK_THAT(misuse("orbit " + hertz + " --json ''"), Contains("--json \"\": must be a name, and not empty"));
  CHECK_THAT(misuse("continue " + hertz + " --to 0.9 --param etta"),
             Contains("--param etta: there is no parameter \"etta\"") && Contains("did you mean \"eta\""));
  CHECK_THAT(misuse("locate " + hertz + " --near 0.92 --type PB"), Contains("--type PB") && Contains("PD"));
  CHECK_THAT(misuse("locate " + hertz + " --type PD"), Contains("--near is required"));
  CHECK_THAT(misuse("locate " + hertz + " --type PD --near 1e400"), Contains("--near 1e400: must be 0 or of a magnitude from"));
}

TEST_CASE("a missing problem file is misuse") {
  CHECK_THAT(misuse("orbit nowhere.toml"), Contains("nowhere.toml: no such problem file"));
}

TEST_CASE("a problem file with a mistake is misuse") {
  const TemporaryFolder folder;
  const std::string head = "[model]\noscillator = \"linear\"\ncontact = \"newton\"\n[parameters]\n";
  const auto refused = [&](const std::string& lines) { return misuse("orbit " + folder.write("p.toml", head + lines)); };
  CHECK_THAT(refused("k_R = 0.5\n"), Contains("p.toml:5") && Contains("unknown key 'k_R' in [parameters]; did you mean 'k_r'?"));
  CHECK_THAT(refused("b = false\n"), Contains("b = false") && Contains("must be a number"));
  CHECK_THAT(refused("k_r = 1.2\n"), Contains("k_r is 1.2; allowed is [0, 1]"));
  CHECK_THAT(refused("b = -1\n"), Contains("b is -1; allowed is >= 0"));
  CHECK_THAT(refused("eta = 0\n"), Contains("eta is 0; allowed is >= 0.0001"));
  CHECK_THAT(refused("r = nan\n"), Contains("r is nan; allowed is any finite number"));
}

TEST_CASE("a wrong setting is misuse") {
  CHECK_THAT(misuse("orbit " + newton + " --set k_r=1.2"), Contains("k_r is 1.2; allowed is [0, 1]"));
  CHECK_THAT(misuse("orbit " + newton + " --set b=-0.1"), Contains("b is -0.1; allowed is >= 0"));
  CHECK_THAT(misuse("orbit " + newton + " --set eta=0"), Contains("eta is 0; allowed is >= 0.0001"));
  CHECK_THAT(misuse("orbit " + newton + " --set eta=1e-5"), Contains("eta is 1e-05; allowed is >= 0.0001"));
  CHECK_THAT(misuse("orbit " + newton + " --set eta=1e400"), Contains("\"1e400\" is too large") && !Contains("not a number"));
  CHECK_THAT(misuse("orbit " + newton + " --set eta=1/0"), Contains("eta is inf; allowed is a finite number >= 0.0001"));
  CHECK_THAT(misuse("orbit " + newton + " --set r=nan"), Contains("r is nan; allowed is any finite number"));
  CHECK_THAT(misuse("orbit " + newton + " --set k_H=100"),
             Contains("no parameter \"k_H\"") && Contains("k_r") && Contains("k_H belongs to the hertz contact law"));
  for (const std::string name : {"k_e", "F0", "k_h"})  // of an excitation, of another, of a contact
    CHECK_THAT(misuse("orbit " + newton + " --set " + name + "=100"), Contains("choose one of b, beta, ") &&
                                                                          Contains(name + " is a physical quantity") &&
                                                                          Contains("section [physical]"));
  CHECK_THAT(misuse("orbit " + newton + " --set nonsense=1"), !Contains("physical"));
}

TEST_CASE("defaults are noted with the option for others except where a setting gave a value") {
  const TemporaryFolder folder;
  const std::string file =
      folder.write("p.toml", "[model]\noscillator = \"linear\"\ncontact = \"newton\"\n[parameters]\neta = 0.9\nr = 1\nk_r = 0.8\n"
                             "b = 0.1\n");
  const std::string both = spawn("orbit " + file + " --settle 10").err,
                    one = spawn("orbit " + file + " --settle 10 --set xi=0.9").err;
  CHECK_THAT(both, Contains("does not give beta = 0, xi = 1: these are defaults; give others in its [parameters] or by --set"));
  CHECK_THAT(one, Contains("does not give beta = 0: "));
}

TEST_CASE("the last of several settings of a parameter counts") {
  const Outcome outcome = spawn("orbit " + hertz + " --set eta=0.9 --set eta=0.95 --settle 300");
  CHECK(outcome.code == 0);
  CHECK_THAT(outcome.out, Contains("eta = 0.95"));
  CHECK_THAT(spawn("orbit --help").out, Contains("the last one holds"));
}

TEST_CASE("extreme computing times and memory are refused") {
  for (const char* eta : {"1e-7", "1e-9", "1e-320"})
    for (const char* command : {"orbit ", "orbit --search ", "trajectory ", "poincare "})
      CHECK_THAT(misuse(command + newton + " --set eta=" + eta), Contains("eta is 1e-") && Contains("allowed is >= 0.0001"));
  CHECK(spawn("continue " + hertz + " --to 0.949 --settle 300").code == 0);
  CHECK_THAT(misuse("orbit " + newton + " --period 100000"),
             Contains("--period 100000: must be a whole number >= 1 and <= 1024"));
  CHECK_THAT(misuse("orbit " + newton + " --settle 99999999999"), Contains("must be a whole number >= 0 and <= 2147483647"));
  CHECK_THAT(misuse("poincare " + newton + " --points 1e8"), Contains("and <= 5000000"));
  for (const char* option : {" --samples 2000000000", " --periods 100000000"})
    CHECK_THAT(misuse("trajectory " + hertz + option), Contains("more than 2000000 samples"));
}

TEST_CASE("a problem is read from a regular file of reasonable size") {
  const TemporaryFolder folder;
  REQUIRE(::mkfifo(folder.file("pipe.toml").c_str(), 0600) == 0);
  CHECK_THAT(misuse("orbit " + folder.file("pipe.toml")), Contains("is not a regular file"));
  CHECK_THAT(misuse("orbit /dev/zero"), Contains("/dev/zero: is not a regular file"));
  CHECK_THAT(misuse("orbit " + folder.write("big.toml", std::string(1000001, '#'))), Contains("larger than 1000000 bytes"));
  CHECK_THAT(misuse("plot " + folder.file("pipe.toml") + " -o " + folder.file("x.png")), Contains("is not a regular file"));
}

TEST_CASE("an output is not written over the input or over another output") {
  const TemporaryFolder folder;
  const std::string text = read_file(hertz), input = folder.write("h.toml", text), other = folder.file("a.json");
  const std::string run = "orbit " + input + " --settle 100000000 ";
  CHECK_THAT(misuse(run + "--csv " + folder.file("./h.toml")), Contains("--csv") && Contains("this is the file that is read"));
  CHECK_THAT(misuse(run + "--json " + other + " --csv " + other),
             Contains("--json") && Contains("--csv") && Contains("are one file"));
  std::filesystem::create_symlink(input, folder.file("link"));
  CHECK_THAT(misuse(run + "--json " + folder.file("link")), Contains("this is the file that is read"));
  CHECK(read_file(input) == text);
  CHECK(spawn("orbit " + hertz + " --settle 300 --json /dev/null --csv /dev/null").code == 0);
}

TEST_CASE("an output through a link to a pipe goes into the pipe") {
  const Outcome outcome = run_shell(fmt::format("sh -c \"'{}' models --json /dev/stdout | cat\"", GRAZE_PROGRAM));
  CHECK(outcome.err.empty());
  CHECK_THAT(outcome.out, Contains("graze.models/1"));
}

TEST_CASE("an output whose name is a link goes to the target of the link") {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.file("there"));
  for (const char* name : {"old.json", "new.json"})
    std::filesystem::create_symlink(folder.file("there/") + name, folder.file(name));
  folder.write("there/old.json", "before");
  const Outcome outcome = spawn("models --json " + folder.file("old.json") + " --csv " + folder.file("t.csv"));
  CHECK(outcome.code == 0);
  CHECK(spawn("models --json " + folder.file("new.json")).code == 0);
  for (const char* name : {"old.json", "new.json"}) {
    CHECK(std::filesystem::is_symlink(folder.file(name)));
    CHECK(std::filesystem::is_regular_file(folder.file("there/") + name));
    CHECK_THAT(read_file(folder.file("there/") + name), Contains("graze.models/1"));
  }
  std::filesystem::create_symlink(folder.file("loop.json"), folder.file("loop.json"));
  CHECK_THAT(misuse("models --json " + folder.file("loop.json")), Contains("Too many levels of symbolic links"));
}

TEST_CASE("a name of another kind of file is refused") {
  CHECK_THAT(misuse("models --json a.csv"),
             Contains("--json a.csv: such a name is that of another kind of file") && Contains("ends in .json"));
  CHECK_THAT(misuse("orbit " + hertz + " --csv a.png"), Contains("--csv a.png"));
  const std::string map = "map " + newton + " --param eta:0.7:0.8:2 --param r:1:2:2 --h5 ";
  CHECK_THAT(misuse(map + "a.json"), Contains("--h5 a.json") && Contains("ends in .h5 or .hdf5"));
  CHECK_THAT(misuse(map + "-"), Contains("HDF5 does not go to stdout"));
  const TemporaryFolder folder;
  REQUIRE(::mkfifo(folder.file("pipe").c_str(), 0600) == 0);
  CHECK_THAT(misuse(map + folder.file("pipe")), Contains("this is a device, a pipe or a folder"));
}

TEST_CASE("a user value outside the range gives a warning") {
  const Outcome outcome = spawn("continue " + hertz + " --to 0.949 --settle 300 --user 5");
  CHECK(outcome.code == 0);
  CHECK_THAT(outcome.err, Contains("--user 5 lies outside 0.95 to 0.949"));
}

TEST_CASE("a result that cannot be drawn is named with the reason") {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& name, const std::string& content) {
    return misuse("plot " + folder.write(name, content) + " -o " + folder.file("x.png"));
  };
  CHECK_THAT(refused("r.csv", "a,b\n1\n"), Contains("graze plot: " + folder.file("r.csv") + ":2: 1 cell"));
  CHECK_THAT(refused("h.csv", "a,b\n"), Contains("h.csv: there is nothing to draw: the table is a header without rows"));
  CHECK_THAT(refused("w.csv", "a,b\nx,y\n"), Contains("w.csv: a picture needs two columns of numbers; a has text in row 1"));
  CHECK_THAT(refused("d.json", "{\n\"schema\": [1,"), Contains("d.json: invalid JSON: the file ends early, in line 2"));
  const std::string lacking = refused("e.json", "{\"schema\": \"graze.branch/1\"}");
  CHECK_THAT(lacking, Contains("key 'parameter' not found") && !Contains("json.exception"));
}

TEST_CASE("a start inside a hard barrier is misuse") {
  CHECK_THAT(misuse("orbit " + newton + " --start 2.5,0"), Contains("--start") && Contains("barrier"));
  CHECK_THAT(misuse("trajectory " + newton + " --start 2.5,0"), Contains("--start") && Contains("barrier"));
  CHECK(spawn("orbit " + hertz + " --start 2.5,0 --settle 300").code == 0);  // a soft one may be entered
}

TEST_CASE("an output that cannot be written is detected before computing") {
  const TemporaryFolder folder;
  const std::string file = folder.write("file", "");
  const std::string long_run = "orbit " + hertz + " --settle 100000000 ";  // would take minutes
  CHECK_THAT(misuse(long_run + "--json /nowhere/x.json"),
             Contains("/nowhere/x.json: cannot be written: there is no folder /nowhere"));
  CHECK_THAT(misuse(long_run + "--csv " + file + "/x.csv"), Contains("cannot be written"));
  CHECK_THAT(misuse(long_run + "--plot x.gif"), Contains("x.gif") && Contains(".png, .svg or .pdf"));
  CHECK_THAT(misuse(long_run + "--out " + file), Contains("cannot be made as a folder"));
  CHECK_THAT(misuse(long_run + "--json - --csv -"), Contains("cannot both go to stdout"));
  CHECK_THAT(misuse("plot " + folder.file("none.json") + " -o " + folder.file("x.png")), Contains("no such file"));
  CHECK(folder.files() == 1);
}

TEST_CASE("on a full disk the result still goes to stdout") {
  const Outcome outcome = spawn("orbit " + hertz + " --settle 300 --json /dev/full");
  CHECK(outcome.code == 2);
  CHECK_THAT(outcome.err, Contains("/dev/full: cannot be written: No space left on device"));
  CHECK_THAT(outcome.out, Contains("orbit z = 1/1"));
}

TEST_CASE("a full stdout is reported") {
  for (const std::string& arguments :
       {"orbit " + hertz + " --settle 300 --json -", std::string("--help"), std::string("models")}) {
    const Outcome outcome = spawn(arguments + " > /dev/full");
    CHECK(outcome.code == 2);
    CHECK_THAT(outcome.err, Contains("stdout: cannot be written: No space left on device"));
  }
}

TEST_CASE("an orbit that does not exist is exit 1 with the orbit found instead") {
  const TemporaryFolder folder;
  const Outcome outcome = spawn("orbit " + hertz + " --set r=100 --period 2 --quiet --json " + folder.file("o.json"));
  CHECK(outcome.code == 1);
  CHECK_THAT(outcome.err,
             Contains("no admissible orbit of period 2") && Contains("repeats after 1 forcing period (z = 0/1, stable)"));
  const Json json = Json::parse(read_file(folder.file("o.json")));
  CHECK(json["orbit"].is_null());
  CHECK(json["status"] == "failed");
  CHECK_THAT(json["message"].get<std::string>(), Contains("no admissible orbit of period 2"));
}

TEST_CASE("Ctrl-C keeps the computed results and exits with 130") {
  const TemporaryFolder folder;
  const std::string out = folder.file("r.json");
  // Each command has work for minutes at least, with the first word of its progress.
  const std::pair<std::string, const char*> commands[] = {
      {"orbit " + hertz + " --settle 100000000", "settling"},
      {"trajectory " + newton + " --settle 0 --set r=0 --periods 2000000 --samples 1", "running"},
      {"poincare " + newton + " --settle 0 --set r=0 --points 5000000", "collecting"},
      {"sweep " + newton + " --from 0.7 --to 0.76 --step 0.0000006", "sweeping"},
      {"lyapunov " + newton + " --set eta=0.711 --settle 200 --periods 1000000000 --standard-error 0", "averaging"},
      {"continue " + hertz + " --to 0.3 --max-step 1e-5", "following"},
      {"verify " + hertz + " --from 0.95 --to 0.9 --step 0.000001", "following"},
      {"reproduce --no-claims", "reproducing"},
      {"diagram " + hertz + " --from 0.65 --to 0.95 --skeleton", "skeleton"},
  };
  for (const auto& [arguments, sign] : commands) {
    interrupted_json(arguments, out, sign);
    CHECK(folder.files() == 1);
    std::filesystem::remove(out);
  }
  // A forcing period of thousands of the oscillator's own: in the transient and in the search.
  for (const char* slow : {" --settle 100000", " --search"}) {
    const Outcome outcome = interrupt("orbit " + problem("beam-newton") + " --set eta=1e-3" + slow, "", SIGTERM);
    CHECK(outcome.code == 130);
    CHECK_THAT(outcome.err, Contains("interrupted"));
  }
  const Outcome search = interrupt("orbit " + newton + " --period 400 --search --json " + out, "searching", SIGINT);
  CHECK(search.code == 130);
  CHECK_THAT(search.err, Contains("interrupted after"));
}

TEST_CASE("every request to end keeps the computed results (under nohup a closed terminal is no request)") {
  const TemporaryFolder folder;
  const std::string out = folder.file("r.json");
  const std::string sweep = "sweep " + newton + " --from 0.7 --to 0.76 --step 0.000006 --json " + out;
  const auto before = std::signal(SIGHUP, SIG_DFL);  // these tests may run under nohup themselves and pass it on
  for (const int signal : {SIGTERM, SIGHUP}) {
    const Outcome outcome = interrupt(sweep, "sweeping", signal);
    CHECK(outcome.code == 130);
    CHECK_THAT(outcome.err, Contains("interrupted after ") && Contains(" of 10001 values"));
    const Json json = Json::parse(read_file(out), nullptr, false);
    REQUIRE_FALSE(json.is_discarded());
    CHECK(json["status"] == "interrupted");
    CHECK_FALSE(json["rows"].empty());
    std::filesystem::remove(out);
  }
  // Child processes inherit ignored signals.
  std::signal(SIGHUP, SIG_IGN);
  const Outcome outcome = interrupt(sweep, "sweeping", SIGHUP);
  std::signal(SIGHUP, before);
  CHECK(outcome.code == 0);
  CHECK(Json::parse(read_file(out))["status"] == "done");
}

TEST_CASE("without gnuplot every command runs without pictures and reports their absence") {
  const TemporaryFolder folder, empty;
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", empty.file("").c_str(), 1);
  const Outcome models = spawn("models --out " + folder.file("models"));
  const Outcome lyapunov = spawn("lyapunov " + hertz + " --quiet --out " + folder.file("lyapunov"));
  const Outcome sweep = spawn("sweep " + newton + " --from 0.9 --to 0.91 --step 0.01 --out " + folder.file("sweep"));
  const Outcome orbit = spawn("orbit " + hertz + " --quiet --json " + folder.file("o.json") + " --plot " + folder.file("o.png"));
  const Outcome map = spawn("map " + newton + " --param eta:0.8:0.9:2 --param r:1:2:2 --out " + folder.file("map"));
  const Outcome plot = spawn("plot " + folder.file("o.json") + " -o " + folder.file("p.png"));
  ::setenv("PATH", path.c_str(), 1);
  CHECK(models.code == 0);
  CHECK(std::filesystem::exists(folder.file("models/models.json")));
  CHECK(lyapunov.code == 0);
  CHECK(std::filesystem::exists(folder.file("lyapunov/lyapunov.csv")));
  for (const Outcome& outcome : {models, lyapunov}) CHECK_THAT(outcome.err, !Contains("gnuplot"));
  for (const Outcome& outcome : {sweep, orbit, map}) {
    CHECK(outcome.code == 0);
    CHECK_THAT(outcome.err, Contains("gnuplot, which is not installed") && Contains("left out"));
  }
  CHECK(Json::parse(read_file(folder.file("sweep/sweep.json")))["status"] == "done");
  CHECK(Json::parse(read_file(folder.file("o.json")))["status"] == "done");
  CHECK(std::filesystem::exists(folder.file("map/map.h5")));
  CHECK_FALSE(std::filesystem::exists(folder.file("o.png")));
  // There is nothing left to do.
  CHECK(plot.code == 2);
  CHECK_THAT(plot.err, Contains("gnuplot, which is not installed"));
  CHECK(folder.files() == 5);
}

TEST_CASE("numbers are written before pictures are drawn") {
  const TemporaryFolder folder;
  const std::string path = std::getenv("PATH"), out = folder.file("out"), seen = folder.file("seen");
  std::filesystem::permissions(folder.write("gnuplot", "#!/bin/sh\necho drawing $(ls '" + out + "') >> '" + seen + "'\nexit 1\n"),
                               std::filesystem::perms::owner_all);
  ::setenv("PATH", (folder.file("") + ":" + path).c_str(), 1);
  const Outcome outcome = spawn("orbit " + newton + " --quiet --plot " + folder.file("x.png") + " --out " + out);
  ::setenv("PATH", path.c_str(), 1);
  CHECK(outcome.code == 2);  // nothing was drawn
  CHECK_THAT(read_file(seen), StartsWith("drawing orbit.csv orbit.json\n"));
}

TEST_CASE("gnuplot does not outlive the program or its time limit") {
  const bool map = GENERATE(false, true);
  const TemporaryFolder folder;
  const std::string pid_file = folder.file("pid"), path = std::getenv("PATH");
  const std::string table = folder.write("t.csv", "a,b\n1,2\n2,3\n");
  std::filesystem::permissions(folder.write("gnuplot", "#!/bin/sh\necho $$ > '" + pid_file + "'\nexec sleep 60\n"),
                               std::filesystem::perms::owner_all);
  for (const int signal : {SIGINT, SIGTERM, SIGKILL}) {
    std::filesystem::remove(pid_file);
    ::setenv("PATH", (folder.file("") + ":" + path).c_str(), 1);
    const std::string arguments =
        map ? "map " + newton + " --quiet --param eta:0.8:0.9:2 --param r:1:2:2 --plot " + folder.file("x.png")
            : "plot " + table + " -o " + folder.file("x.png");
    const Outcome outcome = run_shell("'" GRAZE_PROGRAM "' " + arguments, [&](pid_t child) {
      return read_file(pid_file).ends_with('\n') && ::kill(child, signal) == 0;  // it draws
    });
    ::setenv("PATH", path.c_str(), 1);
    CHECK(outcome.code == (signal == SIGKILL ? -SIGKILL : 130));
    if (signal != SIGKILL) CHECK_THAT(outcome.err, Contains("drawing was interrupted"));
    const std::string pid = read_file(pid_file);
    REQUIRE_FALSE(pid.empty());
    // Gone, or dead and not yet reaped by its new parent. The kernel may need some time; the script would take a minute.
    const auto is_gone = [stat = "/proc/" + pid.substr(0, pid.find('\n')) + "/stat"] {
      const std::string state = read_file(stat);
      return state.empty() || state.find(") Z ") != std::string::npos;
    };
    const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (!is_gone() && std::chrono::steady_clock::now() < patience) std::this_thread::yield();
    CHECK(is_gone());
  }
  CHECK_FALSE(std::filesystem::exists(folder.file("x.png")));
}

TEST_CASE("a negative start may follow a blank or an equals sign") {
  const Outcome blank = spawn("orbit " + newton + " --set eta=0.744 --period 4 --start -0.169,-0.962 --json -");
  const Outcome equals = spawn("orbit " + newton + " --set eta=0.744 --period 4 --start=-0.169,-0.962 --json -");
  CHECK(blank.code == 0);
  CHECK(blank.out == equals.out);
  CHECK_THAT(blank.out, Contains("\"start\": [-0.169,-0.962]"));
  CHECK(spawn("orbit " + newton + " --start -.1,-.2 --settle 5 --set r=100").code == 0);
}

TEST_CASE("progress goes to stderr and quiet silences it") {
  const Outcome loud = spawn("orbit " + hertz + " --set eta=0.91 --period 1 --json -");
  CHECK_THAT(loud.err, Contains("searching for orbits of period 1"));
  CHECK_FALSE(Json::parse(loud.out, nullptr, false).is_discarded());
  CHECK(spawn("orbit " + hertz + " --set eta=0.91 --period 1 --quiet").err.empty());
}
