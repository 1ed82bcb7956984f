// SPDX-License-Identifier: GPL-3.0-or-later
// The tracer does not depend on orbits: these curves are given by plain equations.
#include <graze/continuation/trace/trace.hpp>

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

using namespace graze;

namespace {

/// x^2 + y^2 = 1.
ZeroProblem circle() {
  ZeroProblem problem;
  problem.unknowns = 2;
  problem.evaluate = [](const Vector& u, Vector& residual, Matrix* jacobian) {
    residual = Vector::Constant(1, u.squaredNorm() - 1.0);
    if (jacobian) *jacobian = 2.0 * u.transpose();
    return true;
  };
  return problem;
}

/// y = x^3 - x, with the parameter y: two folds at x = +-1/sqrt(3).
ZeroProblem cubic() {
  ZeroProblem problem;
  problem.unknowns = 2;
  problem.evaluate = [](const Vector& u, Vector& residual, Matrix* jacobian) {
    residual = Vector::Constant(1, u[0] * u[0] * u[0] - u[0] - u[1]);
    if (jacobian) *jacobian = Matrix{{3.0 * u[0] * u[0] - 1.0, -1.0}};
    return true;
  };
  return problem;
}

}  // namespace

TEST_CASE("the tracer follows a circle and closes in both directions") {
  for (const double direction : {1.0, -1.0}) {
    const Curve curve = trace(circle(), Vector{{1.0, 0.0}}, Vector{{0.0, direction}});
    REQUIRE(curve.stop == TraceStop::closed);
    for (const CurvePoint& point : curve.points) {
      CHECK(std::abs(point.u.norm() - 1.0) < 1e-13);
      CHECK(std::abs(point.u.dot(point.tangent)) < 1e-12);
    }
    CHECK(direction * curve.points[1].u[1] > 0.0);
    // Chords of at most 0.05 are shorter than their arcs by a factor of 1 - 0.05^2/24.
    CHECK(curve.points.back().arclength == Approx(2.0 * M_PI).epsilon(0.01));
  }
}

TEST_CASE("the tracer passes both folds of a cubic without losing its direction") {
  const Curve curve = trace(cubic(), Vector{{-1.5, -1.875}}, Vector{{1.0, 0.0}}, {}, [](const CurvePoint&, CurvePoint& after) {
    return after.u[0] > 1.5 ? Verdict::stop : Verdict::go_on;
  });
  REQUIRE(curve.stop == TraceStop::monitor);
  int folds = 0;
  for (std::size_t k = 1; k < curve.points.size(); ++k) {
    CHECK(curve.points[k].u[0] > curve.points[k - 1].u[0]);
    CHECK(curve.points[k].arclength > curve.points[k - 1].arclength);
    folds += curve.points[k].tangent[1] * curve.points[k - 1].tangent[1] < 0.0;
  }
  CHECK(folds == 2);
}

TEST_CASE("a step of the tracer that would pass a limit ends on the limit, and passes a fold before it") {
  // From the origin the cubic falls to its fold at y = -2/(3 sqrt 3), then it rises.
  const double fold = -2.0 / (3.0 * std::sqrt(3.0));
  for (const double limit : {-0.2, fold - 1e-4}) {
    ZeroProblem problem = cubic();
    problem.limits = {{1, limit, 1.0, limit, 1.0}};
    problem.evaluate = [whole = problem.evaluate, limit](const Vector& u, Vector& residual, Matrix* jacobian) {
      return u[1] >= limit && whole(u, residual, jacobian);
    };
    const auto monitor = [&](const CurvePoint&, CurvePoint& after) {
      return after.u[1] == limit || after.u[0] > 1.2 ? Verdict::stop : Verdict::go_on;
    };
    const Curve curve = trace(problem, Vector{{0.0, 0.0}}, Vector{{1.0, -1.0}}, {}, monitor);
    REQUIRE(curve.stop == TraceStop::monitor);
    CHECK((curve.points.back().u[1] == limit) == (limit > fold));
    const auto near = [&](const CurvePoint& point) { return point.u[1] < limit + 1e-3; };
    if (limit > fold) CHECK(std::count_if(curve.points.begin(), curve.points.end(), near) <= 2);
  }
}

TEST_CASE("the tracer reports the end of the equations and keeps the first failed point") {
  ZeroProblem problem = circle();
  const auto whole = problem.evaluate;
  problem.evaluate = [whole](const Vector& u, Vector& residual, Matrix* jacobian) {
    return u[1] < 0.5 && whole(u, residual, jacobian);
  };
  problem.failure = [] { return std::string("beyond y = 0.5"); };
  const Curve curve = trace(problem, Vector{{1.0, 0.0}}, Vector{{0.0, 1.0}});
  CHECK(curve.stop == TraceStop::min_step);
  REQUIRE(curve.first_failed);
  CHECK(curve.points.back().u[1] == Approx(0.5).margin(1e-7));
  CHECK(curve.failure.find("beyond y = 0.5") != std::string::npos);
}

TEST_CASE("a start that is no solution fails with a reason and the limit of points is respected") {
  ZeroProblem nothing;
  nothing.unknowns = 2;
  nothing.evaluate = [](const Vector& u, Vector& residual, Matrix* jacobian) {
    residual = Vector::Constant(1, u.squaredNorm() + 1.0);
    if (jacobian) *jacobian = 2.0 * u.transpose();
    return true;
  };
  const Curve failed = trace(nothing, Vector{{1.0, 0.0}}, Vector{{0.0, 1.0}});
  CHECK(failed.stop == TraceStop::start_failed);
  CHECK_FALSE(failed.failure.empty());
  TraceOptions few;
  few.max_points = 5;
  const Curve limited = trace(circle(), Vector{{1.0, 0.0}}, Vector{{0.0, 1.0}}, few);
  CHECK(limited.stop == TraceStop::point_limit);
  CHECK(limited.points.size() == 5);
}

TEST_CASE("weights define the length along a curve") {
  ZeroProblem problem = circle();
  problem.weights = Vector::Constant(2, 4.0);
  const Curve curve = trace(problem, Vector{{1.0, 0.0}}, Vector{{0.0, 1.0}});
  REQUIRE(curve.stop == TraceStop::closed);
  CHECK(curve.points.back().arclength == Approx(4.0 * M_PI).epsilon(0.01));
}
