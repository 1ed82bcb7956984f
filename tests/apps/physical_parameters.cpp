// SPDX-License-Identifier: GPL-3.0-or-later
// Motions followed in a physical quantity (--param omega), against the corresponding dimensionless parameters.
#include "graze_program.hpp"

#include <catch2/catch.hpp>

#include <cmath>

using namespace graze;
using namespace graze::apps;
using namespace graze::support;
using Catch::Matchers::Contains;

namespace {

/// alpha = 5 rad/s and length = 0.04 m: eta = omega/5, r = rho/0.04.
std::string shaker(const std::string& contact) {
  return "[model]\noscillator = \"linear\"\ncontact = \"" + contact +
         "\"\n[physical]\nexcitation = \"kinematic\"\nm = 4\nk = 30\nk_e = 70\nc = 2\na = 0.04\nomega = 4.75\nrho = 0.08\n" +
         (contact == "newton" ? "k_r = 0.8\n" : "k_h = 50000\nb_h = 0.5\n");
}

Json result(std::vector<std::string> arguments) {
  arguments.insert(arguments.end(), {"--quiet", "--json", "-"});
  return json_of(call(arguments));
}

/// Values of the special points of the first branch, with their types.
std::vector<std::pair<std::string, double>> special_points(const Json& branches) {
  std::vector<std::pair<std::string, double>> out;
  for (const Json& point : branches.at("branches").at(0).at("special_points"))
    out.emplace_back(point.at("type"), point.at("value").get<double>());
  return out;
}

}  // namespace

TEST_CASE("a branch in omega is the branch in eta at omega = alpha eta") {
  const TemporaryFolder folder;
  for (const std::string contact : {"newton", "hertz"}) {
    INFO(contact);
    const std::string file = folder.write("shaker-" + contact + ".toml", shaker(contact));
    const Json physical = result({"continue", file, "--param", "omega", "--to", "4.05"});
    const Json dimensionless = result({"continue", file, "--param", "eta", "--to", "0.81"});
    const auto in_omega = special_points(physical), in_eta = special_points(dimensionless);
    REQUIRE(in_omega.size() == in_eta.size());
    REQUIRE(!in_omega.empty());
    for (std::size_t i = 0; i < in_omega.size(); ++i) {
      CHECK(in_omega[i].first == in_eta[i].first);
      CHECK(in_omega[i].second == Approx(5.0 * in_eta[i].second).epsilon(1e-12));
    }
    CHECK(physical.at("tied").at("eta").get<double>() == Approx(0.95).epsilon(1e-15));
    CHECK(physical.at("parameters").at("omega") == 4.75);
    CHECK(!physical.at("parameters").contains("eta"));
    CHECK(physical.at("converted_from").at("varied") == Json({"omega"}));
  }
}

TEST_CASE("a quantity with several dependent dimensionless parameters changes all of them") {
  const TemporaryFolder folder;
  // The amplitude a of the base is the length: r = rho/a, k_H ~ sqrt(a), b_H ~ a.
  const std::string file = folder.write("base.toml", shaker("hertz"));
  const Json branch = result({"continue", file, "--param", "a", "--to", "0.042", "--y", "max(X)"});
  const Json& last = branch.at("branches").at(0).at("points").back();
  REQUIRE(last.at("value") == 0.042);
  const Json orbit = result({"orbit", file, "--set", "a=0.042", "--y", "max(X)", "--start",
                             last.at("state").at(0).dump() + "," + last.at("state").at(1).dump(), "--settle", "0"});
  CHECK(last.at("state").at(0).get<double>() == Approx(orbit.at("orbit").at("state").at(0).get<double>()).epsilon(1e-10));
  CHECK(last.at("y").at("max(X)").get<double>() == Approx(orbit.at("orbit").at("y").at("max(X)").get<double>()).epsilon(1e-9));
}

TEST_CASE("sweeps, maps, locate and verify take physical quantities and a diagram in one runs in the lanes") {
  const TemporaryFolder folder;
  const std::string file = folder.write("quantities.toml", shaker("hertz"));
  const Json point = result({"locate", file, "--param", "omega", "--type", "PD", "--near", "4.62"});
  CHECK(point.at("special_point").at("value").get<double>() == Approx(5.0 * 0.925999301936).epsilon(1e-11));
  const Json in_omega = result({"sweep", file, "--param", "omega", "--from", "4.5", "--to", "4.7", "--step", "0.05"});
  const Json in_eta = result({"sweep", file, "--param", "eta", "--from", "0.9", "--to", "0.94", "--step", "0.01"});
  REQUIRE(in_omega.at("rows").size() == in_eta.at("rows").size());
  for (std::size_t i = 0; i < in_eta["rows"].size(); ++i) {
    CHECK(in_omega["rows"][i].at("attractor").at("period") == in_eta["rows"][i].at("attractor").at("period"));
    const double a = in_omega["rows"][i].at("exponents").at(0), b = in_eta["rows"][i].at("exponents").at(0);
    CHECK(a == Approx(b).margin(1e-9));
  }
  const Json map = result({"map", file, "--param", "omega:4.4:4.8:3", "--param", "rho:0.07:0.09:2"});
  CHECK(map.at("status") == "done");
  CHECK(result({"verify", file, "--param", "omega"}).at("status") == "done");
}

TEST_CASE("a dimensionless parameter must not contradict the varied quantity") {
  const TemporaryFolder folder;
  const std::string file = folder.write("contradiction.toml", shaker("newton"));
  const Outcome set = call({"continue", file, "--param", "omega", "--set", "eta=0.9", "--to", "4"});
  CHECK(set.code == 2);
  CHECK_THAT(set.err, Contains("--param omega: eta is 0.9 by --set and 0.95 by [physical]"));
  const Outcome other = call({"continue", file, "--param", "omega", "--set", "b=0.04", "--to", "4.7", "--quiet"});
  CHECK(other.code == 0);
  // The physical quantities are among the known names.
  for (const char* option : {"--set", "--param"}) {
    const Outcome unknown = call({"continue", file, option, option == std::string("--set") ? "omgea=4" : "omgea", "--to", "4"});
    CHECK(unknown.code == 2);
    CHECK_THAT(unknown.err, Contains("did you mean \"omega\""));
  }
  // Two settings that depend on each other are refused in either order; others hold both.
  for (const std::vector<std::string>& pair :
       {std::vector<std::string>{"eta=0.9", "omega=4.75"}, {"omega=4.75", "eta=0.9"}, {"r=2", "a=0.02"}, {"b=0.2", "m=3"}}) {
    const Outcome both = call({"orbit", file, "--set", pair[0], "--set", pair[1]});
    CHECK(both.code == 2);
    CHECK_THAT(both.err, Contains("depend on each other"));
  }
  CHECK(call({"orbit", file, "--set", "r=2.5", "--set", "omega=4.8", "--quiet"}).code == 0);
  const Outcome range = call({"continue", file, "--param", "omega", "--to", "0"});
  CHECK(range.code == 2);
  CHECK_THAT(range.err, Contains("omega is 0") && Contains("> 0"));
}
