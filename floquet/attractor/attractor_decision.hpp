// SPDX-License-Identifier: GPL-3.0-or-later
// Decisions after a time average: accept it, repeat it, or continue the motion.
#pragma once

#include <graze/floquet/attractor/attractor.hpp>
#include <graze/floquet/attractor/laminar_phase.hpp>

namespace graze {

/// Displaces a state, farther in each round. It moves the coordinates of a mechanical system, which are the first half of the
/// states, each by a different length, and never into a barrier.
void push_off(const HybridSystem& system, const Vector& p, int round, Vector& state);

/// Transient of the next round: a motion in a laminar phase is continued a few times, each time with a longer transient.
int longer_transient(int transient);
/// Rounds in which the fast mode also continues a motion left undecided by a short average: it may be on a long transient.
inline constexpr int rounds_for_undecided = 2;

/// Whether a motion that returns at the end of its average may be in a laminar phase. Not if it has been continued before, and
/// its average since then lasted at least 40 e-folding times: a motion that leaves an orbit at its exponent, even from a
/// rounding error away, would have gone by then. Such a motion is chaos that returns.
bool may_be_laminar(const Attractor& attractor, int round, double T);

/// Watch on the end of an average: detects whether the motion repeats itself for longer than any motion that leaves an orbit at
/// its exponent could.
LaminarPhase laminar_watch(const Attractor& attractor, int period, double T, const AttractorOptions& options);

/// Whether the watched motion must be continued, from attractor.state. If it is on an unstable orbit, the state is pushed off,
/// farther in each round. A motion that is still laminar after the last round, and was so throughout, is undecided.
bool goes_on(const LaminarPhase& watch, const HybridSystem& system, const Vector& p, int round, Attractor& attractor);

/// Evaluates the time average of a motion that is not known to be periodic and has not settled.
void evaluate_average(LyapunovSpectrum average, const AttractorOptions& options, Attractor& attractor);

/// Whether a second average must confirm that the motion is chaotic. An average that is tested often is found positive by
/// chance or for a while; if it stopped as soon as it was positive, a second one must agree.
bool needs_confirmation(const AttractorOptions& options, const Attractor& attractor);

}  // namespace graze
