// SPDX-License-Identifier: GPL-3.0-or-later
// What the end of a branch leads to, found from the points of the branch alone (which a result file holds).
#pragma once

#include <graze/continuation/branch_follower.hpp>

namespace graze {

/// The equations of an orbit (run through `copies` times) in the parameter of `options`; `low`, `high`: its range.
OrbitProblem orbit_problem(const HybridSystem& system, const PeriodicOrbit& orbit, const ContinuationOptions& options, double low,
                           double high, int copies = 1);

/// The orbit in the middle of the two halves of the last point, which have all but met: that of half the period. Empty where
/// there is none.
std::optional<PeriodicOrbit> half_of(const HybridSystem& system, const Branch& branch, const ContinuationOptions& options);

/// The grazing at the end of the branch, from the last of its points that Newton reproduces; empty where none leads there.
std::optional<GrazingEnd> grazing_end_of(const HybridSystem& system, const Branch& branch, const ContinuationOptions& options,
                                         double low, double high);

}  // namespace graze
