// SPDX-License-Identifier: GPL-3.0-or-later
// Extent: the largest and the smallest value of a function of the motion over a run, and its integral.
//
// An extremum lies where a stretch between two events begins or ends, or where the rate of change vanishes. Each stretch is cut
// into panels; in a panel the motion is carried to the Chebyshev points, where value and rate are exact. A panel whose series
// do not converge is halved, so that the beginning of a contact needs no special treatment. Where the argument of abs, sign,
// max, min or step changes its sign, a panel is cut, to rounding: each part has one branch of the function, up to both of its
// ends. The integral is that of the value's series (Clenshaw and Curtis, Numer. Math. 2, 197, 1960). Where the series of the
// rate changes its sign, the motion is carried to that instant: an error of the instant changes the extremum only to second
// order.
#pragma once

#include <graze/lib/equations/motion_functions.hpp>
#include <graze/lib/motion/propagator.hpp>

#include <limits>

namespace graze {

struct Extent {
  double largest = -std::numeric_limits<double>::infinity();
  double smallest = std::numeric_limits<double>::infinity();
  double integral = 0.0;  ///< over time
};

/// The extents of the `wanted` functions over the run (one flag each), which do not depend on each other; the others are NaN. The
/// run must belong to the propagator's system and parameters. Entries are also NaN if a function has a pole on the way or is not
/// defined there, if it takes more than 20000 panels, or if the motion cannot be carried again.
std::vector<Extent> extents(Propagator& propagator, const Trajectory& run, const equations::MotionFunctions& functions,
                            const std::vector<bool>& wanted);

}  // namespace graze
