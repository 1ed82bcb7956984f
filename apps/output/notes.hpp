// SPDX-License-Identifier: GPL-3.0-or-later
// Notes: sentences that accompany a result's numbers: in its JSON as "notes", and below its text.
#pragma once

#include <graze/apps/output/result.hpp>
#include <graze/apps/problem/problem.hpp>

#include <graze/floquet/follow/sweep.hpp>
#include <graze/lib/motion/trajectory.hpp>

#include <string>
#include <vector>

namespace graze::apps {

/// Notes on simultaneous events of a motion whose order matters. `t` is counted from the start of the motion.
std::vector<std::string> order_notes(const Problem& problem, const std::vector<EventRecord>& events);

/// The same for the next `periods` of the motion from a state at forcing phase 0 (just after a return).
std::vector<std::string> order_notes(const Problem& problem, const Vector& state, int periods);

/// The same for the first row of a sweep that has such events.
std::vector<std::string> order_notes(const Problem& problem, const std::string& parameter, const std::vector<SweepRow>& rows);

/// Notes on an orbit from which a branch is followed: on its events, and if it is so small that tolerances relative to 1 + |x|
/// are coarse for it (not if it is a single point).
std::vector<std::string> branch_notes(const Problem& problem, const PeriodicOrbit& orbit);

/// Adds "notes" to the JSON and one line each to the text; nothing if there are none.
void add_notes(Result& result, const std::vector<std::string>& notes);

}  // namespace graze::apps
