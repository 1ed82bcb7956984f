// SPDX-License-Identifier: GPL-3.0-or-later
// Families of several times the period that are born on a hard grazing. Linear algebra predicts each family and its side. The
// closed form of orbits with one impact gives their positions.
#include <graze/continuation/graph/branch_graph.hpp>
#include <graze/lib/models/oscillator.hpp>

#include "support/branches.hpp"
#include "support/checks.hpp"
#include "support/grazing_families.hpp"
#include "support/newton_oscillator.hpp"

#include <catch2/catch.hpp>

#include <cmath>
#include <map>

using namespace graze;
using namespace graze::support;

namespace {

constexpr int longest = 16;

/// Number of turns, and number of turns with an impact.
using Pattern = std::pair<int, int>;

/// The families that begin on a grazing, partner included, with their side: 1 beyond. `turn`: deviations from touch to touch.
std::map<Pattern, int> expected_families(const Eigen::Matrix2d& turn, double k_r, int n) {
  std::map<Pattern, int> list;
  for (int m = 1; m * n <= longest; ++m)
    for (const int struck : {1, m - 1})
      if (const int side = struck > 0 ? side_of_family(turn, k_r, m, struck) : 0) list[{m, struck}] = side;
  return list;
}

/// The families that were followed from the grazing at the end of branches[0] or end there: {turns, weak impacts}, side.
std::map<Pattern, int> found_families(const std::vector<Branch>& branches) {
  const Branch& base = branches.front();
  const SpecialPoint& grazing = base.special_points.back();
  std::map<Pattern, int> list;
  for (const Branch& branch : branches) {
    if (branch.id == base.id || branch.points.empty()) continue;
    const BranchPoint* nearest = nullptr;
    if (branch.stop == BranchStop::grazing && std::abs(branch.stop_value - grazing.value) < 1e-10)
      nearest = &branch.points.back();
    if (branch.parent && branch.parent->label == grazing.label) nearest = &branch.points.front();
    if (!nearest || branch.period % base.period != 0) continue;
    const int m = branch.period / base.period, struck = nearest->impacts - m * base.points.back().impacts;
    if (struck != 1 && struck != m - 1) continue;
    const bool near_side = (nearest->value > grazing.value) == (base.points.front().value > grazing.value);
    CHECK(list.insert({{m, struck}, near_side ? -1 : 1}).second);  // no family twice
  }
  return list;
}

ContinuationOptions options_for(const char* parameter, double from, double to) {
  ContinuationOptions options;
  options.parameter = parameter;
  options.from = from;
  options.to = to;
  options.max_period = longest;
  options.max_multiple = longest;
  options.max_branches = 300;
  return options;
}

double distance_to(const OneImpactOrbit& exact, const Vector& state) {
  double nearest = INFINITY;
  for (const Vector& other : exact.states()) nearest = std::min(nearest, (other - state).lpNorm<Eigen::Infinity>());
  return nearest;
}

}  // namespace

TEST_CASE("at the grazing of the impactless orbit every 1/m family to m = 16 is born on the side given by the closed form") {
  // The published r and xi at the impactless grazing, with an increasing ratio of forcing to free oscillation: the number of
  // 1/m orbits grows to all sixteen. With r about 1 / eta^2 the acceleration at the barrier stays of order one.
  const double published = std::sqrt((1.99 - std::sqrt(1.99 * 1.99 - 3.0)) / 2.0);
  struct Row {
    double eta, r, k_r;
  };
  int sides[2] = {0, 0};
  for (const Row& row : std::vector<Row>{{published, 2.0, 1.0},
                                         {published, 2.0, 0.8},
                                         {0.9, 1.0, 0.8},
                                         {1.7, 1.0, 1.0},
                                         {3.3, 0.1, 0.8},
                                         {5.0, 0.04, 0.4},
                                         {10.0, 0.01, 0.8},
                                         {20.0, 0.0025, 1.0}}) {
    OneImpactParameters q{.b = 0.05, .xi = 1.0, .eta = row.eta, .r = row.r, .k_r = row.k_r};
    const double grazing = one_impact_family(q, 1).xi_grazing();
    q.xi = 0.9995 * grazing;
    const Vector p = parameters_of(q);
    const PeriodicOrbit orbit = shoot(newton_oscillator(), p, steady_response(p), 1);
    REQUIRE(orbit.impacts == 0);
    const BranchGraph graph =
        follow_branches(newton_oscillator(), {{orbit, {1}}}, options_for("xi", 0.999 * grazing, 1.001 * grazing));
    INFO("eta " << row.eta << " k_r " << row.k_r);
    REQUIRE(graph.branches[0].stop == BranchStop::grazing);
    CHECK(std::abs(graph.branches[0].stop_value - grazing) < 1e-13 * (1.0 + grazing));
    CHECK(found_families(graph.branches) == expected_families(detail::flight_transition(q.b, q.period()), q.k_r, 1));
    for (const Branch& branch : graph.branches) {
      INFO("branch " << branch.id << " period " << branch.period);
      CHECK(check_branch(newton_oscillator(), branch) == std::vector<std::string>{});
      if (branch.points.front().impacts != 1 || !branch.parent || branch.parent->branch != 1) continue;
      // The side in closed form: the amplitude is proportional to r - alpha v.
      const OneImpactFamily family = one_impact_family(q, branch.period);
      ++sides[family.alpha < 0.0];
      CHECK((branch.points.front().value > grazing) == (family.alpha < 0.0));
      for (const BranchPoint& point : branch.points) {
        REQUIRE(point.impacts == 1);
        CHECK(point.admissible == Admissibility::admissible);
        CHECK(std::abs(family.xi(point.weakest_speed) - point.value) < 1e-12 * (1.0 + grazing));
        OneImpactParameters at = q;
        at.xi = family.xi(point.weakest_speed);
        CHECK(distance_to(one_impact_orbit(at, branch.period, point.weakest_speed), point.state()) < 1e-12);
      }
    }
  }
  CHECK(sides[0] > 10);
  CHECK(sides[1] > 10);
}

TEST_CASE("at grazings of orbits with an impact the families of multiple periods agree with linear algebra for n = 1 to 4") {
  // 1/n orbits whose free maximum touches the barrier, from a scan of the closed form over random b, k_r, eta and n with xi =
  // 1. Some rows have several families, and some have none.
  struct Row {
    int n;
    double b, k_r, eta, speed;
  };
  int families = 0, sides[2] = {0, 0};
  for (const Row& row : std::vector<Row>{{1, 0.063522, 0.933392, 0.6265429, 2.229439},
                                         {1, 0.112584, 0.744862, 0.5741759, 0.868567},
                                         {2, 0.158629, 0.747491, 2.1823764, 0.319355},
                                         {2, 0.086817, 0.645683, 2.0786179, 0.180993},
                                         {3, 0.029627, 0.311111, 1.7982661, 0.807544},
                                         {3, 0.137072, 0.978695, 3.3232706, 0.156512},
                                         {4, 0.110854, 0.390230, 4.4703420, 0.125559}}) {
    const OneImpactParameters q{.b = row.b, .xi = 1.0, .eta = row.eta, .r = 0.0, .k_r = row.k_r};
    const OneImpactFamily family = one_impact_family(q, row.n);
    const double A = impactless_amplitude(q), T = q.period();
    const auto orbit_of = [&](double v) {
      OneImpactParameters at = q;
      at.r = family.alpha * v + std::sqrt((A - family.slope * v) * (A + family.slope * v));
      return one_impact_orbit(at, row.n, v);
    };
    // The grazing, by bisection in the speed.
    double shut = 0.98 * row.speed, open = 1.02 * row.speed;
    if (orbit_of(shut).highest < 0.0) std::swap(shut, open);
    const OneImpactOrbit start = orbit_of(open);
    INFO("n " << row.n << " eta " << row.eta);
    REQUIRE(start.admissible());
    REQUIRE(orbit_of(shut).highest > 0.0);
    for (int i = 0; i < 60; ++i) (orbit_of(0.5 * (shut + open)).highest < 0.0 ? open : shut) = 0.5 * (shut + open);
    const OneImpactOrbit touching = orbit_of(open);
    const double grazing = touching.parameters.r, v = touching.speed;
    // The touch: the highest maximum of the flight.
    double touch = 0.0, height = -INFINITY;
    const int samples = 20000 * row.n;
    for (int i = 1; i < samples; ++i) {
      const double s = row.n * T * i / samples;
      const Vector x = touching.flight(s);
      if (s > 0.01 * T && s < (row.n - 0.01) * T && x[0] > height) {
        height = x[0];
        touch = s;
      }
    }
    REQUIRE(std::abs(height - grazing) < 1e-6);
    const double force = std::cos(q.eta * touching.time) - grazing;
    const double before = force - 2.0 * q.b * v, after = force + 2.0 * q.b * q.k_r * v;
    Eigen::Matrix2d jump;
    jump << -q.k_r, 0.0, (after + q.k_r * before) / v, -q.k_r;
    const Eigen::Matrix2d turn = detail::flight_transition(q.b, touch) * jump * detail::flight_transition(q.b, row.n * T - touch);

    const PeriodicOrbit orbit = shoot(newton_oscillator(), parameters_of(start.parameters), start.states().front(), row.n);
    REQUIRE(orbit.converged());
    REQUIRE(orbit.impacts == 1);
    const double way = grazing - start.parameters.r;
    const BranchGraph graph = follow_branches(newton_oscillator(), {{orbit, {way > 0.0 ? 1 : -1}}},
                                              options_for("r", start.parameters.r, grazing + 0.2 * way));
    REQUIRE(graph.branches[0].stop == BranchStop::grazing);
    CHECK(std::abs(graph.branches[0].stop_value - grazing) < 1e-12);
    const std::map<Pattern, int> expected = expected_families(turn, q.k_r, row.n);
    CHECK(found_families(graph.branches) == expected);
    for (const auto& [pattern, side] : expected) {
      ++sides[side > 0];
      families += pattern.first > 1 ? 1 : 0;
    }
    for (const Branch& branch : graph.branches) {
      INFO("branch " << branch.id << " period " << branch.period);
      CHECK(check_branch(newton_oscillator(), branch) == std::vector<std::string>{});
    }
  }
  CHECK(families > 50);
  CHECK(sides[0] > 10);
  CHECK(sides[1] > 10);
}

TEST_CASE("multiples are followed only on request and their limits are respected") {
  const Vector p = parameters(newton_oscillator(), {{"b", 0.05}, {"xi", 1.0}, {"eta", 10.0}, {"r", 1.0}, {"k_r", 0.8}});
  Vector start = p;
  const double grazing = one_impact_family({.b = 0.05, .xi = 1.0, .eta = 10.0, .r = 1.0, .k_r = 0.8}, 1).xi_grazing();
  start[static_cast<Eigen::Index>(parameter_index(newton_oscillator().parameters, "xi"))] = 0.9995 * grazing;
  const PeriodicOrbit orbit = shoot(newton_oscillator(), start, steady_response(start), 1);
  ContinuationOptions options = options_for("xi", 0.999 * grazing, 1.001 * grazing);
  const auto longest_task = [&] {
    int period = 0;
    for (const Branch& branch : follow_branches(newton_oscillator(), {{orbit, {1}}}, options).branches)
      period = std::max(period, branch.period);
    return period;
  };
  CHECK(ContinuationOptions{}.max_multiple == 1);
  options.max_multiple = 1;
  CHECK(longest_task() == 1);
  options.max_multiple = 3;
  CHECK(longest_task() == 3);
  options.max_multiple = longest;
  options.max_period = 5;
  CHECK(longest_task() == 5);
  options.switch_generations = 0;
  CHECK(longest_task() == 1);
  options.switch_generations = 1;
  options.max_branches = 2;
  const BranchGraph cut = follow_branches(newton_oscillator(), {{orbit, {1}}}, options);
  CHECK(cut.branches.size() == 2);
  std::vector<CutOff> by_limit;
  for (const CutOff& entry : cut.cut_off)
    if (entry.families == 0) by_limit.push_back(entry);
  REQUIRE(by_limit.size() == 1);
  CHECK(by_limit[0].label == cut.branches[0].special_points.back().label);
  CHECK(by_limit[0].reason == "families of several times its period: 2 branches are the limit");
  options.max_multiple = 0;
  CHECK_THROWS_WITH(follow_branches(newton_oscillator(), {{orbit, {1}}}, options), "max_multiple is 0; allowed is 1 and more");
}

TEST_CASE("an interrupted graph with multiples continues from its branches to the same end") {
  const double grazing = one_impact_family({.b = 0.05, .xi = 1.0, .eta = 10.0, .r = 1.0, .k_r = 0.8}, 1).xi_grazing();
  const Vector p =
      parameters(newton_oscillator(), {{"b", 0.05}, {"xi", 0.9995 * grazing}, {"eta", 10.0}, {"r", 1.0}, {"k_r", 0.8}});
  const PeriodicOrbit orbit = shoot(newton_oscillator(), p, steady_response(p), 1);
  ContinuationOptions options = options_for("xi", 0.999 * grazing, 1.001 * grazing);
  const std::vector<Branch> whole = follow_branches(newton_oscillator(), {{orbit, {1}}}, options).branches;
  REQUIRE(whole.size() > 16);
  for (const std::size_t kept : {std::size_t{1}, std::size_t{2}, std::size_t{9}}) {
    std::vector<Branch> first(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(kept));
    for (Branch& branch : first)
      for (SpecialPoint& point : branch.special_points) point.orbit.events.clear();  // as in a result file
    const BranchGraph resumed = follow_branches(newton_oscillator(), {{orbit, {1}}}, options, first);
    CHECK(found_families(resumed.branches) == found_families(whole));
    CHECK(resumed.branches.size() == whole.size());
  }
}
