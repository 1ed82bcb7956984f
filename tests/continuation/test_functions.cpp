// SPDX-License-Identifier: GPL-3.0-or-later
// Requirements on every entry of test_functions(), for maps whose bifurcations have closed forms (map_system.hpp). Its value
// changes sign exactly at its own bifurcation. confirm() accepts this point and rejects those of the others. locate() finds
// the point to the stated precision. A new test function fails the first test until a family with its bifurcation is added to
// families().
#include <graze/continuation/conditions/test_function.hpp>
#include <graze/continuation/graph/branch_graph.hpp>
#include <graze/continuation/graph/continuation.hpp>
#include <graze/continuation/graph/skeleton.hpp>
#include <graze/continuation/problems/orbit_problem.hpp>

#include "support/branches.hpp"
#include "support/checks.hpp"
#include "support/map_system.hpp"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <vector>

using namespace graze;
using namespace graze::support;

namespace {

/// A curve of fixed points lambda(s), x(s) of a map with one bifurcation, at s = 0, and sign changes of other test functions.
struct Family {
  const char* name;
  HybridSystem system;
  PointType type;  ///< MX: a sign change of some value without any bifurcation
  double value;    ///< of lambda at the bifurcation
  std::function<double(double s)> lambda;
  std::function<Vector(double s)> x;
  Vector direction;         ///< (dx/ds, dlambda/ds), approximately: the direction along the curve
  double smallest = 1e-12;  ///< smallest s at which all signs are still certain
};

HybridSystem diagonal(std::size_t states, std::function<Vector(double)> values, std::function<Vector(double)> slope) {
  return diagonal_map("diagonal", states, std::move(values), std::move(slope));
}

std::vector<Family> families() {
  const auto plus = [](double offset) { return [offset](double s) { return offset + s; }; };
  const auto zero = [](Eigen::Index n) { return [n](double) -> Vector { return Vector::Zero(n); }; };
  std::vector<Family> list;
  list.push_back({"fold", fold_map(), PointType::LP, 0.0, [](double s) { return s * s; }, [](double s) { return Vector{{s}}; },
                  Vector{{1.0, 0.0}}});
  list.push_back({"period doubling after a fold", fold_map(), PointType::PD, 1.0, [](double s) { return (1.0 + s) * (1.0 + s); },
                  [](double s) { return Vector{{1.0 + s}}; }, Vector{{1.0, 2.0}}});
  list.push_back({"logistic", logistic_map(), PointType::PD, 3.0, plus(3.0),
                  [](double s) { return Vector{{1.0 - 1.0 / (3.0 + s)}}; }, Vector{{0.1, 1.0}}});
  list.push_back({"supercritical flip", flip_map<1>(), PointType::PD, 0.0, plus(0.0), zero(1), Vector{{0.0, 1.0}}});
  list.push_back({"subcritical flip", flip_map<-1>(), PointType::PD, 0.0, plus(0.0), zero(1), Vector{{0.0, 1.0}}});
  list.push_back({"transcritical, x = 0", transcritical_map(), PointType::BP, 0.0, plus(0.0), zero(1), Vector{{0.0, 1.0}}});
  list.push_back({"transcritical, x = lambda", transcritical_map(), PointType::BP, 0.0, plus(0.0),
                  [](double s) { return Vector{{s}}; }, Vector{{1.0, 1.0}}});
  list.push_back({"pitchfork, x = 0", pitchfork_map(), PointType::BP, 0.0, plus(0.0), zero(1), Vector{{0.0, 1.0}}});
  // The branch that turns: the lambda component of the tangent passes zero as at a fold. Its multiplier is 1 - 2 s^2.
  list.push_back({"pitchfork, x^2 = lambda", pitchfork_map(), PointType::BP, 0.0, [](double s) { return s * s; },
                  [](double s) { return Vector{{s}}; }, Vector{{1.0, 0.0}}, 1e-6});
  list.push_back({"delayed logistic", delayed_logistic_map(), PointType::NS, 2.0, plus(2.0),
                  [](double s) { return Vector::Constant(2, 1.0 - 1.0 / (2.0 + s)); }, Vector{{0.25, 0.25, 1.0}}});
  // Multipliers 2 + s and 1/2: their product passes 1, a neutral saddle.
  list.push_back({"neutral saddle",
                  diagonal(
                      2,
                      [](double s) {
                        return Vector{{2.0 + s, 0.5}};
                      },
                      [](double) {
                        return Vector{{1.0, 0.0}};
                      }),
                  PointType::MX, 0.0, plus(0.0), zero(2), Vector{{0.0, 0.0, 1.0}}});
  // A doubling with three further multipliers: beyond -1, beyond +1 and small.
  list.push_back({"flip in four dimensions",
                  diagonal(
                      4,
                      [](double s) {
                        return Vector{{-1.0 - s, -3.0, 2.0, 0.1}};
                      },
                      [](double) {
                        return Vector{{-1.0, 0.0, 0.0, 0.0}};
                      }),
                  PointType::PD, 0.0, plus(0.0), zero(4), Vector{{0.0, 0.0, 0.0, 0.0, 1.0}}});
  return list;
}

/// The point of the family at s, as input of the test functions.
struct At {
  CurvePoint curve;
  BranchPoint branch;
  TestPoint point() const { return {curve, branch}; }
};

OrbitProblem problem_of(const Family& family) {
  return OrbitProblem(family.system, parameters(family.system, {{"lambda", family.value}}), 1, 1, 1, 1.0);
}

At at(OrbitProblem& problem, const Family& family, double s) {
  At here;
  here.curve.u = problem.pack({family.x(s)}, 0.0, family.lambda(s));
  here.curve.arclength = s;
  here.curve.tangent = tangent_at(problem.zero_problem(), here.curve.u, family.direction);
  REQUIRE(here.curve.tangent.size() == here.curve.u.size());
  here.branch = problem.branch_point(here.curve.u, s);
  REQUIRE(here.branch.checks.residual < 1e-14);
  return here;
}

bool changes_sign(const TestFunction& test, const At& a, const At& b) {
  const double f_a = test.value(a.point()), f_b = test.value(b.point());
  REQUIRE(std::isfinite(f_a));
  REQUIRE(std::isfinite(f_b));
  return (f_a < 0.0) != (f_b < 0.0);
}

}  // namespace

TEST_CASE("every test function has a type, its own summary, and a family of maps to be tested on") {
  std::set<PointType> types, covered;
  std::set<std::string> summaries;
  for (const Family& family : families()) covered.insert(family.type);
  for (const TestFunction& test : test_functions()) {
    INFO(point_type_name(test.type));
    CHECK(test.type != PointType::MX);
    CHECK(test.type != PointType::EP);
    CHECK(types.insert(test.type).second);
    CHECK(std::string(test.summary).size() > 20);
    CHECK(summaries.insert(test.summary).second);
    REQUIRE(test.value);
    REQUIRE(test.confirm);
    REQUIRE(test.equations);  // describe may be empty
    CHECK(covered.count(test.type) == 1);
    CHECK(point_type(point_type_name(test.type)) == test.type);
  }
}

TEST_CASE("the value of every test function changes sign exactly at its bifurcation and is confirmed only there") {
  for (const Family& family : families()) {
    OrbitProblem problem = problem_of(family);
    for (const TestFunction& test : test_functions()) {
      INFO(family.name << ": " << point_type_name(test.type));
      const bool own = test.type == family.type;
      // Steps of every size over the point, and next to it on either side. The error of the multipliers is about 1e-15, and
      // they pass the unit circle at a rate of at least 0.3 per unit of s: at 1e-12 the sign is certain.
      for (const double size : {0.2, 1e-2, 1e-4, 1e-8, 1e-12}) {
        if (size < family.smallest) continue;
        INFO("steps of " << size);
        const At before = at(problem, family, -size), after = at(problem, family, 0.7 * size);
        if (own) CHECK(changes_sign(test, before, after));
        CHECK((changes_sign(test, before, after) && test.confirm(before.point(), after.point())) == own);
        CHECK((changes_sign(test, after, before) && test.confirm(after.point(), before.point())) == own);  // both ways
        const At far = at(problem, family, -2.0 * size), on = at(problem, family, 1.3 * size);
        CHECK_FALSE((changes_sign(test, far, before) && test.confirm(far.point(), before.point())));
        CHECK_FALSE((changes_sign(test, after, on) && test.confirm(after.point(), on.point())));
      }
    }
  }
}

TEST_CASE("a neutral saddle or a pair that becomes real is not taken for Neimark-Sacker") {
  using Values = std::vector<std::complex<double>>;
  const TestFunction test = neimark_sacker_test();
  const auto confirms = [&test](const Values& before, const Values& after) {
    const CurvePoint curve;
    BranchPoint a, b;
    a.multipliers.values = before;
    b.multipliers.values = after;
    return test.confirm({curve, a}, {curve, b});
  };
  const std::complex<double> inside(0.6, 0.79), outside(0.61, 0.8), far(2.0, 0.01);
  const auto pair = [](const std::complex<double>& mu, double a, double b) { return Values{mu, std::conj(mu), a, b}; };
  CHECK(confirms(pair(inside, 0.2, 0.1), pair(outside, 0.2, 0.1)));
  CHECK(confirms(pair(outside, 3.0, 0.1), pair(inside, 3.0, 0.1)));
  CHECK_FALSE(confirms({34.3, 5.6, 0.178, 0.0004}, {34.3, 5.6, 0.179, 0.0004}));
  CHECK_FALSE(confirms(pair(far, 0.49, 0.1), {2.05, 1.96, 0.51, 0.1}));  // the product of two passes one nearby
  CHECK_FALSE(confirms({2.05, 1.96, 0.99, 0.1}, pair(far, 1.01, 0.1)));  // near a fold
}

TEST_CASE("every test function locates its point to the stated precision") {
  for (const Family& family : families()) {
    for (const TestFunction& test : test_functions()) {
      if (test.type != family.type) continue;
      for (const double s : {-0.05, 0.02, 1e-6}) {
        INFO(family.name << " from s = " << s);
        OrbitProblem problem = problem_of(family);
        const At near = at(problem, family, s);
        const LocatedPoint located = locate(problem, *test.equations(near.point()), near.curve.u);
        REQUIRE(located.newton.converged());
        const double error = std::abs(problem.value(located.u) - family.value);
        CHECK(located.precision > 0.0);
        CHECK(located.precision < 1e-11);
        CHECK(error <= located.precision);
        // The state at a fold or a pitchfork has at worst the root of the error of the parameter.
        CHECK((located.u.head(located.u.size() - 1) - family.x(0.0)).norm() < 1e-7);
        SpecialPoint point;
        if (test.describe) test.describe(problem, located, point);
        if (test.type == PointType::NS)
          CHECK(number_detail(point, "angle") ==
                Approx(M_PI / 3.0).margin(1e-11));  // delayed logistic: multipliers exp(+-i pi/3)
        if (std::string(family.name) == "supercritical flip") CHECK(text_detail(point, "criticality") == "supercritical");
        if (std::string(family.name) == "subcritical flip") CHECK(text_detail(point, "criticality") == "subcritical");
      }
    }
  }
}

TEST_CASE("a branch through each of these bifurcations reports it once under its own name") {
  for (const Family& family : families()) {
    INFO(family.name);
    const Vector p = parameters(family.system, {{"lambda", family.lambda(-0.1)}});
    const PeriodicOrbit orbit = shoot(family.system, p, family.x(-0.1), 1);
    REQUIRE(orbit.converged());
    ContinuationOptions options;
    options.parameter = "lambda";
    // A branch that turns returns to its start.
    const bool turns = std::abs(family.lambda(0.1) - family.lambda(-0.1)) < 1e-12;
    options.to = turns ? family.value - 0.01 : family.lambda(0.1);
    options.from = family.lambda(-0.1);
    options.switch_generations = 0;
    const std::vector<Branch> branches = continue_orbit(family.system, orbit, options);
    REQUIRE(branches[0].stop == BranchStop::reached_bound);
    CHECK(types_of(branches[0]) == (family.type == PointType::MX ? "" : std::string(point_type_name(family.type))));
    for (const SpecialPoint& point : points_of(branches[0], family.type)) {
      CHECK(point.status == PointStatus::converged);
      CHECK(std::abs(point.value - family.value) <= point.precision);
      CHECK(point.precision < 1e-11);
    }
    CHECK(check_branch(family.system, branches[0]) == std::vector<std::string>{});
  }
}

TEST_CASE("a program that uses the library adds a condition of its own") {
  // The fixed point of the logistic map is x = 1 - 1/lambda.
  const HybridSystem system = logistic_map();
  const Vector p = parameters(system, {{"lambda", 2.5}});
  const PeriodicOrbit orbit = shoot(system, p, Vector{{0.6}}, 1);
  REQUIRE(orbit.converged());
  ContinuationOptions options;
  options.parameter = "lambda";
  options.to = 3.2;
  options.switch_generations = 0;
  options.further_tests = {zero_test("x = 0.65", [](const BranchPoint& point) { return point.state()[0] - 0.65; }),
                           zero_test("x = 0.5", [](const BranchPoint& point) { return point.state()[0] - 0.5; })};
  const std::vector<Branch> branches = continue_orbit(system, orbit, options);
  CHECK(types_of(branches[0]) == "UZ PD");
  const SpecialPoint point = points_of(branches[0], PointType::UZ).at(0);
  CHECK(point.status == PointStatus::converged);
  CHECK(text_detail(point, "condition") == "x = 0.65");
  CHECK(std::abs(point.value - 1.0 / 0.35) <= point.precision);
  CHECK(point.precision < 1e-11);
}

namespace {

/// Equations that cannot be evaluated.
class Unsolvable : public DefiningEquations {
 public:
  bool evaluate(BranchProblem&, const Vector&, Vector&, Matrix*) override { return false; }
  Vector sizes() const override { return {}; }
};

}  // namespace

TEST_CASE("the points of a condition have its name, whether Newton's method locates them or not") {
  // The multiplier of the fixed point is 2 - lambda.
  const HybridSystem system = logistic_map();
  const PeriodicOrbit orbit = shoot(system, parameters(system, {{"lambda", 2.5}}), Vector{{0.6}}, 1);
  REQUIRE(orbit.converged());
  ContinuationOptions options;
  options.parameter = "lambda";
  options.to = 3.2;
  options.switch_generations = 0;
  TestFunction test = period_doubling_test();
  test.type = PointType::UZ;
  test.condition = "multiplier -1";
  test.describe = nullptr;
  TestFunction failing = test;
  failing.condition = "multiplier -1, bracketed";
  failing.equations = [](const TestPoint&) { return std::make_unique<Unsolvable>(); };
  options.further_tests = {test, failing};
  const std::vector<Branch> branches = continue_orbit(system, orbit, options);
  const std::vector<SpecialPoint> points = points_of(branches[0], PointType::UZ);
  REQUIRE(points.size() == 2);
  std::set<std::string> names;
  for (const SpecialPoint& point : points) {
    names.insert(text_detail(point, "condition"));
    CHECK(std::abs(point.value - 3.0) <= point.precision + 1e-11);
  }
  CHECK(names == std::set<std::string>{"multiplier -1", "multiplier -1, bracketed"});
}

TEST_CASE("an orbit traversed several times solves the equations of its multiple period") {
  const HybridSystem system = logistic_map();
  OrbitProblem problem(system, parameters(system, {{"lambda", 2.5}}), 1, 1, 0, 1.0);
  const Vector u = problem.pack({Vector{{0.6}}}, 0.0, 2.5);
  OrbitProblem longer = problem.repeated(3);
  CHECK(longer.period() == 3);
  CHECK(longer.nodes() == 3);
  const Vector there = problem.repeat(u, 3);
  REQUIRE(there.size() == longer.unknowns());
  CHECK(longer.value(there) == 2.5);
  Vector residual;
  REQUIRE(longer.residual(there, residual, nullptr));
  CHECK(residual.lpNorm<Eigen::Infinity>() < 1e-14);
  CHECK_THROWS_WITH(problem.repeat(u, 0), Catch::Contains("0 times") && Catch::Contains("1 and more"));
}

TEST_CASE("a condition from outside the library states which branch is born at its points") {
  const HybridSystem system = logistic_map();
  const PeriodicOrbit orbit = shoot(system, parameters(system, {{"lambda", 2.5}}), Vector{{0.6}}, 1);
  ContinuationOptions options;
  options.parameter = "lambda";
  options.to = 2.9;
  TestFunction test = zero_test("x = 0.65", [](const BranchPoint& point) { return point.state()[0] - 0.65; });
  std::vector<int> asked;
  Birth birth{.sides = {1, -1}, .missing = "nothing begins there"};
  birth.start = [&asked](const SpecialPoint& point, const Branch& on, OrbitProblem& states, int side, const TraceOptions&) {
    CHECK(point.type == PointType::UZ);
    CHECK(on.id == 1);
    CHECK(states.period() == 1);
    asked.push_back(side);
    return std::optional<BranchStart>();
  };
  test.born = birth;
  // Another condition has points too; no branch is born at them.
  options.further_tests = {test, zero_test("x = 0.63", [](const BranchPoint& point) { return point.state()[0] - 0.63; })};
  options.threads = 1;
  const BranchGraph graph = follow_branches(system, {{orbit, {1}}}, options);
  std::sort(asked.begin(), asked.end());
  CHECK(asked == std::vector<int>{-1, 1});
  REQUIRE(graph.branches.size() == 1);
  CHECK(types_of(graph.branches[0]) == "UZ UZ");
  REQUIRE(graph.cut_off.size() == 1);
  CHECK(graph.cut_off[0].label == "UZ2");
  CHECK(graph.cut_off[0].reason == "nothing begins there");

  options.further_tests[0].born->certain = true;
  const BranchGraph certain = follow_branches(system, {{orbit, {1}}}, options);
  REQUIRE(certain.branches.size() == 3);
  CHECK(certain.branches[1].stop == BranchStop::start_failed);
  CHECK(certain.branches[1].message == "nothing begins there beside UZ2");

  // (fixed) Without `from` the range began at an undefined value, here and where there is no orbit to begin at.
  options.from = 2.5;
  CHECK(follow_branches(system, {{orbit, {1}}}, options).branches[0].points.size() == graph.branches[0].points.size());
  options.from = {};
  CHECK_THROWS_WITH(follow_branches(system, {}, options), Catch::Contains("give both of its ends"));
  CHECK_THROWS_WITH(skeleton(system, orbit.parameters, {.continuation = options}), Catch::Contains("needs both ends"));
}
