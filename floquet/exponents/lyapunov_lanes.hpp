// SPDX-License-Identifier: GPL-3.0-or-later
// Time averages in SIMD lanes (LaneCarrier), for oscillators that the lanes support: either over several parallel motions,
// which average over the attractor sooner, or over motions that share the lanes with those of other averages.
//
// Of two directions the first is carried along, u' = Phi u / |Phi u| with growth ln|Phi u|. The growth of the second is ln|det
// Phi| minus that of the first (the same numbers as from QR).
#pragma once

#include <graze/floquet/exponents/lyapunov.hpp>
#include <graze/lib/tasks/task.hpp>

#include <memory>

namespace graze {

class FrameAverage;
class TaskSlot;
struct MotionStart;

/// Average over LyapunovOptions::motions parallel motions until the options' rule is met. Each motion beyond the first starts
/// 1e-7 (1 + |x|) farther from the barrier than the one before. All are first carried for `parting` uncounted periods, in which
/// chaos separates them; the last of these periods also align their tangent vectors. @throws std::invalid_argument as
/// lyapunov_spectrum does, and if LaneCarrier does not apply.
LyapunovSpectrum lane_spectrum(const HybridSystem& system, const AverageStart& start, const LyapunovOptions& options);

/// An average taken for a task of a pool, with pauses: in lanes as lane_spectrum, or along one motion of any other system
/// (FrameAverage), as the slot carries its motions. The caller keeps the system and the options alive.
class RunningAverage {
 public:
  RunningAverage(const TaskSlot& lane, const HybridSystem& system, const AverageStart& start, const LyapunovOptions& options);
  RunningAverage(const RunningAverage&) = delete;
  RunningAverage& operator=(const RunningAverage&) = delete;
  ~RunningAverage();

  /// Carries the average until it ends (false) or has averaged over this many periods (true).
  MotionTask<bool> carry(TaskSlot& lane, std::int64_t periods);
  /// State of its first motion.
  const Vector& state() const;
  LyapunovSpectrum result() &&;

 private:
  class Motions;
  std::unique_ptr<Motions> in_lanes_;  ///< one of the two
  std::unique_ptr<FrameAverage> alone_;
};

inline constexpr std::int64_t decorrelation_periods = 300;
/// Starts of this many neighbouring motions at a parameter set, the first at `state`.
std::vector<MotionStart> neighbouring_starts(std::size_t parameters, const Vector& state, int motions);

}  // namespace graze
