// SPDX-License-Identifier: GPL-3.0-or-later
// Checks of the step from the last point of a branch to the next one: whether it left the branch, whether it passed through the
// orbit of half the period or through an equilibrium, and where it returns to the beginning.
#pragma once

#include <graze/continuation/problems/branch_problem.hpp>
#include <graze/continuation/trace/trace.hpp>
#include <graze/lib/system/symmetry.hpp>

#include <span>
#include <vector>

namespace graze {

/// True if the step from the last point of `branch` to `next` left the branch, or skipped a special point, and must be
/// shortened:
/// - Two multipliers that cross the same point of the unit circle within one step leave the sign of a test function unchanged.
/// - Symmetric orbits equal their mirror image, x(t) = S x(t), or equal it after half the period, x(t) = S x(t + nT/2). A
///   regular branch of such orbits stays symmetric; a branch of broken symmetry meets it only in branch points. A step between
///   a symmetric orbit and a clearly asymmetric one therefore changed the branch, although the test functions may have the same
///   signs at both ends. (If contacts begin or end within the step, this is no evidence.)
/// `symmetries`: those that orbits of the branch may have.
bool leaves_branch(const HybridSystem& system, std::span<const Symmetry> symmetries, const Branch& branch,
                   const BranchPoint& next);

/// The place at which a quantity that is continuous along the branch passes zero in a step, from its values `before` and `after`,
/// as a fraction of the step. A doubled branch passes through the orbit of half its period where the difference of the orbit's
/// halves is zero, and a branch of an autonomous system through an equilibrium where the field is. Empty if it does not, or if a
/// value is empty.
std::optional<double> zero_crossing(const Vector& before, const Vector& after);

/// All representations of the orbit at a point of a branch: a branch that returns to any of them is closed.
std::vector<CurvePoint> images_of(const BranchProblem& problem, const CurvePoint& point);

}  // namespace graze
