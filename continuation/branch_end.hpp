// SPDX-License-Identifier: GPL-3.0-or-later
// What the end of a branch leads to, found from the points of the branch alone (which a result file holds).
#pragma once

#include <graze/continuation/branch_follower.hpp>
#include <graze/continuation/grazing_edge.hpp>

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

/// Changes the scenario of the grazing at the end of the branch, in its details and in the branch's message.
void set_scenario(Branch& branch, const std::function<void(SpecialPoint&)>& change);

/// Nothing begins there, for that reason.
void set_scenario_none(Branch& branch, const std::string& reason);

}  // namespace graze
