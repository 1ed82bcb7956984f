// SPDX-License-Identifier: GPL-3.0-or-later
// Time averages of many motions side by side (ManyMotions), for oscillators that the lanes know: over one motion each of many
// parameter sets, or over several motions of one, whose average is that over the attractor sooner.
//
// Of two directions the first is carried along, u' = Phi u / |Phi u| with growth ln|Phi u|; what the second grows by is
// ln|det Phi| less that (the same numbers as from QR).
#pragma once

#include <graze/floquet/lyapunov.hpp>
#include <graze/lib/lane_pool.hpp>

namespace graze {

/// A motion to be averaged over.
struct AverageStart {
  Vector p;
  Vector state;  ///< at forcing phase 0
};

/// Whether the lanes know the oscillator at all of these, of which there must be one.
bool lanes_know_each(const HybridSystem& system, const std::vector<AverageStart>& starts, const FlowOptions& flow);

/// LyapunovOptions::motions of each start, carried side by side until each has met the options' rule. Those beyond the first of
/// a start begin next to it (1e-7 (1 + |x|) further from the barrier each) and are carried for `parting` periods, not counted,
/// in which chaos parts them, and the last of which turn their tangent vectors. @throws std::invalid_argument as
/// lyapunov_spectrum does, and where ManyMotions does not apply.
std::vector<LyapunovSpectrum> lane_spectra(const HybridSystem& system, const std::vector<AverageStart>& starts,
                                           const LyapunovOptions& options);

/// The same of one start, at the parameters of its place.
LaneTask<LyapunovSpectrum> lane_spectrum(LanePlace& lane, const HybridSystem& system, const AverageStart& start,
                                         const LyapunovOptions& options);

inline constexpr std::int64_t parting = 300;

}  // namespace graze
