// SPDX-License-Identifier: GPL-3.0-or-later
// BranchStep: the step from the last point of a branch to the next one, and what these two alone tell of it: that it has left the
// branch, that it has gone through the orbit of half the period, or that it has come to where the branch was before.
#pragma once

#include <graze/continuation/branch.hpp>

#include <cstddef>
#include <optional>

namespace graze {

/// From the last point of `branch` to `next`; `scale`: length by which changes of the parameter are measured.
struct BranchStep {
  const Branch& branch;
  const BranchPoint& next;
  double scale = 1.0;
  const BranchPoint& last() const { return branch.points.back(); }
};

/// The step has left the branch, or has skipped something on it, and is to be made shorter:
/// - Two multipliers through the same point within one step leave the sign of a test function as it was.
/// - Symmetric orbits are their own mirror image half their period later, x(t + nT/2) = -x(t). A regular branch of them stays
///   symmetric, and one of broken symmetry meets them in branch points alone: a step from a symmetric orbit to one that clearly
///   is not, or back, went from one branch to the other, and past the branch point, though the signs of the test functions may
///   be the same on both. (Where contacts begin or end in between, this says nothing.)
bool leaves_branch(const HybridSystem& system, const BranchStep& step);

/// A doubled branch goes through the orbit of half its period.
bool goes_through_half(const BranchStep& step);

/// A point of the branch that a step passes closely, going the way in which the branch went on from there.
struct PassedPoint {
  std::size_t point = 0;
  double part = 0.0;  ///< of the step, where it comes nearest
};
std::optional<PassedPoint> passed_again(const BranchStep& step);

/// Whether two orbits of a branch are the same one, as exactly as the corrector finds it.
bool same_states(const BranchPoint& a, const BranchPoint& b);

}  // namespace graze
