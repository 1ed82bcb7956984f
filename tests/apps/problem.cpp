// SPDX-License-Identifier: GPL-3.0-or-later
// Problem files: their contents, and one sentence for each mistake.
#include "graze_program.hpp"

#include <graze/apps/problem/problem.hpp>

#include <catch2/catch.hpp>

#include <algorithm>
#include <stdexcept>
#include <string>

using namespace graze;
using namespace graze::apps;
using namespace graze::support;
using Catch::Matchers::Contains;

namespace {

const std::string model = "[model]\noscillator = \"linear\"\ncontact = \"hertz\"\n";
const std::string newton = "[model]\noscillator = \"linear\"\ncontact = \"newton\"\n";

Problem parsed(const std::string& text) { return parse_problem(text, "p.toml"); }

/// The message with which a file is refused. It is one line; two more show the place if the file is not TOML or has an unknown
/// section.
std::string refused(const std::string& text) {
  try {
    parsed(text);
  } catch (const std::invalid_argument& error) {
    const std::string message = error.what();
    const auto breaks = std::count(message.begin(), message.end(), '\n');
    const bool shows_line =
        message.find("not valid TOML") != std::string::npos || message.find("unknown section") != std::string::npos;
    CHECK(breaks == (shows_line ? 2 : 0));
    CHECK_THAT(message, Contains("p.toml"));
    return message;
  }
  return "(it was accepted)";
}

}  // namespace

TEST_CASE("a problem file is read") {
  const Problem p =
      parsed(model + "[parameters]\nb = 0.05\nbeta = \"36/35\"\nxi = 1\neta = \"pi/4\"\nr = -2\nk_H = 100.0\nb_H = 0.1\n"
                     "[start]\nstate = [0.5, \"-1/2\"]\nsettle = 20\nperiod = 2\n");
  CHECK(parameter(p, "b") == 0.05);
  CHECK(parameter(p, "beta") == 36.0 / 35.0);
  CHECK(parameter(p, "eta") == 3.141592653589793 / 4.0);
  CHECK(parameter(p, "r") == -2.0);
  CHECK(*p.start == Vector{{0.5, -0.5}});
  CHECK(p.settle == 20);
  CHECK(p.period == 2);
  CHECK(p.defaulted.empty());
  CHECK_FALSE(p.converted_from);
}

TEST_CASE("parameters missing from a file have their defaults and are named") {
  const Problem p = parsed(newton + "[parameters]\neta = 0.9\nr = 1\nk_r = 0.8\nb = 0.1\n");
  CHECK(p.defaulted == std::vector<std::string>{"beta", "xi"});
  CHECK(parameter(p, "xi") == 1.0);
}

TEST_CASE("every shipped problem file is read and complete") {
  for (const char* id : {"hertz-damped", "hertz-undamped", "newton-elastic", "beam-hertz", "beam-newton", "beam-linear"}) {
    INFO(id);
    const Problem p = load_problem(problem(id));
    CHECK(p.defaulted.empty());
    const bool beam = std::string(id).starts_with("beam");
    CHECK(parameter(p, "eta") == (beam ? 0.554 : 0.95));
    CHECK(parameter(p, "beta") == (beam ? 36.0 / 35.0 : 0.0));
    CHECK(p.oscillator == (beam ? "cantilever" : "linear"));
  }
}

TEST_CASE("physical quantities are converted") {
  const Problem p = parsed(
      model + "[physical]\nexcitation = \"kinematic\"\nm = 4\nk = 30\nk_e = 70\nc = 2\na = 0.04\nomega = 4.75\nrho = 0.08\n"
              "k_h = 50000\nb_h = 0.5\n");
  CHECK(parameter(p, "eta") == Approx(0.95).epsilon(1e-14));
  CHECK(parameter(p, "xi") == Approx(0.7).epsilon(1e-14));
  CHECK(parameter(p, "k_H") == Approx(100.0).epsilon(1e-14));
  CHECK(parameter(p, "beta") == 0.0);
  REQUIRE(p.converted_from);
  CHECK(p.converted_from->alpha == Approx(5.0).epsilon(1e-14));
  CHECK(p.converted_from->quantities.size() == 9);

  const Problem q =
      parsed(newton + "[physical]\nexcitation = \"force\"\nm = 4\nk = 100\nc = 2\nF0 = 4\nomega = 4.75\nrho = 0.08\nk_r = 0.7\n");
  CHECK(parameter(q, "k_r") == 0.7);
  CHECK(parameter(q, "r") == Approx(2.0).epsilon(1e-14));

  const Problem beam =
      parsed("[model]\noscillator = \"cantilever\"\ncontact = \"linear\"\n[physical]\nexcitation = \"beam\"\nM = 1.2\nL = 0.3\n"
             "EI = 0.0675\nc = 0.312\nF0 = 0.72\nomega = 2.77\nrho = 0.0237\nk_s = 750\n");
  CHECK(parameter(beam, "beta") == 36.0 / 35.0);
  CHECK(parameter(beam, "k_S") == Approx(25.0).epsilon(1e-14));
}

TEST_CASE("a setting of a physical quantity is converted and leaves independent parameters unchanged") {
  const std::string text = model + "[physical]\nexcitation = \"force\"\nm = 4\nk = 100\nc = 2\nF0 = 4\nomega = 4.75\nrho = 0.08\n"
                                   "k_h = 50000\nb_h = 0.5\n";
  Problem p = parsed(text);
  apply_settings(p, {"eta=0.7", "F0=8"});
  std::string doubled = text;
  doubled.replace(doubled.find("F0 = 4"), 6, "F0 = 8");
  const Problem q = parsed(doubled);
  for (const char* name : {"b", "xi", "r", "k_H", "b_H"}) CHECK(parameter(p, name) == parameter(q, name));
  CHECK(parameter(p, "eta") == 0.7);
  CHECK(p.converted_from->length == q.converted_from->length);
  apply_settings(p, {"omega=4.5"});
  CHECK(parameter(p, "eta") == Approx(0.9).epsilon(1e-14));
  CHECK_THROWS_WITH(apply_settings(p, {"F0=x"}), Contains("--set F0=x"));
  CHECK_THROWS_WITH(apply_settings(p, {"m=-1"}), Contains("--set m=-1") && Contains("> 0"));
}

TEST_CASE("a wrong problem file is refused in one sentence") {
  const std::string good = "[parameters]\nb = 0.05\n";
  SECTION("model") {
    CHECK_THAT(refused(good), Contains("section [model] is missing"));
    CHECK_THAT(refused("[model]\noscillator = \"linear\"\n" + good),
               Contains("lacks contact") && Contains("hertz, linear, newton"));
    CHECK_THAT(refused("[model]\noscillator = \"linear\"\ncontact = \"herz\"\n" + good),
               Contains("p.toml:3") && Contains("\"herz\"") && Contains("did you mean \"hertz\""));
    CHECK_THAT(refused("[model]\noscillator = \"linaer\"\ncontact = \"hertz\"\n" + good), Contains("did you mean \"linear\""));
    CHECK_THAT(refused("[model]\noscillator = 3\ncontact = \"hertz\"\n" + good),
               Contains("oscillator = 3") && Contains("text in quotes"));
    CHECK_THAT(refused("model = 3\n" + good), Contains("section [model]"));
    CHECK_THAT(refused(model + "law = 1\n" + good), Contains("unknown key 'law' in [model]; known are 'oscillator', 'contact'"));
  }
  SECTION("parameters") {
    CHECK_THAT(refused(model), Contains("neither") && Contains("[physical]"));
    CHECK_THAT(refused(model + good + "[physical]\nm = 1\n"), Contains("has both"));
    CHECK_THAT(refused(model + "[parameters]\nk_h = 100\n"),
               Contains("p.toml:5") && Contains("unknown key 'k_h' in [parameters]") && Contains("; did you mean 'k_H'?"));
    CHECK_THAT(refused(model + "[parameters]\nk_r = 0.5\n"), Contains("unknown key 'k_r'"));
    CHECK_THAT(refused(model + "[parameters]\nb = true\n"), Contains("b = true") && Contains("a number"));
    CHECK_THAT(refused(model + "[parameters]\nb = \"five\"\n"), Contains("five") && Contains("a number"));
    CHECK_THAT(refused(model + "[parameters]\nb = [1]\n"), Contains("a number"));
    CHECK_THAT(refused(model + "[parameters]\nb = -0.05\n"), Contains("p.toml:5") && Contains("b is -0.05") && Contains(">= 0"));
    CHECK_THAT(refused(model + "[parameters]\neta = 0\n"), Contains("eta is 0") && Contains("allowed is >= 0.0001"));
    CHECK_THAT(refused(model + "[parameters]\nr = nan\n"), Contains("r is nan") && Contains("any finite number"));
    CHECK_THAT(refused(model + "[parameters]\nr = inf\n"), Contains("r is inf"));
    CHECK_THAT(refused(newton + "[parameters]\nk_r = 1.2\n"), Contains("k_r is 1.2") && Contains("[0, 1]"));
  }
  SECTION("physical quantities") {
    const std::string head = model + "[physical]\n";
    CHECK_THAT(refused(head + "m = 1\n"), Contains("lacks excitation") && Contains("kinematic, force, beam"));
    CHECK_THAT(refused(head + "excitation = \"froce\"\n"), Contains("did you mean \"force\""));
    const std::string force = head + "excitation = \"force\"\nm = 4\nk = 100\nc = 2\nF0 = 4\nomega = 4.75\n";
    CHECK_THAT(refused(force), Contains("lacks rho") && Contains("clearance") && Contains("m)"));
    CHECK_THAT(refused(force + "rho = 0.08\n"), Contains("lacks k_h"));
    CHECK_THAT(refused(force + "rho = 0.08\nk_h = -1\n"), Contains("k_h is -1") && Contains("> 0"));
    CHECK_THAT(refused(force + "rho = 0.08\nk_h = 5e4\nk_H = 1\n"), Contains("unknown key 'k_H'"));
    CHECK_THAT(refused("[model]\noscillator = \"cantilever\"\ncontact = \"hertz\"\n[physical]\nexcitation = \"force\"\nm = 4\nk "
                       "= 100\nc = 2\nF0 = 4\n"
                       "omega = 1\nrho = 1\nk_h = 1\n"),
               Contains("lacks k_3"));
  }
  SECTION("start") {
    const std::string start = model + good + "[start]\n";
    CHECK_THAT(refused(start + "state = [1]\n"), Contains("two numbers [x, v]"));
    CHECK_THAT(refused(start + "state = 1\n"), Contains("two numbers [x, v]"));
    CHECK_THAT(refused(start + "settle = -1\n"), Contains("whole number >= 0"));
    CHECK_THAT(refused(start + "settle = 1.5\n"), Contains("whole number >= 0"));
    CHECK_THAT(refused(start + "period = 0\n"), Contains("whole number >= 1"));
    CHECK_THAT(refused(start + "periods = 1\n"), Contains("did you mean 'period'?"));
  }
  SECTION("limits and keys of the model") {
    CHECK_THAT(refused(model + good + "[start]\nperiod = 2000\n"), Contains("whole number >= 1 and <= 1024"));
    CHECK_THAT(refused(model + good + "[start]\nsettle = 99999999999\n"), Contains("<= 2147483647"));
    CHECK_THAT(refused("[model]\noscilator = \"linear\"\ncontact = \"hertz\"\n" + good),
               Contains("p.toml:2") && Contains("unknown key 'oscilator' in [model]; did you mean 'oscillator'?"));
    CHECK_THAT(refused(newton + "[parameters]\nk_H = 1\n"), Contains("k_H belongs to the hertz contact law"));
    CHECK_THAT(refused(model + "# \xff\n"), Contains("p.toml:4") && Contains("UTF-8"));
  }
  SECTION("TOML") {
    CHECK_THAT(refused(model + "[parametres]\nb = 1\n"),
               Contains("p.toml:4:2: unknown section [parametres]; did you mean [parameters]?\n"));
    CHECK_THAT(refused(model + std::string("x\0 = 1\n", 7)), Contains("p.toml:4:2: not valid TOML") && Contains("\nx? = 1\n ^"));
    CHECK_THAT(refused(model + "[parameters]\nb = \n"), Contains("p.toml:5") && Contains("not valid TOML"));
    CHECK_THAT(refused(model + "[parameters]\nb = 1\nb = 2\n"), Contains("p.toml:6:5: not valid TOML") && Contains("\n    ^"));
    CHECK_THAT(refused(""), Contains("[model]"));
  }
}

TEST_CASE("a missing problem file is refused with the nearest name") {
  CHECK_THROWS_WITH(load_problem(problem("hertz-dampd")), Contains("no such problem file") && Contains("hertz-damped.toml"));
  CHECK_THROWS_WITH(load_problem(GRAZE_DATA_DIR), Contains("is a folder"));
}

TEST_CASE("settings override parameters in order") {
  Problem p = load_problem(problem("newton-elastic"));
  apply_settings(p, {"eta=0.8", "k_r=1/2", "eta=0.744"});
  CHECK(parameter(p, "eta") == 0.744);
  CHECK(parameter(p, "k_r") == 0.5);
  CHECK_THROWS_WITH(apply_settings(p, {"eta"}), Contains("--set eta") && Contains("name=value"));
  CHECK_THROWS_WITH(apply_settings(p, {"etta=1"}), Contains("did you mean \"eta\""));
  CHECK_THROWS_WITH(apply_settings(p, {"k_H=1"}), Contains("no parameter \"k_H\""));
  CHECK_THROWS_WITH(apply_settings(p, {"eta=fast"}), Contains("\"fast\" is not a number"));
  CHECK_THROWS_WITH(apply_settings(p, {"k_r=1.2"}), Contains("k_r is 1.2") && Contains("[0, 1]"));
  CHECK(parameter(p, "k_r") == 0.5);
}

TEST_CASE("the start is at rest at 0 or at the barrier if 0 lies beyond it") {
  Problem p = load_problem(problem("newton-elastic"));
  CHECK(start_state(p, {}) == Vector{{0.0, 0.0}});
  apply_settings(p, {"r=-0.5"});
  CHECK(start_state(p, {}) == Vector{{-0.5, 0.0}});
  CHECK_THROWS_WITH(start_state(p, Vector{{0.0, 0.0}}), Contains("--start") && Contains("x <= r = -0.5"));
}
