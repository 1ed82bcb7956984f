// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/trace/trace.hpp>
#include <graze/lib/numerics/orbit_lu.hpp>
#include <graze/lib/tasks/newton_loop.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace graze {

namespace {

Vector weights_of(const ZeroProblem& problem) {
  return problem.weights.size() == problem.unknowns ? problem.weights : Vector::Ones(problem.unknowns);
}

/// [J; row] with one row added below.
Matrix bordered(const Matrix& jacobian, const Vector& row) {
  Matrix A(jacobian.rows() + 1, jacobian.cols());
  A << jacobian, row.transpose();
  return A;
}

std::string reason(const ZeroProblem& problem, NewtonStatus status) {
  std::string text(newton_status_text(status));
  if (status == NewtonStatus::evaluation_failed && problem.failure) text += ": " + problem.failure();
  return text;
}

/// True if the step from `last` to `next`, of this length, passes through `first` in the direction of its tangent; `next` then
/// becomes `first`. Closeness alone does not decide: another turn of the curve may pass nearby.
bool returns_to(const CurvePoint& first, const ZeroProblem& problem, const Vector& weights, const CurvePoint& last,
                CurvePoint& next, double length, const TraceOptions& options) {
  // Near means within two step lengths in each unknown. The parameter (last) and the first unknowns are tested first: they rule
  // out most points of a long curve and most images of an orbit.
  const Eigen::Index end = first.u.size() - 1;
  const auto is_far = [&](Eigen::Index i) {
    const double apart = first.u[i] - last.u[i];
    return weights[i] * apart * apart > 4.0 * length * length;
  };
  if (is_far(end)) return false;
  for (Eigen::Index i = 0; i < end; ++i)
    if (is_far(i)) return false;
  const Vector normal = weights.cwiseProduct(first.tangent);
  const double before = normal.dot(last.u - first.u), after = normal.dot(next.u - first.u);
  if (!(before < 0.0 && after >= 0.0)) return false;
  Vector u = last.u + before / (before - after) * (next.u - last.u);
  if (weighted_norm(weights, u - first.u) > length) return false;
  if (!correct(problem, first.tangent, u, options).converged()) return false;
  if (weighted_norm(weights, u - first.u) > 1e-8 * (1.0 + weighted_norm(weights, u))) return false;
  next.u = first.u;
  next.tangent = first.tangent;
  next.arclength = last.arclength + weighted_norm(weights, first.u - last.u);
  return true;
}

/// A step along the tangent: its end, its length, and the direction in which the corrector keeps its place.
struct Prediction {
  Vector u, direction;
  double length, shortest;  ///< below `shortest` the step is not halved
};

/// The end of a step of this length, or the place on the step at which an unknown reaches the end of its range, if it would pass
/// a limit.
Prediction predict(const ZeroProblem& problem, const CurvePoint& last, double step, double shortest) {
  Prediction out{last.u + step * last.tangent, last.tangent, step, shortest};
  for (const UnknownLimits& limits : problem.limits) {
    const double from = last.u[limits.unknown], rate = last.tangent[limits.unknown], to = from + out.length * rate;
    if (to >= limits.lower && to <= limits.upper) continue;
    const double end = to < limits.lower ? limits.low : limits.high, length = (end - from) / rate;
    if (!(length >= shortest && length <= out.length)) continue;
    out = {last.u + length * last.tangent, Vector::Unit(last.u.size(), limits.unknown), length,
           std::max(shortest, limits.shortest)};
    out.u[limits.unknown] = end;
  }
  return out;
}

}  // namespace

NewtonReport correct(const ZeroProblem& problem, const Vector& direction, Vector& u, const TraceOptions& options) {
  constexpr double none = std::numeric_limits<double>::infinity();
  const Vector weighted = weights_of(problem).cwiseProduct(direction);
  // Full steps; the first residual below the tolerance is enough, because the next prediction starts with a larger error.
  const NewtonRule rule{.max_iterations = options.max_iterations,
                        .acceptance = options.acceptance,
                        .tolerance = options.acceptance,
                        .rounding = options.tolerance,
                        .isolated = true,
                        .growth = 10.0,
                        .max_halvings = 0,
                        .max_step = none};
  Vector residual;
  Matrix jacobian;
  const auto evaluate = [&](const Vector& trial) -> std::optional<double> {
    if (!problem.evaluate(trial, residual, &jacobian)) return std::nullopt;
    return residual.lpNorm<Eigen::Infinity>() / problem.size;
  };
  const auto solve = [&](const Vector& at, Vector& step) {
    Vector right(problem.unknowns);
    right << -residual, 0.0;
    step = OrbitLU<Matrix>(bordered(jacobian, weighted)).solve(right);
    return NewtonStep{.length = step.lpNorm<Eigen::Infinity>(), .size = 1.0 + at.lpNorm<Eigen::Infinity>()};
  };
  return newton(u, evaluate, solve, rule);
}

Vector tangent_at(const ZeroProblem& problem, const Vector& u, const Vector& orientation) {
  const Vector weights = weights_of(problem);
  Vector residual;
  Matrix jacobian;
  if (!problem.evaluate(u, residual, &jacobian)) return {};
  Vector right = Vector::Zero(problem.unknowns);
  right[problem.unknowns - 1] = 1.0;
  Vector tangent = OrbitLU<Matrix>(bordered(jacobian, weights.cwiseProduct(orientation))).solve(right);
  // Where the direction given is no guide, the kernel itself (dense, but only there).
  if (!tangent.allFinite()) tangent = Eigen::FullPivLU<Matrix>(jacobian).kernel().col(0);
  const double length = weighted_norm(weights, tangent);
  if (!(length > 0.0) || !std::isfinite(length)) return {};
  tangent /= length;
  if (weights.cwiseProduct(orientation).dot(tangent) < 0.0) tangent = -tangent;
  return tangent;
}

Curve trace(const ZeroProblem& problem, const Vector& u0, const Vector& orientation, const TraceOptions& options,
            const Monitor& monitor, const ClosurePoints& closure_points) {
  Curve curve;
  const Vector weights = weights_of(problem);
  CurvePoint start;
  start.u = u0;
  start.newton = correct(problem, orientation / weighted_norm(weights, orientation), start.u, options);
  if (start.newton.converged()) start.tangent = tangent_at(problem, start.u, orientation);
  if (start.tangent.size() == 0) {
    curve.stop = TraceStop::start_failed;
    curve.first_failed = u0;
    curve.failure = start.newton.converged() ? "the curve has no tangent there" : reason(problem, start.newton.status);
    return curve;
  }
  curve.points.push_back(start);
  const std::vector<CurvePoint> origins = closure_points ? closure_points(start) : std::vector<CurvePoint>{start};
  double step = options.initial_step;
  while (static_cast<int>(curve.points.size()) < options.max_points) {
    const CurvePoint& last = curve.points.back();
    CurvePoint next;
    const Prediction prediction = predict(problem, last, step, options.min_step);
    const Vector& predicted = prediction.u;
    step = prediction.length;
    next.u = predicted;
    next.newton = correct(problem, prediction.direction, next.u, options);
    Verdict verdict = Verdict::reject;
    bool closes = false;
    if (next.newton.converged()) {
      next.tangent = tangent_at(problem, next.u, last.tangent);
      const double length = weighted_norm(weights, next.u - last.u);
      next.arclength = last.arclength + length;
      const double cosine = next.tangent.size() == 0 ? -1.0 : weights.cwiseProduct(next.tangent).dot(last.tangent);
      // A jump to a neighbouring curve shows as a correction longer than half the step, a kink as a large angle.
      const bool smooth = std::acos(std::clamp(cosine, -1.0, 1.0)) <= options.max_angle &&
                          weighted_norm(weights, next.u - predicted) <= 0.5 * step;
      const auto comes_to = [&](const CurvePoint& point) {
        return returns_to(point, problem, weights, last, next, length, options);
      };
      closes = smooth && (std::any_of(origins.begin(), origins.end(), comes_to) ||
                          (curve.points.size() > 2 && std::any_of(curve.points.begin() + 1, curve.points.end() - 2, comes_to)));
      // At the smallest step the monitor decides about a kink; a long jump, which lands on another curve, is rejected here.
      constexpr double elsewhere = 1e-3;
      const bool jumps = !smooth && step <= options.min_step && length > elsewhere;
      if (smooth || (step <= options.min_step && !jumps && next.tangent.size() > 0))
        verdict = monitor ? monitor(last, next) : Verdict::go_on;
      if (!smooth && verdict == Verdict::reject)
        curve.failure = jumps ? "the orbit found beyond lies elsewhere" : "the curve turns too sharply";
      if (smooth && verdict == Verdict::reject) curve.failure = verdict.reason;
    } else {
      curve.failure = reason(problem, next.newton.status);
    }
    if (verdict == Verdict::reject) {
      const bool may_stop_early = !next.newton.converged() && curve.points.size() > 1;
      if (step <= (may_stop_early ? prediction.shortest : options.min_step)) {
        curve.stop = TraceStop::min_step;
        curve.first_failed = predicted;
        return curve;
      }
      step = std::max(options.min_step, 0.5 * step);
      continue;
    }
    const int iterations = next.newton.iterations();
    curve.points.push_back(std::move(next));
    if (verdict == Verdict::stop) {
      curve.stop = TraceStop::monitor;
      return curve;
    }
    if (closes) {
      curve.stop = TraceStop::closed;
      return curve;
    }
    if (iterations <= options.good_iterations) step = std::min(options.max_step, 1.5 * step);
  }
  curve.stop = TraceStop::point_limit;
  return curve;
}

}  // namespace graze
