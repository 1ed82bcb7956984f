// SPDX-License-Identifier: GPL-3.0-or-later
// The skeleton of the published range: its required contents, and an independent computation of every special point.
#include <graze/continuation/conditions/grazing.hpp>
#include <graze/continuation/conditions/grazing_edge.hpp>
#include <graze/continuation/conditions/multiplier_equations.hpp>
#include <graze/continuation/graph/chatter_series.hpp>
#include <graze/continuation/graph/skeleton.hpp>
#include <graze/floquet/attractor/settle.hpp>
#include <graze/lib/models/oscillator.hpp>

#include "support/branches.hpp"
#include "support/checks.hpp"
#include "support/system_texts.hpp"

#include <catch2/catch.hpp>

#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <string>

using namespace graze;
using namespace graze::support;

namespace {

struct Example {
  HybridSystem system;
  Vector p;
  Skeleton found;
};

Example skeleton_of(const char* law, double b_H, int threads = 2, int max_multiple = 0) {
  Example c{make_oscillator("linear", law), {}, {}};
  c.p = default_parameters(c.system.parameters);
  for (const auto& [name, value] :
       std::initializer_list<std::pair<const char*, double>>{{"k_H", 100.0}, {"b_H", b_H}, {"k_r", 1.0}})
    for (std::size_t i = 0; i < c.system.parameters.size(); ++i)
      if (c.system.parameters[i].name == name) c.p[static_cast<Eigen::Index>(i)] = value;
  SkeletonOptions options;
  options.continuation.from = 0.65;
  options.continuation.to = 0.95;
  options.continuation.max_period = 16;
  options.continuation.max_branches = 200;
  options.continuation.threads = threads;
  options.max_multiple = max_multiple;
  Vector low = c.p;
  low[oscillator_parameter::eta] = 0.65;
  options.more_seeds = {shoot(c.system, low, steady_response(low), 1)};
  c.found = skeleton(c.system, c.p, options);
  return c;
}

std::vector<const SpecialPoint*> of_type(const Skeleton& found, PointType type) {
  std::vector<const SpecialPoint*> list;
  for (const Branch& branch : found.graph.branches)
    for (const SpecialPoint& point : branch.special_points)
      if (point.type == type) list.push_back(&point);
  return list;
}

bool has(const Skeleton& found, PointType type, double value, double tolerance) {
  const auto list = of_type(found, type);
  return std::any_of(list.begin(), list.end(), [&](const SpecialPoint* point) {
    return point->status == PointStatus::converged && std::abs(point->value - value) < tolerance;
  });
}

void check_graph(const Example& c) {
  std::set<std::string> labels;
  for (const Branch& branch : c.found.graph.branches) {
    INFO("branch " << branch.id);
    CHECK(check_branch(c.system, branch) == std::vector<std::string>{});
    const bool not_resolved = branch.message.find("cannot be told apart") != std::string::npos;
    CHECK((not_resolved || branch.stop == BranchStop::reached_bound || branch.stop == BranchStop::grazing ||
           branch.stop == BranchStop::returned));
    for (const SpecialPoint& point : branch.special_points) CHECK(labels.insert(point.label).second);
    if (!branch.parent) continue;
    REQUIRE(branch.parent->branch >= 1);
    REQUIRE(branch.parent->branch < branch.id);
    const Branch& parent = c.found.graph.branches[static_cast<std::size_t>(branch.parent->branch - 1)];
    CHECK(std::any_of(parent.special_points.begin(), parent.special_points.end(),
                      [&](const SpecialPoint& point) { return point.label == branch.parent->label; }));
  }
}

/// The special point again, with different nodes: twice the number, from another forcing phase. NaN if this does not converge.
double second_way(const Example& c, const SpecialPoint& point, double section) {
  const PeriodicOrbit& orbit = point.orbit;
  const int n = orbit.period;
  OrbitProblem here(c.system, orbit.parameters, n, static_cast<int>(orbit.nodes.size()), oscillator_parameter::eta, 0.3, {},
                    orbit.section_phase);
  OrbitProblem problem(c.system, orbit.parameters, n, 2 * n, oscillator_parameter::eta, 0.3, {}, section);
  const Vector u = here.pack(orbit.nodes, orbit.duration, point.value);
  // The start is displaced a little, so that the second computation must converge by itself.
  OrbitProblem moved = here.with_section(section);
  const auto moved_u = here.to_section(moved, u);
  if (!moved_u) return NAN;
  const PeriodicOrbit full = moved.orbit(*moved_u, {});
  std::vector<Vector> nodes;
  Transition transition;
  for (int j = 0; j < n; ++j) {
    const double T = orbit.duration / n, start = (section + j) * T;
    nodes.push_back(full.nodes[static_cast<std::size_t>(j)]);
    carry(moved.equations().propagator(), start, start + 0.5 * T, nodes.back(), {.sensitivity = Sensitivity::none}, transition);
    nodes.push_back(transition.x1);
  }
  const Vector start = problem.pack(nodes, orbit.duration, point.value + 1e-8);
  if (point.type == PointType::GR) {
    double nearest = NAN;
    for (const auto& guess : {weakest_contact(problem, start), nearest_miss(problem, start)}) {
      if (!guess) continue;
      const LocatedGrazing located = locate_grazing(problem, start, *guess);
      const double value = problem.value(located.u);
      if (located.newton.converged() && !(std::abs(value - point.value) >= std::abs(nearest - point.value))) nearest = value;
    }
    return nearest;
  }
  const double theta = point.type == PointType::PD ? std::numbers::pi : 0.0;
  const LocatedPoint located = locate(problem, *multiplier_equations({.theta = theta}), start);
  return located.newton.converged() ? problem.value(located.u) : NAN;
}

void check_second_way(const Example& c) {
  for (const Branch& branch : c.found.graph.branches)
    for (const SpecialPoint& point : branch.special_points) {
      if (point.type != PointType::GR && point.type != PointType::PD && point.type != PointType::LP) continue;
      INFO("branch " << branch.id << ", " << point.label << " at " << point.value);
      CHECK(point.status == PointStatus::converged);
      CHECK(point.precision < 1e-11);
      double best = NAN;
      for (const double section : {0.31, 0.57, 0.83}) {
        const double value = second_way(c, point, section);
        if (!(std::abs(value - point.value) >= std::abs(best - point.value))) best = value;
      }
      CHECK(std::abs(best - point.value) < 1e-11);
    }
}

}  // namespace

TEST_CASE("skeleton of damped Hertz over the published range") {
  const Example c = skeleton_of("hertz", 0.1);
  check_graph(c);
  // The figures in the issue, and those of data/reference.toml.
  CHECK(has(c.found, PointType::PD, 0.919542643087347, 1e-12));
  CHECK(has(c.found, PointType::PD, 0.743324589428472, 1e-12));
  CHECK(has(c.found, PointType::PD, 0.711271807308207, 1e-12));
  CHECK(has(c.found, PointType::GR, 0.910529633680, 1e-11));
  CHECK(has(c.found, PointType::GR, std::sqrt((1.99 - std::sqrt(1.99 * 1.99 - 3.0)) / 2.0), 1e-13));
  CHECK(has(c.found, PointType::LP, 0.6952, 1e-4));
  check_second_way(c);
  // Every family once: one branch of each period of the cascade, and the closed one of the 7/10 orbit published at 0.716.
  std::multiset<int> periods;
  for (const Branch& branch : c.found.graph.branches) periods.insert(branch.period);
  CHECK(periods == std::multiset<int>{1, 2, 4, 8, 10, 16});
  for (const CutOff& cut : c.found.graph.cut_off) CHECK(cut.reason.find("is above the limit, 16") != std::string::npos);
}

TEST_CASE("skeleton of undamped Hertz: two folds with a grazing between them within 3e-4") {
  const Example c = skeleton_of("hertz", 0.0);
  check_graph(c);
  CHECK(has(c.found, PointType::PD, 0.929365674294314, 1e-12));
  std::vector<double> near;
  for (const PointType type : {PointType::LP, PointType::GR})
    for (const SpecialPoint* point : of_type(c.found, type))
      if (std::abs(point->value - 0.791) < 1e-3) near.push_back(point->value);
  REQUIRE(near.size() == 3);
  CHECK((near[2] - near[0]) * (near[2] - near[1]) < 0.0);  // the grazing lies between the folds
  CHECK(std::abs(near[0] - near[1]) < 3e-4);
  check_second_way(c);
}

TEST_CASE("skeleton of Newton: every hard grazing is shared by the families on both of its sides") {
  const Example c = skeleton_of("newton", 0.0, 1);
  check_graph(c);
  CHECK(has(c.found, PointType::GR, std::sqrt((1.99 - std::sqrt(1.99 * 1.99 - 3.0)) / 2.0), 1e-13));
  for (const SpecialPoint* point : of_type(c.found, PointType::GR)) {
    const std::string scenario = text_detail(*point, "scenario");
    INFO(point->label << " at " << point->value);
    CHECK((scenario == "persistence" || scenario == "nonsmooth-fold"));
    CHECK(point->precision < 1e-12);
  }
  // Near the impactless grazing an orbit of long period has several maxima within 1e-10 of the barrier, so that double
  // precision cannot resolve the end of its branch. In 60 digits it begins at 0.71068636786025 (one impact gained). Another
  // maximum touches at 0.7106873690926(2), with a further one 3e-11 below the barrier and an impact of speed 8.9e-9. The
  // branch is kept and listed.
  const auto& cut_off = c.found.graph.cut_off;
  int broken_off = 0;
  for (const Branch& branch : c.found.graph.branches) {
    if (branch.stop != BranchStop::step_too_small) continue;
    ++broken_off;
    CHECK(branch.message.find("cannot be told apart") != std::string::npos);
    CHECK(branch.points.front().value > 0.71068636786025);
    CHECK(branch.points.back().value < 0.710687369093);
    const std::string label = branch.special_points.back().label;
    CHECK(std::any_of(cut_off.begin(), cut_off.end(), [&](const CutOff& entry) { return entry.label == label; }));
  }
  CHECK(broken_off <= 1);
  // Orbits with the weak impact in some of their turns are counted but not followed.
  CHECK(std::any_of(cut_off.begin(), cut_off.end(), [](const CutOff& entry) { return entry.families > 0; }));
  // Families that are reached only through the multiples: 1/6 ... 1/16 and the like, born on the grazing of the 1/2 orbit.
  CHECK(std::count_if(c.found.graph.branches.begin(), c.found.graph.branches.end(),
                      [](const Branch& branch) { return branch.period % 2 == 0 && branch.period > 4; }) > 40);
  // The family without the impact is followed from there and not found from a separate seed.
  for (const Branch& branch : c.found.graph.branches) {
    if (branch.stop != BranchStop::grazing) continue;
    const SpecialPoint& end = branch.special_points.back();
    const auto beyond = std::count_if(c.found.graph.branches.begin(), c.found.graph.branches.end(), [&](const Branch& other) {
      return other.id != branch.id &&
             ((other.parent && other.parent->label == end.label) || (branch.parent && other.id == branch.parent->branch) ||
              (other.stop == BranchStop::grazing && std::abs(other.stop_value - end.value) < 1e-9));
    });
    INFO("branch " << branch.id << " ends at " << end.label);
    CHECK(beyond > 0);
  }
  // Identical bits on two threads.
  const Example again = skeleton_of("newton", 0.0, 2);
  REQUIRE(again.found.graph.branches.size() == c.found.graph.branches.size());
  for (std::size_t k = 0; k < c.found.graph.branches.size(); ++k) {
    const Branch &a = c.found.graph.branches[k], &b = again.found.graph.branches[k];
    REQUIRE(a.points.size() == b.points.size());
    CHECK(a.points.back().value == b.points.back().value);
    CHECK(a.points.back().state() == b.points.back().state());
    REQUIRE(a.special_points.size() == b.special_points.size());
    for (std::size_t i = 0; i < a.special_points.size(); ++i) CHECK(a.special_points[i].value == b.special_points[i].value);
  }
}

TEST_CASE("an interrupted graph continues from its branches to the same end") {
  // Without multiples; grazing_multiples.cpp tests the same with them.
  Example c = skeleton_of("newton", 0.0, 2, 1);
  const std::vector<Branch>& whole = c.found.graph.branches;
  // As in a result file: only the states at phase 0.
  std::vector<Branch> kept(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(whole.size() / 2));
  for (Branch& branch : kept)
    for (SpecialPoint& point : branch.special_points) point.orbit.events.clear();
  std::vector<BranchSeed> seeds;
  for (const SkeletonSeed& seed : c.found.seeds) seeds.push_back({seed.orbit});
  ContinuationOptions options;
  options.from = 0.65;
  options.to = 0.95;
  options.max_period = 16;
  options.max_branches = 200;
  options.follow_parents = true;
  options.switch_generations = 64;
  const BranchGraph resumed = follow_branches(c.system, seeds, options, kept);
  const auto values = [](const std::vector<Branch>& branches) {
    std::vector<double> list;
    for (const Branch& branch : branches)
      for (const SpecialPoint& point : branch.special_points)
        if (point.type != PointType::EP) list.push_back(point.value);
    std::sort(list.begin(), list.end());
    return list;
  };
  CHECK(resumed.branches.size() == whole.size());
  const std::vector<double> a = values(whole), b = values(resumed.branches);
  REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) CHECK(std::abs(a[i] - b[i]) < 1e-11);
  std::set<std::string> labels;
  for (const Branch& branch : resumed.branches)
    for (const SpecialPoint& point : branch.special_points) CHECK(labels.insert(point.label).second);
}

TEST_CASE("a family is recognised if an impact passes phase 0 between two of its points") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = parameters(system, {{"k_r", 0.6}, {"r", 0.3}});
  SkeletonOptions options;
  options.continuation.from = 0.98;
  options.continuation.to = 1.0;
  options.settled_values = 61;
  const Skeleton found = skeleton(system, p, options);
  CHECK(found.seeds.size() > 60);
  // The 1/1 orbits, in both directions from their seed or in one piece.
  int towards_upper_end = 0;
  for (const Branch& branch : found.graph.branches)
    if (branch.period == 1 && branch.points.front().impacts == 1) towards_upper_end += branch.points.back().value == 1.0 ? 1 : 0;
  CHECK(towards_upper_end == 1);
}

TEST_CASE("a branch that was followed in both directions from a seed inside the range is one curve") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector p = parameters(system, {{"b_H", 0.1}, {"eta", 0.93}});
  const PeriodicOrbit orbit = shoot(system, p, settle(system, p, Vector::Zero(2)).state, 1);
  REQUIRE(orbit.converged());
  ContinuationOptions options;
  options.from = 0.95;
  options.to = 0.91;
  const BranchGraph graph = follow_branches(system, {{orbit}}, options);
  REQUIRE(graph.branches.size() == 3);  // two halves, and the doubled branch
  const std::vector<std::vector<std::size_t>> curves = curves_of(graph.branches);
  CHECK(curves == std::vector<std::vector<std::size_t>>{{0, 1}, {2}});
  // The halves share the seed and no other orbit.
  const Branch &up = graph.branches[0], &down = graph.branches[1];
  CHECK(up.points.front().value == Approx(0.93).epsilon(1e-14));
  CHECK((up.points.back().value - 0.93) * (down.points.back().value - 0.93) < 0.0);
  for (const BranchPoint& point : down.points) CHECK((point.value - 0.93) * (down.points.back().value - 0.93) >= -1e-14);
  // Without the other half it is a separate curve.
  CHECK(curves_of({graph.branches[1], graph.branches[2]}).size() == 2);
}

namespace {

/// A rigid stop over a range of eta, with the default selection of graze diagram.
Skeleton stable_skeleton(const Vector& p, double from, double to, int max_period) {
  SkeletonOptions options;
  options.continuation.from = from;
  options.continuation.to = to;
  options.continuation.max_period = max_period;
  options.continuation.max_branches = 500;
  options.continuation.threads = 2;
  options.settled_values = 61;
  options.families.all = false;
  return skeleton(make_oscillator("linear", "newton"), p, options);
}

bool is_stable_somewhere(const Branch& branch) {
  return std::any_of(branch.points.begin(), branch.points.end(), [](const BranchPoint& point) { return point.stable; });
}

}  // namespace

TEST_CASE("a stable isola without the end of a sweep is in the skeleton") {
  const Vector p = parameters(make_oscillator("linear", "newton"), {{"r", 1.0}, {"k_r", 0.8}});
  const Skeleton found = stable_skeleton(p, 0.4, 4.0, 2);
  CHECK(has(found, PointType::LP, 2.217669127453647, 1e-11));
  CHECK(has(found, PointType::LP, 2.772618713704250, 1e-11));
}

TEST_CASE("stable orbits of every period up to the longest are searched on a grid of a hundredth of the range") {
  const Vector p = parameters(make_oscillator("linear", "newton"), {{"b", 0.02}, {"r", 0.2}, {"k_r", 0.7}});
  const Skeleton found = stable_skeleton(p, 5.0, 14.0, 6);
  CHECK(found.fineness.max_period == 6);
  CHECK(found.fineness.spacing == Approx((14.0 - 5.0) / (found.fineness.values - 1)));
  CHECK(found.fineness.spacing < 0.01 * (14.0 - 5.0));
  CHECK(found.fineness.unstable_values == 0);
  // From the closed form, with 40 digits.
  for (const double value : {5.155619720995, 6.224562405290}) CHECK(has(found, PointType::GR, value, 1e-11));
  for (const double value : {7.394134417878, 8.778738262578}) CHECK(has(found, PointType::PD, value, 1e-11));
  for (const double value : {8.174281036223, 9.504968780561}) CHECK(has(found, PointType::LP, value, 1e-11));
}

TEST_CASE("all families that are stable somewhere are kept with the points that bound them") {
  SkeletonOptions options;
  options.continuation.from = 0.65;
  options.continuation.to = 0.95;
  options.continuation.max_period = 8;
  options.continuation.max_branches = 500;
  options.continuation.threads = 2;
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = default_parameters(system.parameters);
  const Skeleton all = skeleton(system, p, options);
  options.families.all = false;
  const Skeleton stable = skeleton(system, p, options);
  const auto unstable_of = [](const Skeleton& found) {
    return std::count_if(found.graph.branches.begin(), found.graph.branches.end(),
                         [](const Branch& branch) { return !is_stable_somewhere(branch); });
  };
  CHECK(unstable_of(stable) < unstable_of(all));
  for (const Branch& branch : all.graph.branches) {
    if (!is_stable_somewhere(branch)) continue;
    for (const SpecialPoint& point : branch.special_points) {
      if (point.type == PointType::EP) continue;
      INFO("branch " << branch.id << ", " << point.label << " at " << point.value);
      CHECK(has(stable, point.type, point.value, 1e-12));
    }
  }
  std::set<int> ids;
  for (const Branch& branch : stable.graph.branches) {
    if (branch.parent) CHECK(ids.contains(branch.parent->branch));
    ids.insert(branch.id);
    // The families on both sides of a grazing that ends a stable stretch.
    if (branch.stop != BranchStop::grazing || !branch.points.back().stable) continue;
    const SpecialPoint& end = branch.special_points.back();
    CHECK(std::any_of(stable.graph.branches.begin(), stable.graph.branches.end(), [&](const Branch& other) {
      return other.id != branch.id &&
             ((other.parent && other.parent->label == end.label) || (branch.parent && branch.parent->branch == other.id) ||
              (other.stop == BranchStop::grazing && std::abs(other.stop_value - end.value) < 1e-9));
    }));
  }
  // The omitted families are reported.
  const auto left_out = [](const Skeleton& found) {
    return std::count_if(found.graph.cut_off.begin(), found.graph.cut_off.end(),
                         [](const CutOff& cut) { return cut.branch == 0 && cut.families > 0; });
  };
  CHECK(left_out(stable) > 0);
  CHECK(left_out(all) == 0);
}

TEST_CASE("distances that shrink in a constant ratio accumulate and those of a power law do not") {
  std::array<double, grazings_of_series> values{};
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = 2.0 - 0.3 * std::pow(0.7, static_cast<double>(values.size() - k));
  const std::optional<SeriesLimit> limit = limit_of_series(values);
  REQUIRE(limit);
  CHECK(limit->ratio == Approx(0.7).epsilon(1e-12));
  CHECK(limit->value == Approx(2.0).epsilon(1e-12));
  for (const double power : {1.0, 2.0, 0.5})
    for (const double first : {3.0, 10.0, 100.0}) {
      for (std::size_t k = 0; k < values.size(); ++k)
        values[k] = 2.0 - std::pow(first + static_cast<double>(values.size() - k), -power);
      CHECK_FALSE(limit_of_series(values));
    }
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = 0.1 * static_cast<double>(k);
  CHECK_FALSE(limit_of_series(values));
}

TEST_CASE("a series towards complete chatter is followed to its accumulation and the sticking orbits beyond it") {
  const Vector p = parameters(make_oscillator("linear", "newton"), {{"b", 0.02}, {"r", 0.5}, {"k_r", 0.7}});
  const Skeleton found = stable_skeleton(p, 0.42, 0.45, 1);
  const auto sticks = [](const BranchPoint& point) { return point.isolated_impacts < point.impacts; };
  int most = 0;
  double sticks_up_to = 0.0;
  for (const Branch& branch : found.graph.branches) {
    const bool chatters = std::any_of(branch.points.begin(), branch.points.end(), sticks);
    for (const BranchPoint& point : branch.points) {
      if (!chatters) most = std::max(most, point.impacts);
      if (sticks(point)) sticks_up_to = std::max(sticks_up_to, point.value);
    }
  }
  CHECK(most >= 8);
  CHECK(most <= 12);
  CHECK(sticks_up_to > 0.4267);  // there the chatter is complete
  std::string reason;
  for (const CutOff& cut : found.graph.cut_off)
    if (cut.reason.find("accumulates") != std::string::npos) reason = cut.reason;
  REQUIRE_FALSE(reason.empty());
  const double accumulates = std::stod(reason.substr(reason.find("at eta = ") + 9));
  CHECK(std::abs(accumulates - sticks_up_to) < 2e-5);  // the last family followed lies 5e-4 before it
  const double ratio = std::stod(reason.substr(reason.find("in the ratio ") + 13));
  CHECK(std::abs(ratio - 0.7) < 0.02);  // the coefficient of restitution
}

TEST_CASE("a doubled orbit with many impacts on a very narrow branch is listed where it is born") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector p = parameters(system, {{"eta", 0.925}, {"b_H", 0.1}});
  const Settled settled = settle(system, p, Vector::Zero(2));
  REQUIRE(settled.suspected_period == 1);
  ContinuationOptions options;
  options.from = 0.7;
  options.to = 0.95;
  options.max_period = 4;
  options.switch_generations = 2;
  const auto graph_of = [&](double narrowest) {
    return follow_branches(system, {{shoot(system, p, settled.state, 1)}}, options, {},
                           {.all = false, .narrowest = narrowest, .most_impacts_unseen = 3});
  };
  const auto of_period = [](const BranchGraph& graph, int period) {
    return std::count_if(graph.branches.begin(), graph.branches.end(), [&](const Branch& b) { return b.period == period; });
  };
  const auto listed = [](const BranchGraph& graph) {
    return std::count_if(graph.cut_off.begin(), graph.cut_off.end(), [](const CutOff& cut) {
      return cut.label.starts_with("PD") && cut.reason.starts_with("more than 3 impacts, born on a branch narrower than");
    });
  };
  // All branches are narrower than twice the range; none is narrower than a billionth of it.
  const BranchGraph cut = graph_of(2.0), whole = graph_of(1e-9);
  CHECK(of_period(whole, 4) > 0);
  CHECK(listed(whole) == 0);
  CHECK(of_period(cut, 2) == of_period(whole, 2));
  CHECK(of_period(cut, 4) == 0);
  CHECK(listed(cut) > 0);
}

TEST_CASE("an orbit without states that is reduced to its least period has none afterwards") {
  PeriodicOrbit orbit;
  orbit.period = 2;
  orbit.state = vector({0.3, 0.1});
  orbit.nodes = {orbit.state, orbit.state};
  LocatedGrazing grazing;
  grazing.u = vector({0.3, 0.1, 0.3, 0.1, 0.5});
  grazing.family_dp = grazing.u;
  CHECK(to_least_period(orbit, grazing) == 1);
  CHECK(orbit.states.empty());
  // Therefore it equals no other orbit.
  const GrazingEdge unknown{0.5, 1, 1, orbit.states}, known{0.5, 1, 1, {orbit.state}};
  CHECK(!same_edge(unknown, known, 1.0));
  CHECK(!same_edge(known, unknown, 1.0));
  CHECK(same_edge(known, known, 1.0));
}

TEST_CASE("of places where friction holds a mass for good, a skeleton seeks one") {
  SystemWriter writer;
  writer.system.name = "floor";
  writer.forcing("w").parameter("w", "0.6").parameter("mu", "1.1");
  writer.mechanics({"x"}, {"v"}, {{{"1"}}, {{"0.1"}}, {{"1"}}, {"cos(w*t)"}}).friction("floor", "v", "1", "mu");
  const HybridSystem system = equations::make_system(writer.system).system;
  SkeletonOptions options;
  options.continuation.parameter = "mu";
  options.continuation.from = 1.1;
  options.continuation.to = 1.2;
  options.settled_values = 2;
  options.stable_values = 2;
  options.settle = 100;
  options.stable_search.starts = 4;
  options.stable_search.settling.periods = 50;
  options.families.all = false;  // at the edges of the places every state nearly closes, which makes that search long
  const std::vector<SkeletonSeed> seeds = skeleton_seeds(system, default_parameters(system.parameters), options);
  int held = 0;
  for (const SkeletonSeed& seed : seeds)
    if (seed.orbit.multipliers.trivial == 1) {
      CHECK(seed.orbit.state == Vector{{0.0, 0.0}});
      ++held;
    }
  CHECK(held >= 1);
  CHECK(held <= 2);  // one at each value
}
