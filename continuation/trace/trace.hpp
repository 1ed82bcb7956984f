// SPDX-License-Identifier: GPL-3.0-or-later
// trace: pseudo-arclength continuation of a ZeroProblem (Keller 1977): predictor along the tangent, Newton corrector on
//     H(u) = 0,   (u - u_predicted) . W tangent = 0,
// where W holds the weights of the arclength norm. The step is halved after a failure or too sharp a turn, and enlarged after
// an easy correction. Nothing here is specific to orbits.
#pragma once

#include <graze/continuation/trace/zero_problem.hpp>
#include <graze/lib/numerics/newton.hpp>

#include <optional>
#include <vector>

namespace graze {

struct TraceOptions {
  double initial_step = 1e-2;  ///< arclength
  double min_step = 1e-9;
  double max_step = 5e-2;
  int max_points = 10000;
  int max_iterations = 8;     ///< Newton iterations of the corrector
  int good_iterations = 4;    ///< a correction with at most this many iterations enlarges the step
  double tolerance = 1e-13;   ///< of the residual, relative to ZeroProblem::size
  double acceptance = 1e-11;  ///< a residual that stalls below this is accepted
  double max_angle = 0.3;     ///< largest angle between consecutive tangents (radians); above it the step is halved
};

/// A point on the curve.
struct CurvePoint {
  Vector u;
  Vector tangent;          ///< unit in the weighted norm, oriented along the curve
  double arclength = 0.0;  ///< from the start
  NewtonReport newton;
};

enum class TraceStop { not_run, monitor, point_limit, min_step, start_failed, closed, interrupted };

/// Decision of a monitor on a new point: continue, reject it (the step is halved), or stop with it as the last point.
struct Verdict {
  enum Decision { go_on, reject, stop };

  Decision decision;
  const char* reason;  ///< of a rejection, for Curve::failure

  Verdict(Decision d, const char* why = "the point was rejected") : decision(d), reason(why) {}
  bool operator==(Decision other) const { return decision == other; }
};
using Monitor = std::function<Verdict(const CurvePoint& before, CurvePoint& after)>;

struct Curve {
  std::vector<CurvePoint> points;
  TraceStop stop = TraceStop::not_run;
  std::optional<Vector> first_failed;  ///< predicted point of the last failed correction
  std::string failure;                 ///< reason of the last failure, as text
};

/// Follows the curve through (or near) u0 in the direction of `orientation`: a vector with a positive inner product with the
/// wanted tangent, which need not be tangent itself. `monitor` may be empty. The curve counts as closed when it passes again
/// through one of its points or one of its origins. The only origin is the first point, unless `closure_points` returns others
/// for it: its images under a symmetry of the problem, or a point at which the curve began earlier. A regular curve returns to
/// its beginning first; a curve that changed over to another one at a branch point does not.
using ClosurePoints = std::function<std::vector<CurvePoint>(const CurvePoint& first)>;
Curve trace(const ZeroProblem& problem, const Vector& u0, const Vector& orientation, const TraceOptions& options = {},
            const Monitor& monitor = {}, const ClosurePoints& closure_points = {});

/// Newton's method on H(u) = 0 with (u - u_predicted) . W direction = 0, from u = u_predicted; u is changed in place.
NewtonReport correct(const ZeroProblem& problem, const Vector& direction, Vector& u, const TraceOptions& options);

/// Unit tangent of the curve at u (null vector of the Jacobian), oriented along `orientation`; empty if it cannot be formed.
Vector tangent_at(const ZeroProblem& problem, const Vector& u, const Vector& orientation);

}  // namespace graze
