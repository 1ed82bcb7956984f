// SPDX-License-Identifier: GPL-3.0-or-later
// Continuation beyond the end of a branch: orbit of half the period, grazing, partner family. Computed from the points of the
// branch alone, which a result file holds.
#pragma once

#include <graze/continuation/branch/branch_record.hpp>
#include <graze/continuation/branch/branch_task.hpp>
#include <graze/continuation/conditions/grazing_families.hpp>

#include <functional>

namespace graze {

/// The equations of an orbit traversed `copies` times, in the parameter of `options` with the range `low` ... `high`.
OrbitProblem orbit_problem(const SharedSystem& system, const PeriodicOrbit& orbit, const ContinuationOptions& options, double low,
                           double high, int copies = 1);

/// The orbit of half the period on which a doubled branch ends: Newton's method from the mean of the two halves of the last
/// point, which nearly coincide. Empty if there is none.
std::optional<PeriodicOrbit> half_period_orbit(const HybridSystem& system, const Branch& branch,
                                               const ContinuationOptions& options);

/// Whether a stop, friction or a surface holds something in this mode.
inline bool holds_something(const HybridSystem& system, std::size_t mode) { return !system.modes[mode].constraints.empty(); }

/// Whether something is held all along the last orbit of the branch, and the motion from there is released at this value of the
/// parameter.
bool releases_beyond(const HybridSystem& system, const Branch& branch, double value);

/// The grazing at the end of the branch, located again from the last of its points that Newton's method reproduces. Empty if
/// none of them leads there.
std::optional<GrazingEnd> relocate_grazing_end(const HybridSystem& system, const Branch& branch,
                                               const ContinuationOptions& options, double low, double high);

/// True if `child`, born on the grazing at the end of `ended`, is the family beyond it with one impact more or less, and not a
/// family of a multiple of the period.
bool is_partner(const Branch& child, const Branch& ended);

/// The edge at which the branch, born on the grazing `point`, begins.
GrazingEdge first_edge(const SpecialPoint& point, const Branch& branch);

/// The known edge of the family on the other side of the grazing `point`, on which branch `index` ended; null if unknown. `unit`:
/// of the parameter (parameter_unit).
const KnownEdge* partner_edge_among(const std::vector<KnownEdge>& edges, std::size_t index, const SpecialPoint& point,
                                    GrazingEnd end, double unit);

/// Changes the scenario of the grazing at the end of the branch, both in its details and in the message of the branch.
void set_scenario(Branch& branch, const std::function<void(SpecialPoint&)>& change);

/// Records, with the reason, that no family was found to begin at the grazing. With `none` the scenario becomes "none";
/// otherwise it is that of the linear response alone, or "undecided" if the response does not decide.
void set_scenario_without_partner(Branch& branch, const std::string& reason, bool none);

}  // namespace graze
