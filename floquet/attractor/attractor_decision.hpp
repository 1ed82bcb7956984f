// SPDX-License-Identifier: GPL-3.0-or-later
// Rounds: what is asked of a motion that has been averaged, and what is done with one that has to be followed on, be it one
// motion (attractor.cpp) or one among many in lanes (attractor_in_lanes.cpp).
#pragma once

#include <graze/floquet/attractor/attractor.hpp>
#include <graze/floquet/attractor/laminar_phase.hpp>

namespace graze {

class RefusedOrbits;

/// Moves a state aside, farther each round: the coordinates of a mechanical system, which come first among its states, by
/// different lengths, and not into a barrier.
void push_off(const HybridSystem& system, const Vector& p, int round, Vector& state);

/// A motion that lingers is followed on a few times, each with a longer transient.
int longer_transient(int transient);
/// So is, where averages are short, one that they leave undecided: it may be on a long transient.
inline constexpr int rounds_for_undecided = 2;

/// The orbit of up to max_period periods that a motion is settling on, looked for in a transient or at the end of an average;
/// `refused`: orbits that it was seen to pass by.
std::optional<PeriodicOrbit> look_for_orbit(Propagator& propagator, const Vector& state, int max_period,
                                            const AttractorOptions& options, RefusedOrbits* refused = nullptr);

/// Whether a motion that comes back at the end of its average may linger at an orbit. Where it has been followed on already, and
/// its average since was so long that what leaves an orbit at its exponent, from a distance as small as rounding, was gone (40
/// times the time in which that grows e-fold), it is chaos that comes back.
bool may_linger(const Attractor& attractor, int round, double T);

/// A watch on the end of an average: whether its motion stays longer than any that leaves an orbit at its exponent would.
LaminarPhase watch_end(const Attractor& attractor, int period, double T, const AttractorOptions& options);

/// Whether the motion that was watched has to be followed on, from attractor.state: off an unstable orbit that it is on, farther
/// each round. Where it lingers after the last of them, and always has, it is undecided.
bool goes_on(const LaminarPhase& watch, const HybridSystem& system, const Vector& p, int round, Attractor& attractor);

/// LyapunovOptions::motions of an average over what may be chaotic: where it is taken by itself, and where others are taken
/// beside it, which fill the lanes unless it is long.
int motions_in_chaos(const LyapunovOptions& averaging);
int motions_in_company(const LyapunovOptions& averaging);

/// What the time average over a motion that was not known to be periodic says, if it has not settled.
void take_average(LyapunovSpectrum average, const AttractorOptions& options, Attractor& attractor);

/// Many looks at an average find it positive by chance, or for a while: where one stopped as soon as it was, another has to say
/// the same.
bool wants_confirmation(const AttractorOptions& options, const Attractor& attractor);

}  // namespace graze
