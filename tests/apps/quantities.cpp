// SPDX-License-Identifier: GPL-3.0-or-later
// --y: quantities of orbits, branches and attractors against closed forms, in every output.
#include "graze_program.hpp"

#include <graze/apps/map/map_file.hpp>
#include <graze/apps/pictures/maps.hpp>
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/pictures/shown_quantity.hpp>
#include <graze/apps/text/table.hpp>

#include <catch2/catch.hpp>
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <set>

using namespace graze;
using namespace graze::apps;
using namespace graze::support;
using Catch::Matchers::Contains;
using std::numbers::pi;

namespace {

/// A linear oscillator without stop, in millimetres; the work of its force.
constexpr const char* shaken = R"toml([system]
states  = ["x", "v"]
forcing = "omega"
[parameters]
omega = { value = 0.6, above = 0, unit = "rad/s" }
F     = 1.5
c     = 0.1
[definitions]
force = "F*cos(omega*t)"
[modes.free]
equations = """
  x' = v
  v' = force - c*v - x
"""
[outputs]
power = "force*v"
[units]
x     = "mm"
power = "W"
t     = "s"
[start]
state = [0, 0]
)toml";

double amplitude(double omega) { return 1.5 / std::hypot(1.0 - omega * omega, 0.1 * omega); }

Json result(std::vector<std::string> arguments) {
  arguments.insert(arguments.end(), {"--quiet", "--json", "-"});
  return json_of(call(arguments));
}

std::size_t column(const Table& table, const std::string& name) {
  const auto found = std::find(table.columns.begin(), table.columns.end(), name);
  REQUIRE(found != table.columns.end());
  return static_cast<std::size_t>(found - table.columns.begin());
}

}  // namespace

TEST_CASE("the mean of a function with jumps agrees with the closed form for any selection of quantities (fixed)") {
  // x is above half its amplitude for a third of the time.
  const TemporaryFolder folder;
  const std::string file = folder.write("shaken.toml", shaken);
  const std::string jump = fmt::format("mean(step(x - {:.17g}))", 0.5 * amplitude(0.6));
  const auto mean = [&](std::vector<std::string> others) {
    std::vector<std::string> all = {"orbit", file, "--y", jump};
    for (const std::string& other : others) all.insert(all.end(), {"--y", other});
    return result(all)["orbit"]["y"][jump].get<double>();
  };
  const double alone = mean({});
  CHECK(std::abs(alone - 1.0 / 3.0) < 1e-11);
  CHECK(std::abs(mean({"mean(max(x, v))", "max(x^3)"}) - alone) < 1e-13);
  CHECK(std::abs(mean({"mean(sign(v))"}) - alone) < 1e-13);
}

TEST_CASE("quantities of a linear oscillator along its resonance curve agree with the closed form") {
  const TemporaryFolder folder;
  const std::string file = folder.write("shaken.toml", shaken);
  const Json json = result({"continue", file,
                            "--to",     "1.6",
                            "--y",      "max(x)",
                            "--y",      "amplitude(v)",
                            "--y",      "mean(power)",
                            "--y",      " x ",
                            "--y",      "max(v')",
                            "--y",      "impact_speed_max",
                            "--y",      "impacts",
                            "--y",      "period",
                            "--csv",    folder.file("b.csv")});
  CHECK(json["options"]["y"].size() == 8);
  const Json& points = json["branches"][0]["points"];
  REQUIRE(points.size() > 10);
  const Table table = parse_csv(read_file(folder.file("b.csv")), "b.csv");
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double omega = points[i]["value"], R = amplitude(omega);
    const Json& y = points[i]["y"];
    CHECK(std::abs(y["max(x)"].get<double>() - R) < 1e-11 * R);
    CHECK(std::abs(y["amplitude(v)"].get<double>() - R * omega) < 1e-11 * R);
    CHECK(std::abs(y["mean(power)"].get<double>() - 0.05 * R * R * omega * omega) < 1e-11 * R * R);
    CHECK(std::abs(y["max(v')"].get<double>() - R * omega * omega) < 1e-11 * R);
    CHECK(y["x"] == points[i]["state"][0]);
    CHECK(y["period"].get<double>() == Approx(2.0 * pi / omega).epsilon(1e-15));
    CHECK(y["impacts"] == 0.0);
    CHECK(y["impact_speed_max"].is_null());
  }
  for (const Json& point : json["branches"][0]["special_points"]) CHECK(point["y"].contains("max(x)"));
  CHECK(std::stod(table.rows[0][column(table, "max(x)")]) == points[0]["y"]["max(x)"].get<double>());
  CHECK(table.rows[0][column(table, "impact_speed_max")].empty());

  const Picture picture = picture_of(json, "branch");
  CHECK(picture.x_label == "omega / rad/s");
  CHECK(picture.y_label == "max(x) / mm");
  REQUIRE(picture.below.size() == 7);
  CHECK(picture.below[0].y_label == "amplitude(v)");
  CHECK(picture.below[1].y_label == "mean(power) / W");
  CHECK(picture.below[6].y_label == "period / s");
  CHECK(picture.curves[0].points[0][1] == points[0]["y"]["max(x)"].get<double>());
  const Picture chosen = picture_of(with_quantities(json, {"x", "max(x)"}), "branch");
  CHECK(chosen.y_label == "x at forcing phase 0 / mm");
  REQUIRE(chosen.below.size() == 1);
  CHECK(chosen.below[0].y_label == "max(x) / mm");
  CHECK_THROWS_WITH(with_quantities(json, {"max(y)"}), Contains("--y max(y)") && Contains("max(x)"));
  CHECK_THROWS_WITH(with_quantities(Json::object(), {"max(x)"}), Contains("no quantities"));
}

TEST_CASE("a quantity does not depend on the others: beside poles and at the zeros of a power (fixed)") {
  const TemporaryFolder folder;
  folder.write("own.toml", shaken);
  const double A = amplitude(0.6);
  const auto measured = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"orbit", folder.file("own.toml")};
    for (const std::string& one : more) arguments.insert(arguments.end(), {"--y", one});
    return result(arguments)["orbit"]["y"];
  };
  for (const char* other : {"log(x)", "1/(x - 0.3)", "tan(3*x)", "mean(tan(3*x))", "max(1/x)"}) {
    INFO(other);
    const Json y = measured({"mean(abs(x))", other, "mean(x^2)"});
    CHECK(y["mean(abs(x))"].get<double>() == Approx(2.0 * A / pi).epsilon(1e-11));
    CHECK(y["mean(x^2)"].get<double>() == Approx(0.5 * A * A).epsilon(1e-11));
  }
  // Mean of |sin|^(3/2); a pole has no mean, and no maximum.
  const double power = std::tgamma(1.25) / (std::sqrt(pi) * std::tgamma(1.75));
  const Json y = measured({"mean(abs(v)^1.5)", "max(abs(v)^1.5)", "mean(sqrt(x^2))", "mean(1/x)", "max(1/x)", "mean(log(x))"});
  CHECK(y["mean(abs(v)^1.5)"].get<double>() == Approx(std::pow(0.6 * A, 1.5) * power).epsilon(1e-10));
  CHECK(y["max(abs(v)^1.5)"].get<double>() == Approx(std::pow(0.6 * A, 1.5)).epsilon(1e-10));
  CHECK(y["mean(sqrt(x^2))"].get<double>() == Approx(2.0 * A / pi).epsilon(1e-10));
  for (const char* none : {"mean(1/x)", "max(1/x)", "mean(log(x))"}) CHECK(y[none].is_null());
  // Unknown values are null in a motion too.
  const Json motion = result({"trajectory", folder.file("own.toml"), "--periods", "1", "--settle", "0", "--y", "log(x)"});
  CHECK(motion["samples"].size() > 10);
  result({"poincare", folder.file("own.toml"), "--points", "3", "--settle", "5", "--y", "log(-1 - x^2)"});
}

TEST_CASE("friction that stops a mass is no contact and an orbit with a swinging mass is not at rest (fixed)") {
  const TemporaryFolder folder;
  // Two uncoupled masses: one in front of a stop, the other held and released by friction.
  folder.write("two.toml", R"toml([system]
forcing = "w"
[parameters]
w = 0.9
F = 1
[mechanics]
coordinates = ["x", "y"]
velocities = ["v", "u"]
mass = [[1, 0], [0, 1]]
damping = [[0.1, 0], [0, 0.1]]
stiffness = [[1, 0], [0, 5]]
force = ["F*cos(w*t)", "0.42*cos(w*t)"]
[[stops]]
name = "stop"
gap = "0.4 - x"
law = {newton = 0.7}
[[friction]]
name = "foot"
speed = "u"
normal = "1"
law = "0.4"
)toml");
  const Json orbit = result({"orbit", folder.file("two.toml"), "--y", "energy_lost"})["orbit"];
  REQUIRE(orbit["contacts"].size() == 1);
  const double speed = orbit["contacts"][0]["entry_speed"];
  CHECK(orbit["y"]["energy_lost"].get<double>() == Approx(0.5 * (1.0 - 0.49) * speed * speed).epsilon(1e-12));
  // The second mass is pressed against its stop; the first one swings.
  folder.write("held.toml", R"toml([system]
forcing = "w"
[parameters]
w = 0.9
F = 0.5
z = 0.05
k = 0.5
P = 2
[mechanics]
coordinates = ["x1", "x2"]
velocities = ["v1", "v2"]
mass = [[1, 0], [0, 2]]
damping = [["2*z", 0], [0, "2*z"]]
stiffness = [["1 + k", "-k"], ["-k", "k"]]
force = ["F*cos(w*t)", "P"]
[[stops]]
name = "one"
gap = "0.1 - x2"
law = {newton = 0.6}
[start]
state = {x2 = 0.1}
)toml");
  const Json held = result({"orbit", folder.file("held.toml")})["orbit"];
  CHECK_FALSE(held.contains("rests"));
  CHECK(held["multipliers"][2] == Json({0.0, 0.0}));
  CHECK_FALSE(result({"lyapunov", folder.file("held.toml"), "--periods", "200"})["attractor"].contains("rests"));
}

TEST_CASE("quantities of a ball on a table are those of its parabola") {
  // Between two impacts the height is a parabola of duration T: mean h + g T^2 / 12, maximum h + g T^2 / 8.
  const std::string file = GRAZE_DATA_DIR "/models/ball-on-table.toml";
  const Json json = result({"orbit", file, "--y", "mean(height)", "--y", "max(height)", "--y", "energy_lost", "--y",
                            "impacts_per_period", "--y", "impact_speed_min", "--y", "mean(u)", "--y", "min(y)"});
  const Json &orbit = json["orbit"], &y = orbit["y"];
  const double tau = orbit["events"][0]["tau"], speed = orbit["events"][0]["speed"], T = 2.0 * pi, h = 0.4 * std::sin(tau);
  CHECK(std::abs(y["mean(height)"].get<double>() - (h + T * T / 12.0)) < 1e-11);
  CHECK(std::abs(y["max(height)"].get<double>() - (h + T * T / 8.0)) < 1e-12);
  CHECK(std::abs(y["energy_lost"].get<double>() - 0.5 * (1.0 - 0.64) * speed * speed) < 1e-12);
  CHECK(y["impacts_per_period"] == 1.0);
  CHECK(y["impact_speed_min"] == speed);
  CHECK(std::abs(y["mean(u)"].get<double>()) < 1e-12);
  CHECK(std::abs(y["min(y)"].get<double>()) < 1e-12);
}

TEST_CASE("quantities of autonomous orbits: a block on a belt loses no energy in contacts and its mean speed is zero") {
  const std::string file = GRAZE_DATA_DIR "/models/block-on-belt.toml";
  const Json json = result({"orbit", file, "--y", "energy_lost", "--y", "impacts", "--y", "mean(v)", "--y", "max(v)", "--y",
                            "mean(v*x')", "--y", "mean(v^2)", "--y", "period"});
  const Json& y = json["orbit"]["y"];
  CHECK(y["energy_lost"] == 0.0);
  CHECK(y["impacts"] == 0.0);
  CHECK(y["period"] == json["orbit"]["duration"]);
  CHECK(std::abs(y["mean(v)"].get<double>()) < 1e-12);
  CHECK(y["mean(v*x')"].get<double>() == Approx(y["mean(v^2)"].get<double>()).epsilon(1e-14));
  CHECK(y["max(v)"].get<double>() > 0.0);
  CHECK_THAT(call({"orbit", GRAZE_DATA_DIR "/models/block-on-belt.toml", "--y", "max(t)"}).err, Contains("autonomous"));
}

TEST_CASE("quantities of an orbit balance: the work of the force is dissipated in damper and contact") {
  // The dissipation of a soft contact is that of its damper. energy_lost, from entry and exit speeds, includes the work of the
  // force too.
  const std::string soft = "mean(k_H*b_H*v^2*max(x - r, 0)^(3/2))";
  struct Case {
    std::string id, setting, contact;
  };
  for (const Case& one : {Case{"hertz-damped", "eta=0.93", soft}, Case{"newton-elastic", "k_r=0.7", "energy_lost"},
                          Case{"beam-hertz", "b_H=2", soft}}) {
    INFO(one.id);
    const Json json = result({"orbit", problem(one.id), "--set", one.setting, "--y", "mean(xi*cos(eta*t)*v)", "--y",
                              "mean(2*b*v^2)", "--y", one.contact, "--y", "period", "--y", "mean(v)"});
    const Json &orbit = json["orbit"], &y = orbit["y"];
    REQUIRE(orbit["impacts"].get<int>() > 0);
    const double T = y["period"].get<double>() / orbit["period"].get<double>();
    const double contact = y[one.contact].get<double>() / (one.contact == soft ? 1.0 : T);
    REQUIRE(contact > 1e-6);
    const double work = y["mean(xi*cos(eta*t)*v)"];
    CHECK(std::abs(work - (y["mean(2*b*v^2)"].get<double>() + contact)) < 1e-11 * (1.0 + work));
    CHECK(std::abs(y["mean(v)"].get<double>()) < 1e-11);
  }
}

TEST_CASE("quantities of a sweep are those of its attractors with its states at phase 0 one by one") {
  const TemporaryFolder folder;
  const Json json = result({"sweep", problem("hertz-damped"), "--from", "0.9", "--to", "0.93", "--step", "0.01", "--y", "x",
                            "--y", "max(x)", "--y", "impact_speed_max", "--csv", folder.file("s.csv")});
  const Table table = parse_csv(read_file(folder.file("s.csv")), "s.csv");
  std::size_t line = 0;
  bool doubled = false;
  for (const Json& row : json["rows"]) {
    const Json& y = row["y"];
    double fastest = 0.0;
    for (const Json& speed : row["impact_speeds"]) fastest = std::max(fastest, speed.get<double>());
    CHECK(y["impact_speed_max"].get<double>() == Approx(fastest).epsilon(1e-11));
    doubled = doubled || row["states"].size() == 2;
    for (std::size_t k = 0; k < row["states"].size(); ++k, ++line) {
      const Json& x = row["states"].size() == 1 ? y["x"] : y["x"][k];
      CHECK(x == row["states"][k][0]);
      CHECK(y["max(x)"].get<double>() > x.get<double>());
      CHECK(std::stod(table.rows[line][column(table, "max(x)")]) == y["max(x)"].get<double>());
    }
    const Json orbit = result({"orbit", problem("hertz-damped"), "--set", "eta=" + row["value"].dump(), "--period",
                               row["attractor"]["period"].dump(), "--y", "max(x)"})["orbit"];
    CHECK(y["max(x)"].get<double>() == Approx(orbit["y"]["max(x)"].get<double>()).epsilon(1e-11));
  }
  CHECK(doubled);
  CHECK(picture_of(json).y_label == "x at forcing phase 0 (dimensionless)");
}

TEST_CASE("quantities of a map are those of the attractors at its points in every format") {
  const TemporaryFolder folder;
  const std::string out = folder.file("run");
  const std::vector<std::string> command = {"map",     problem("hertz-damped"),
                                            "--param", "eta:0.72:0.92:3",
                                            "--param", "r:2:2.1:2",
                                            "--y",     "max(x)",
                                            "--y",     "v/eta",
                                            "--y",     "period"};
  std::vector<std::string> all = command;
  all.insert(all.end(), {"--out", out, "--csv", folder.file("m.csv")});
  const Json json = result(all), y = json["layers"][0]["y"];
  const Table table = parse_csv(read_file(folder.file("m.csv")), "m.csv");
  MapFile file(out + "/map.h5");
  std::size_t line = 0;
  std::set<std::string> types;
  for (const std::size_t row : {0, 1}) {
    const std::vector<MapPoint> points = file.row(static_cast<int>(row));
    for (std::size_t i = 0; i < 3; ++i, ++line) {
      INFO("row " << row << ", column " << i);
      const auto value = [&](const char* name) { return y[name][row][i].get<double>(); };
      CHECK(points[i].quantities[0] == value("max(x)"));
      CHECK(std::stod(table.rows[line][column(table, "v/eta")]) == value("v/eta"));
      CHECK(std::stod(table.rows[line][column(table, "period (--y)")]) == value("period"));
      const auto cell = [&](const char* name) { return table.rows[line][column(table, name)]; };
      const std::string eta = cell("eta"), r = cell("r"), period = table.rows[line][4];
      types.insert(cell("type"));
      CHECK(value("v/eta") == Approx(std::stod(cell("v")) / std::stod(eta)).epsilon(1e-13));
      if (cell("impacts") != "0") CHECK(value("max(x)") > std::stod(r));  // it moves into the elastic barrier
      if (cell("type") != "periodic") continue;
      CHECK(value("period") == Approx(std::stod(period) * 2.0 * pi / std::stod(eta)).epsilon(1e-13));
      const Json orbit = result({"orbit", problem("hertz-damped"), "--set", "eta=" + eta, "--set", "r=" + r, "--period", period,
                                 "--start", cell("x") + "," + cell("v"), "--settle", "0", "--y", "max(x)"})["orbit"];
      CHECK(value("max(x)") == Approx(orbit["y"]["max(x)"].get<double>()).epsilon(1e-10));
    }
  }
  CHECK(types == std::set<std::string>{"chaotic", "periodic"});

  // A resumed map must have the same quantities; pictures show them one by one.
  std::vector<std::string> other(command.begin(), command.end() - 2);
  other.insert(other.end(), {"--resume", out});
  CHECK_THAT(call(other).err, Contains("is of another run"));
  CHECK(std::filesystem::exists(out + "/map-y3.png"));
  CHECK(picture_of(json, "quantity").colour_label == "max(x) (dimensionless)");
  CHECK(picture_of_map(file.plan(), [&](int row) { return file.row(row); }, {.kind = "quantity", .quantity = "period"}).title ==
        "period");
  CHECK_THROWS_WITH(
      picture_of_map(file.plan(), [&](int row) { return file.row(row); }, {.kind = "quantity", .quantity = "perod"}),
      Contains("\"perod\" (did you mean \"period\"?)"));
}

TEST_CASE("quantities of coexisting attractors and of the one found by lyapunov are those of their orbits") {
  const Json json = result({"attractors", problem("newton-elastic"), "--set", "eta=0.744", "--x", "-1:2:12", "--v", "-2:2:12",
                            "--y", "max(v)", "--y", "impacts"});
  REQUIRE(json["attractors"].size() == 2);
  for (const Json& found : json["attractors"]) {
    const std::string state = found["state"][0].dump() + "," + found["state"][1].dump(), period = found["period"].dump();
    const Json orbit = result({"orbit", problem("newton-elastic"), "--set", "eta=0.744", "--settle", "0", "--start", state,
                               "--period", period, "--y", "max(v)"})["orbit"];
    CHECK(found["y"]["max(v)"].get<double>() == Approx(orbit["y"]["max(v)"].get<double>()).epsilon(1e-10));
    CHECK(found["y"]["impacts"] == found["impacts"].get<double>());
    const Json reached = result({"lyapunov", problem("newton-elastic"), "--set", "eta=0.744", "--settle", "0", "--start", state,
                                 "--periods", "100", "--y", "max(v)"});
    CHECK(reached["y"]["max(v)"].get<double>() == Approx(orbit["y"]["max(v)"].get<double>()).epsilon(1e-10));
  }
}

TEST_CASE("quantities of a resumed diagram are those of an uninterrupted one") {
  const TemporaryFolder folder;
  const std::vector<std::string> arguments = {"diagram", problem("newton-elastic"),
                                              "--from",  "0.93",
                                              "--to",    "0.95",
                                              "--step",  "0.005",
                                              "--quiet", "--y",
                                              "max(x)",  "--max-period",
                                              "2",       "--max-branches",
                                              "3",       "--periods",
                                              "2000",    "--out"};
  std::vector<std::string> first = arguments, second = arguments;
  first.push_back(folder.file("run"));
  REQUIRE(call(first).code == 0);
  const std::string whole = read_file(folder.file("run") + "/diagram.json");
  second.push_back(folder.file("run"));
  second.insert(second.end(), {"--resume", folder.file("run")});
  REQUIRE(call(second).code == 0);
  CHECK(read_file(folder.file("run") + "/diagram.json") == whole);
  const Json json = Json::parse(whole);
  for (const Json& row : json["rows"]) CHECK(row["y"].contains("max(x)"));
  for (const Json& branch : json["branches"])
    for (const Json& point : branch["points"]) CHECK(point["y"].contains("max(x)"));
}

TEST_CASE("expressions along a run and in a section are those of its states") {
  const std::vector<std::string> oscillator = {problem("newton-elastic"), "--start", "0.5,0.3", "--settle", "0"};
  const auto run = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin() + 1, oscillator.begin(), oscillator.end());
    return result(arguments);
  };
  const Json json =
      run({"trajectory", "--periods", "2", "--samples", "50", "--y", "v^2/2 + x^2/2", "--y", "cos(eta*t)", "--y", "x'"});
  CHECK(json["columns"] == Json({"tau", "x", "v", "v^2/2 + x^2/2", "cos(eta*t)", "x'"}));
  for (const Json& row : json["samples"]) {
    const double t = row[0], x = row[1], v = row[2];
    CHECK(row[3].get<double>() == Approx(v * v / 2.0 + x * x / 2.0).epsilon(1e-14));
    CHECK(std::abs(row[4].get<double>() - std::cos(json["parameters"]["eta"].get<double>() * t)) < 1e-14);
    CHECK(row[5] == row[2]);
  }
  const Picture picture = picture_of(json);
  CHECK(picture.y_label == "v^2/2 + x^2/2 (dimensionless)");
  CHECK(picture.below.size() == 2);
  CHECK(picture.curves[0].points[0][1] == json["samples"][0][3].get<double>());

  const Json section = run({"poincare", "--points", "20", "--y", "x*v"});
  for (const Json& point : section["points"]) CHECK(point[2].get<double>() == point[0].get<double>() * point[1].get<double>());
  CHECK(picture_of(section).y_label == "x*v at forcing phase 0 (dimensionless)");
  CHECK_THAT(call({"poincare", problem("newton-elastic"), "--section", "impact", "--y", "x"}).err,
             Contains("--section stroboscopic"));
  CHECK_THAT(call({"trajectory", problem("newton-elastic"), "--y", "max(x)"}).err, Contains("only expressions"));
}

TEST_CASE("quantities of a problem in physical units have physical units") {
  // alpha = 5 rad/s, x = X / 0.04 m.
  const TemporaryFolder folder;
  const std::string file = folder.write(
      "rig.toml",
      "[model]\noscillator = \"linear\"\ncontact = \"hertz\"\n[physical]\nexcitation = \"force\"\nm = 4\nk = 100\nc = 2\n"
      "F0 = 4\nomega = 4.75\nrho = 0.08\nk_h = 50000\nb_h = 0.5\n");
  const Json json =
      result({"continue", file,    "--to", "0.93",   "--y", "max(X)", "--y", "max(x)", "--y", "max(V)",  "--y", "max(v)",
              "--y",      "omega", "--y",  "period", "--y", "rho",    "--y", "m*c*F0", "--y", "max(X')", "--y", "max(x')"});
  for (const Json& point : json["branches"][0]["points"]) {
    const Json& y = point["y"];
    CHECK(y["max(X)"].get<double>() == Approx(0.04 * y["max(x)"].get<double>()).epsilon(1e-13));
    CHECK(y["max(V)"].get<double>() == Approx(0.2 * y["max(v)"].get<double>()).epsilon(1e-13));
    CHECK(y["max(X')"].get<double>() == Approx(y["max(V)"].get<double>()).epsilon(1e-13));
    CHECK(y["max(x')"].get<double>() == Approx(y["max(v)"].get<double>()).epsilon(1e-13));
    const double omega = y["omega"].get<double>();
    CHECK(omega == Approx(5.0 * point["value"].get<double>()).epsilon(1e-14));
    CHECK(y["period"].get<double>() == Approx(2.0 * pi / omega).epsilon(1e-14));
    CHECK(y["rho"].get<double>() == Approx(0.08).epsilon(1e-14));
    CHECK(y["m*c*F0"].get<double>() == Approx(32.0).epsilon(1e-14));
  }
  const Json orbit = result({"orbit", file, "--y", "energy_lost", "--y", "impact_speed_max"})["orbit"];
  const Json &contact = orbit["contacts"][0], &y = orbit["y"];
  CHECK(y["impact_speed_max"].get<double>() == Approx(0.2 * contact["entry_speed"].get<double>()).epsilon(1e-9));
  CHECK(y["energy_lost"].get<double>() == Approx(4.0 * 0.04 * contact["energy_lost"].get<double>()).epsilon(1e-8));
  const Picture picture = picture_of(json, "branch");
  CHECK(picture.y_label == "max(X) / m");
  CHECK(picture.below[0].y_label == "max(x) (dimensionless)");
  CHECK(picture.below[1].y_label == "max(V) / m/s");
  CHECK_THAT(call({"orbit", problem("hertz-damped"), "--y", "max(X)"}).err, Contains("unknown name 'X'"));
}

TEST_CASE("an unknown quantity is refused before the computation") {
  const TemporaryFolder folder;
  const std::string file = folder.write("shaken.toml", shaken);
  const auto refused = [&](const std::string& text, const std::string& why) {
    const Outcome outcome = call({"continue", file, "--to", "1.6", "--y", text});
    INFO(text);
    CHECK(outcome.code == 2);
    CHECK_THAT(outcome.err, Contains("--y " + text) && Contains(why) && Contains("amplitude(E)") && Contains("energy_lost"));
    CHECK(outcome.out.empty());
  };
  refused("max(y)", "unknown name 'y'");
  refused("maxim(x)", "unknown function 'maxim'");
  refused("max(x", "not closed");
  refused("max(x)-min(x)", "2 arguments");
  refused("", "nothing stands");
  refused("impact_speed", "unknown name 'impact_speed'");
  CHECK_THAT(call({"continue", file, "--to", "1.6", "--y", "x", "--y", "x"}).err, Contains("given twice"));
  CHECK_THAT(call({"orbit", file, "--y", "max(x)", "--json", "-"}).out, Contains("\"max(x)\""));
  CHECK(result({"orbit", file, "--y", "max(x, v)"})["orbit"]["y"]["max(x, v)"].is_number());
}

TEST_CASE("units in a file are those of states and outputs") {
  const TemporaryFolder folder;
  std::string text = shaken;
  text.replace(text.find("x     = \"mm\""), 5, "y    ");
  CHECK_THAT(call({"orbit", folder.write("a.toml", text)}).err, Contains("a unit of 'y'") && Contains("a.toml:"));
  text = shaken;
  text.replace(text.find("x     = \"mm\""), 5, "F    ");
  CHECK_THAT(call({"orbit", folder.write("b.toml", text)}).err, Contains("the unit of a parameter stands with it"));
}
