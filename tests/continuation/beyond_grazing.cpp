// SPDX-License-Identifier: GPL-3.0-or-later
// Families beyond a hard grazing, against closed forms. The cases are:
// - stable stretches of orbits with one impact in n periods that are inadmissible between two grazings, bridged by orbits with
//   one impact more;
// - windows narrower than 1e-7;
// - several contacts that touch together;
// - contacts without a family beyond.
#include <graze/continuation/graph/branch_graph.hpp>
#include <graze/lib/models/oscillator.hpp>

#include "support/branches.hpp"
#include "support/checks.hpp"
#include "support/newton_oscillator.hpp"
#include "support/two_sided_orbit.hpp"
#include "support/two_sided_oscillator.hpp"

#include <catch2/catch.hpp>

#include <cmath>

using namespace graze;
using namespace graze::support;

namespace {

/// A stretch of 1/n orbits that is inadmissible from `from` to about `to` of one parameter.
struct Stretch {
  const char* parameter;
  double OneImpactParameters::*value;
  double b, k_r, eta;
  int n;
  double r, speed, from, to;
};

constexpr auto in_eta = &OneImpactParameters::eta, in_k_r = &OneImpactParameters::k_r, in_b = &OneImpactParameters::b;

/// Found by a scan of the closed form over random b, k_r, eta, r and n with xi = 1. In r and in xi no such stretch was found
/// in 330000 stable intervals at 40 values each.
const std::vector<Stretch> stretches{
    {"eta", in_eta, 0.013728, 0.566610, 0, 1, 1.1297747, 0.35800, 0.2697692, 0.2582231},
    {"eta", in_eta, 0.050661, 0.790329, 0, 1, 1.0005428, 0.11375, 0.2195747, 0.2058732},
    {"eta", in_eta, 0.086834, 0.651771, 0, 1, 1.1111395, 1.03953, 0.5789778, 0.6124428},
    {"eta", in_eta, 0.052456, 0.743614, 0, 2, 2.4203578, 1.96360, 0.7579538, 0.7412030},
    {"eta", in_eta, 0.030665, 0.470513, 0, 3, 3.3347143, 2.28382, 0.8299420, 0.8241324},
    {"eta", in_eta, 0.185018, 0.541444, 0, 3, 0.1800793, 0.22022, 3.4586807, 3.4805857},
    {"eta", in_eta, 0.039656, 0.801277, 0, 4, 0.3795890, 0.13791, 4.3409036, 4.2851230},
    // The impact between the two grazings is slower than 1e-5 throughout: a free run does not reproduce it.
    {"eta", in_eta, 0.092843, 1.000000, 0, 4, 0.2654794, 0.16096, 4.5427453, 4.5479695},
    {"eta", in_eta, 0.008400, 0.824691, 0, 6, 0.5185232, 0.06092, 6.1925497, 6.1894534},
    {"b", in_b, 0, 0.174085, 5.8157924, 3, -0.0152326, 0.26102, 0.042859, 0.0272156},
    {"b", in_b, 0, 0.821074, 3.5485713, 2, -0.0400852, 0.25808, 0.113738, 0.0963361},
};

/// The 1/n orbit of the stretch at a value of its parameter: the orbit with the nearest impact speed.
OneImpactOrbit orbit_at(const Stretch& s, double value, double speed) {
  OneImpactParameters q{.b = s.b, .xi = 1.0, .eta = s.eta, .r = s.r, .k_r = s.k_r};
  q.*s.value = value;
  OneImpactOrbit best;
  for (const OneImpactOrbit& orbit : one_impact_orbits(q, s.n))
    if (best.speed == 0.0 || std::abs(orbit.speed - speed) < std::abs(best.speed - speed)) best = orbit;
  return best;
}

/// The value at which the highest maximum of its flight reaches the barrier (secant method).
double grazing_near(const Stretch& s, double guess, double& speed) {
  const double width = s.to - s.from;
  double a = guess - 0.01 * width, b = guess + 0.01 * width;
  double f_a = orbit_at(s, a, speed).highest, f_b = orbit_at(s, b, speed).highest;
  for (int i = 0; i < 12 && f_b != f_a && b != a; ++i) {
    const double c = b - f_b * (b - a) / (f_b - f_a);
    const OneImpactOrbit orbit = orbit_at(s, c, speed);
    a = b;
    f_a = f_b;
    b = c;
    f_b = orbit.highest;
    speed = orbit.speed;
  }
  return b;
}

}  // namespace

TEST_CASE("a stable stretch that is inadmissible between two grazings is bridged by orbits with one impact more") {
  for (const Stretch& s : stretches) {
    double speed = s.speed;
    const double first = grazing_near(s, s.from, speed);
    // The closed form leads to the other grazing.
    bool stable = true;
    OneImpactOrbit inside;
    for (int i = 1; i <= 20; ++i) {
      const OneImpactOrbit orbit = orbit_at(s, s.from + i / 20.0 * (s.to - s.from), speed);
      speed = orbit.speed;
      stable = stable && orbit.stable();
      if (i == 10) inside = orbit;
    }
    const double second = grazing_near(s, s.to, speed), width = second - first;
    INFO(s.parameter << " n " << s.n << " r " << s.r << ": grazings at " << first << " and " << second);
    const OneImpactOrbit start = orbit_at(s, first - 0.15 * width, s.speed), end = orbit_at(s, second + 0.1 * width, speed);
    REQUIRE(start.admissible());
    REQUIRE(end.admissible());
    REQUIRE_FALSE(inside.admissible());
    REQUIRE((stable && start.stable() && end.stable()));

    const PeriodicOrbit orbit = shoot(newton_oscillator(), parameters_of(start.parameters), start.states().front(), s.n);
    REQUIRE(orbit.converged());
    REQUIRE(orbit.impacts == 1);
    ContinuationOptions options;
    options.parameter = s.parameter;
    options.to = second + 0.1 * width;
    options.switch_generations = 0;
    const std::vector<Branch> branches = continue_orbit(newton_oscillator(), orbit, options);
    REQUIRE(branches.size() == 3);
    // The maxima of the closed form are exact to 1e-15 and change with the parameter at a rate of at least 0.01.
    const double exact[] = {first, second};
    for (const int k : {0, 1}) {
      const Branch& branch = branches[static_cast<std::size_t>(k)];
      REQUIRE(branch.stop == BranchStop::grazing);
      const auto grazings = points_of(branch, PointType::GR);
      REQUIRE(grazings.size() == 1);
      CHECK(std::abs(grazings[0].value - exact[k]) < 1e-12);
      CHECK(text_detail(grazings[0], "kind") == (k == 0 ? "gained" : "lost"));
      CHECK(text_detail(grazings[0], "scenario") == "persistence");
      CHECK(text_detail(grazings[0], "scenario_from") == "directions, multipliers and linear response");
      const Branch& next = branches[static_cast<std::size_t>(k + 1)];
      REQUIRE(next.parent);
      CHECK(next.parent->label == grazings[0].label);
      CHECK(next.period == s.n);
    }
    // The bridge covers the whole interval between the grazings.
    for (const BranchPoint& point : branches[1].points) {
      CHECK(point.impacts == 2);
      CHECK(point.admissible == Admissibility::admissible);
      CHECK((point.value - first) * (point.value - second) <= 0.0);
    }
    // Then the branch is on the 1/n orbits of the closed form again.
    CHECK(branches[2].stop == BranchStop::reached_bound);
    const BranchPoint& last = branches[2].points.back();
    CHECK(last.impacts == 1);
    CHECK(last.stable);
    double nearest = 1.0;
    for (const Vector& state : end.states()) nearest = std::min(nearest, (state - last.state()).norm());
    CHECK(nearest < 1e-9);
    for (const Branch& branch : branches) CHECK(check_branch(newton_oscillator(), branch) == std::vector<std::string>{});
  }
}

TEST_CASE("a stable stretch may also end in a nonsmooth fold: the orbits with one impact more lie on its own side") {
  const std::vector<Stretch> folding{
      {"k_r", in_k_r, 0.009875, 0, 0.4117492, 1, 0.9739540, 0.78968, 0.680341, 0.9993410},
      {"k_r", in_k_r, 0.009507, 0, 0.8665800, 3, 3.4216492, 3.97106, 0.621938, 0.9689376},
      {"eta", in_eta, 0.117119, 1.000000, 0, 2, 1.1944104, 0.08953, 0.4216967, 0.4284439},
      {"eta", in_eta, 0.130886, 0.771881, 0, 2, 1.9659000, 1.43609, 0.8129258, 0.7882129},
  };
  for (const Stretch& s : folding) {
    double speed = s.speed;
    const double grazing = grazing_near(s, s.from, speed), away = s.from < s.to ? -1.0 : 1.0;
    const OneImpactOrbit start = orbit_at(s, grazing + 0.1 * std::abs(s.to - s.from) * away, speed);
    INFO(s.parameter << " n " << s.n << " grazing at " << grazing);
    REQUIRE(start.admissible());
    REQUIRE(start.stable());
    const PeriodicOrbit orbit = shoot(newton_oscillator(), parameters_of(start.parameters), start.states().front(), s.n);
    ContinuationOptions options;
    options.parameter = s.parameter;
    options.to = grazing - 0.1 * std::abs(s.to - s.from) * away;
    options.switch_generations = 0;
    const std::vector<Branch> branches = continue_orbit(newton_oscillator(), orbit, options);
    const auto grazings = points_of(branches[0], PointType::GR);
    REQUIRE(grazings.size() == 1);
    CHECK(std::abs(grazings[0].value - grazing) < 1e-12);
    CHECK(text_detail(grazings[0], "scenario") == "nonsmooth-fold");
    CHECK(text_detail(grazings[0], "scenario_from") == "directions, multipliers and linear response");
    REQUIRE(branches.size() >= 2);
    const BranchPoint& beyond = branches[1].points.front();
    CHECK(branches[1].parent->label == grazings[0].label);
    CHECK(beyond.impacts == 2);
    CHECK((beyond.value - grazing) * away > 0.0);
    CHECK_FALSE(beyond.stable);
    for (const Branch& branch : branches) CHECK(check_branch(newton_oscillator(), branch) == std::vector<std::string>{});
  }
}

TEST_CASE("a branch of hard impacts starts in the requested direction") {
  // The states of this orbit change fast with eta. Their differences at a fixed state once gave the wrong direction.
  const Stretch& s = stretches.front();
  const OneImpactOrbit start = orbit_at(s, 0.2715, s.speed);
  REQUIRE(start.admissible());
  const PeriodicOrbit orbit = shoot(newton_oscillator(), parameters_of(start.parameters), start.states().front(), 1);
  for (const double to : {0.2705, 0.2725}) {
    ContinuationOptions options;
    options.to = to;
    const std::vector<Branch> branches = continue_orbit(newton_oscillator(), orbit, options);
    CHECK(branches[0].stop == BranchStop::reached_bound);
    CHECK(branches[0].points.back().value == to);
  }
}

TEST_CASE("stable windows down to 2e-10 wide between a fold and a grazing: both ends agree with the closed form") {
  // b = 0.14, k_r = 0.7, n = 3: at eta = 3.35849937 the fold in r coincides with the grazing of a second maximum. Nearby, the
  // width of the window between them is the square of the distance.
  for (const double eta : {3.358799, 3.3586, 3.35853, 3.35851}) {
    OneImpactParameters q{.b = 0.14, .xi = 1.0, .eta = eta, .r = 0.0, .k_r = 0.7};
    const OneImpactFamily family = one_impact_family(q, 3);
    // As a function of the speed v, r = alpha v + sqrt(A^2 - slope^2 v^2) is largest at the fold.
    const double A = impactless_amplitude(q), slope = std::abs(family.slope), steep = std::hypot(family.alpha, slope);
    const double fold_speed = A * family.alpha / (slope * steep), fold = A * steep / slope;
    const auto orbit_of = [&](double v) {
      OneImpactParameters at = q;
      at.r = family.alpha * v + std::sqrt((A - slope * v) * (A + slope * v));
      return one_impact_orbit(at, 3, v);
    };
    double low = fold_speed, high = 1.002 * fold_speed;
    REQUIRE(orbit_of(low).highest < 0.0);
    REQUIRE(orbit_of(high).highest > 0.0);
    for (int i = 0; i < 50; ++i) {
      const double middle = 0.5 * (low + high);
      (orbit_of(middle).highest < 0.0 ? low : high) = middle;
    }
    const double grazing = orbit_of(low).parameters.r, width = fold - grazing;
    INFO("eta " << eta << ": fold at " << fold << ", window " << width << " wide");
    REQUIRE(width > 0.0);
    REQUIRE(width < 2e-7);
    REQUIRE(orbit_of(0.5 * (fold_speed + low)).stable());
    // From the unstable orbits on the other side of the fold.
    const OneImpactOrbit start = orbit_of(0.95 * fold_speed);
    REQUIRE(start.admissible());
    REQUIRE_FALSE(start.stable());
    const PeriodicOrbit orbit = shoot(newton_oscillator(), parameters_of(start.parameters), start.states().front(), 3);
    REQUIRE(orbit.converged());
    ContinuationOptions options;
    options.parameter = "r";
    options.to = fold + 1e-3;
    options.from = fold - 1e-3;
    options.switch_generations = 0;
    const std::vector<Branch> branches = continue_orbit(newton_oscillator(), orbit, options);
    CHECK(types_of(branches[0]) == "LP GR");
    const auto folds = points_of(branches[0], PointType::LP), grazings = points_of(branches[0], PointType::GR);
    REQUIRE(folds.size() == 1);
    REQUIRE(grazings.size() == 1);
    CHECK(folds[0].status == PointStatus::converged);
    // Both to a hundredth of the narrowest window.
    CHECK(std::abs(folds[0].value - fold) < 2e-12);
    CHECK(std::abs(grazings[0].value - grazing) < 2e-12);
    CHECK(branches[0].points.back().stable);
    CHECK(branches[0].stop == BranchStop::grazing);
    REQUIRE(branches.size() >= 2);
    CHECK(branches[1].parent->label == grazings[0].label);
    CHECK(check_branch(newton_oscillator(), branches[0]) == std::vector<std::string>{});
  }
}

TEST_CASE("an orbit that grazes two barriers at once continues with one impact or with both as in the closed form") {
  // x'' + 2 b x' + x = xi cos(eta t) between -r and r, relative to the impactless orbit. A kick D = (1 + k_r) v at the upper
  // touch moves the orbit by y = (Phi(T) - I)^{-1} (0, D) there and by Phi(T/2) y at the lower one. Let s, c = sin, cos(w T /
  // 2). The orbit with one impact misses the other barrier if s (1 + c) < 0, which is eta in (1/2, 1) for small b. It exists
  // beyond the grazing if sin(w T) > 0. The orbit with both impacts always exists, for s > 0 (eta > 1) on the near side.
  const HybridSystem system = two_sided_oscillator(true);
  const double b = 0.05;
  const auto index_of_restitution = static_cast<Eigen::Index>(parameter_index(system.parameters, "k_r"));
  int seen[3] = {0, 0, 0};
  for (const double eta : {0.55, 0.65, 0.8, 0.95, 1.15, 1.3, 1.7, 2.5}) {
    const double stiff = 1.0 - eta * eta, drag = 2.0 * b * eta, grazing = std::hypot(stiff, drag), w = std::sqrt(1.0 - b * b);
    const double T = 2.0 * std::numbers::pi / eta, turn = w * T, xi = 0.97 * grazing;
    Vector p = parameters(system, {{"b", b}, {"xi", xi}, {"eta", eta}, {"r", 1.0}});
    const PeriodicOrbit orbit = shoot(system, p, xi / (grazing * grazing) * Vector{{stiff, drag * eta}}, 1);
    REQUIRE(orbit.impacts == 0);
    ContinuationOptions options;
    options.parameter = "xi";
    options.to = 1.05 * grazing;
    options.from = 0.9 * grazing;
    options.switch_generations = 0;
    const BranchGraph graph = follow_branches(system, {{orbit, {1}}}, options);
    INFO("eta " << eta);
    REQUIRE(graph.branches.size() >= 2);
    CHECK(graph.cut_off.empty());
    const auto grazings = points_of(graph.branches[0], PointType::GR);
    REQUIRE(grazings.size() == 1);
    CHECK(std::abs(grazings[0].value - grazing) < 1e-12);
    const bool alone = std::sin(0.5 * turn) < 0.0, persistence = alone && std::sin(turn) > 0.0;
    CHECK(graph.branches[1].points.front().impacts == (alone ? 1 : 2));
    CHECK(std::get<std::vector<double>>(grazings[0].details.at("impacts")) == std::vector<double>{0.0, alone ? 1.0 : 2.0});
    CHECK(text_detail(grazings[0], "scenario") == (persistence ? "persistence" : "nonsmooth-fold"));
    CHECK(text_detail(grazings[0], "scenario_from") ==
          (alone ? "directions, multipliers and linear response" : "directions; several contacts touch together"));
    CHECK((graph.branches[1].points.front().value > grazing) == persistence);
    // The family with both impacts begins there too if one impact alone is possible.
    const std::vector<const Branch*> born = born_at(grazings[0], graph.branches);
    CHECK(born.size() == (alone ? 2 : 1));
    const auto both = std::find_if(born.begin(), born.end(), [](const Branch* one) { return one->points.front().impacts == 2; });
    REQUIRE(both != born.end());
    CHECK(((*both)->points.front().value < grazing) == (std::sin(0.5 * turn) > 0.0));
    const BranchPoint& point = (*both)->points[(*both)->points.size() / 2];
    REQUIRE(point.impacts == 2);
    double off = 1.0;
    for (const int side : {1, -1})
      if (const auto exact = two_sided_orbit(b, point.value, eta, 1.0, p[index_of_restitution], side))
        off = std::min(off, static_cast<double>(std::hypot(point.states[0][0] - exact->x, point.states[0][1] - exact->x_dot)));
    CHECK(off < 1e-9);
    for (const Branch& branch : graph.branches) CHECK(check_branch(system, branch) == std::vector<std::string>{});
    ++seen[alone ? (persistence ? 1 : 0) : 2];
  }
  CHECK(seen[0] >= 1);
  CHECK(seen[1] >= 2);
  CHECK(seen[2] >= 3);
}

TEST_CASE("if no family begins beyond a grazing the scenario is none and the cut-off list gives the reason") {
  // A latch: a mass that reaches x = r is caught by a stiffer spring forever. No orbit remains near the grazing one.
  HybridSystem system = make_oscillator("linear", "newton");
  system.modes.push_back(system.modes.front());
  system.modes.back().name = "caught";
  system.modes.back().structure = {};
  for (Event& event : system.events)
    if (event.kind == EventKind::impact) {
      event.to = system.modes.size() - 1;
      event.reset = {};
    }
  const double b = 0.05, eta = 0.8, stiff = 1.0 - eta * eta, drag = 2.0 * b * eta, grazing = std::hypot(stiff, drag);
  const double xi = 0.97 * grazing;
  const Vector p = parameters(system, {{"b", b}, {"xi", xi}, {"eta", eta}, {"r", 1.0}});
  const PeriodicOrbit orbit = shoot(system, p, xi / (grazing * grazing) * Vector{{stiff, drag * eta}}, 1);
  REQUIRE(orbit.converged());
  ContinuationOptions options;
  options.parameter = "xi";
  options.to = 1.05 * grazing;
  options.from = 0.9 * grazing;
  const BranchGraph graph = follow_branches(system, {{orbit, {1}}}, options);
  REQUIRE(graph.branches.size() == 1);
  CHECK(graph.branches[0].stop == BranchStop::grazing);
  const auto grazings = points_of(graph.branches[0], PointType::GR);
  REQUIRE(grazings.size() == 1);
  CHECK(std::abs(grazings[0].value - grazing) < 1e-12);
  CHECK(text_detail(grazings[0], "scenario") == "none");
  CHECK(graph.branches[0].message.find("(none)") != std::string::npos);
  REQUIRE(graph.cut_off.size() == 1);
  CHECK(graph.cut_off[0].branch == 1);
  CHECK(graph.cut_off[0].label == grazings[0].label);
  CHECK(graph.cut_off[0].reason == "no orbit was found beyond the grazing");
}
