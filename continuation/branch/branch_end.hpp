// SPDX-License-Identifier: GPL-3.0-or-later
// What the end of a branch leads to, found from the points of the branch alone (which a result file holds).
#pragma once

#include <graze/continuation/branch/branch_follower.hpp>
#include <graze/continuation/branch/branch_switching.hpp>
#include <graze/continuation/branch/branch_task.hpp>
#include <graze/continuation/conditions/grazing_edge.hpp>

#include <functional>

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

/// Whether `child`, born on the grazing at the end of `ended`, is the orbits beyond it with one impact more or less, and not one
/// of the families of several times their period.
bool is_partner(const Branch& child, const Branch& ended);

/// The edge at which the branch, born on the grazing `point`, begins.
GrazingEdge first_edge(const SpecialPoint& point, const Branch& branch);

/// Of the known ends of families the one on the other side of the grazing `point`, on which branch `index` ended; null if there
/// is none.
const KnownEdge* edge_beyond(const std::vector<KnownEdge>& edges, std::size_t index, const SpecialPoint& point, GrazingEnd end);

/// Changes the scenario of the grazing at the end of the branch, in its details and in the branch's message.
void set_scenario(Branch& branch, const std::function<void(SpecialPoint&)>& change);

/// No family was found to begin there, for that reason: there is `none`, or else the scenario is that of the linear response
/// alone, "undecided" where that says nothing.
void set_scenario_alone(Branch& branch, const std::string& reason, bool none);

}  // namespace graze
