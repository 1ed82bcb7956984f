// SPDX-License-Identifier: GPL-3.0-or-later
// trace: pseudo-arclength continuation of a ZeroProblem (Keller 1977): predictor along the tangent, Newton corrector on
//     H(u) = 0,   (u - u_predicted) . W tangent = 0,
// with the step halved on failure or too sharp a turn and enlarged after easy steps. It knows nothing of orbits.
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
  int max_iterations = 8;     ///< of the corrector
  int good_iterations = 4;    ///< a corrector that needs no more enlarges the step
  double tolerance = 1e-13;   ///< of the residual (as the problem scales it)
  double acceptance = 1e-11;  ///< a residual that stalls below this is accepted
  double max_angle = 0.3;     ///< radians between consecutive tangents, where the step is halved above it
};

/// A point on the curve.
struct CurvePoint {
  Vector u;
  Vector tangent;          ///< unit in the weighted norm, oriented along the curve
  double arclength = 0.0;  ///< from the start
  NewtonReport newton;
};

enum class TraceStop { not_run, monitor, point_limit, min_step, start_failed, closed, interrupted };

/// What a monitor says of a new point: go on, reject it (the step is halved), or stop with it as the last one.
enum class Verdict { go_on, reject, stop };
using Monitor = std::function<Verdict(const CurvePoint& before, CurvePoint& after)>;

struct Curve {
  std::vector<CurvePoint> points;
  TraceStop stop = TraceStop::not_run;
  std::optional<Vector> first_failed;  ///< the predicted point at which the corrector failed last
  std::string failure;                 ///< why, in words
};

/// Follows the curve through (near) u0 in the direction of `orientation` (a vector whose inner product with the tangent is to be
/// positive; it need not be tangent). `monitor` may be empty. The curve is closed when it passes again through one of its points,
/// or through one of its origins: its first point, or if `origins_of` is given what that makes of the first point (all that is
/// the same by a symmetry of the problem, or where the curve began earlier). A regular curve that comes back to itself does so at
/// its beginning first; one that has gone over to another one at a branch point does not.
using OriginsOf = std::function<std::vector<CurvePoint>(const CurvePoint& first)>;
Curve trace(const ZeroProblem& problem, const Vector& u0, const Vector& orientation, const TraceOptions& options = {},
            const Monitor& monitor = {}, const OriginsOf& origins_of = {});

/// Newton on H(u) = 0 with (u - u_predicted) . W direction = 0; u is changed in place.
NewtonReport correct(const ZeroProblem& problem, const Vector& direction, Vector& u, const TraceOptions& options);

/// Unit tangent of the curve at u (null vector of the Jacobian), oriented along `orientation`; empty if it cannot be formed.
Vector tangent_at(const ZeroProblem& problem, const Vector& u, const Vector& orientation);

}  // namespace graze
