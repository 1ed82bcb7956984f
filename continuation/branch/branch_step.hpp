// SPDX-License-Identifier: GPL-3.0-or-later
// What the step from the last point of a branch to the next one tells: that it has left the branch, or that it has gone through
// the orbit of half the period.
#pragma once

#include <graze/continuation/problems/branch_problem.hpp>
#include <graze/lib/system/symmetry.hpp>

#include <span>

namespace graze {

/// The step from the last point of `branch` to `next` has left the branch, or has skipped something on it, and is to be made
/// shorter:
/// - Two multipliers through the same point within one step leave the sign of a test function as it was.
/// - Symmetric orbits are their own mirror image, x(t) = S x(t), or half their period later, x(t) = S x(t + nT/2). A regular
///   branch of them stays symmetric, and one of broken symmetry meets them in branch points alone: a step from a symmetric orbit
///   to one that clearly is not, or back, went from one branch to the other, and past the branch point, though the signs of the
///   test functions may be the same on both. (Where contacts begin or end in between, this says nothing.)
/// `symmetries` are those that orbits of the branch may have.
bool leaves_branch(const HybridSystem& system, std::span<const Symmetry> symmetries, const Branch& branch,
                   const BranchPoint& next);

/// Where a doubled branch goes through the orbit of half its period, as a part of the way from the unknowns `before` to `after`:
/// the difference of the orbit's halves, which is continuous in the branch's own coordinates, passes zero. Empty if it does not.
std::optional<double> goes_through_half(const BranchProblem& problem, const Vector& before, const Vector& after);

}  // namespace graze
