// SPDX-License-Identifier: GPL-3.0-or-later
// Time averages over several motions on one attractor (average.hpp), which average over it sooner than one: in SIMD lanes for
// oscillators that these support, or by a Propagator a motion for any system; alone, or as a task among others.
//
// In lanes, of two directions the first is carried along, u' = Phi u / |Phi u| with growth ln|Phi u|. The growth of the second is
// ln|det Phi| minus that of the first (the same numbers as from QR).
#pragma once

#include <graze/floquet/exponents/lyapunov.hpp>
#include <graze/lib/tasks/task.hpp>

#include <memory>

namespace graze {

class LaneCarrier;
class TaskSlot;
struct MotionStart;

/// Average over LyapunovOptions::motions parallel motions until the options' rule is met: in lanes, at the carrier's first
/// parameter set, or by Propagators. Each motion beyond the first starts 1e-7 (1 + |x|) farther from the given start than the one
/// before (in lanes: from the barrier). If there are several, all are first carried for `decorrelation_periods` uncounted
/// periods, in which chaos separates them; the last of these periods also align their tangent vectors. @throws
/// std::invalid_argument as lyapunov_spectrum does.
LyapunovSpectrum lane_spectrum(LaneCarrier& many, const Vector& start, const LyapunovOptions& options);
LyapunovSpectrum frame_spectrum(const HybridSystem& system, const AverageStart& start, const LyapunovOptions& options);

/// An average taken for a task of a pool, with pauses: in lanes as lane_spectrum, or along one motion by a Propagator, as the
/// slot carries its motions.
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
  class InLanes;
  class Alone;
  std::unique_ptr<InLanes> in_lanes_;  ///< one of the two
  std::unique_ptr<Alone> alone_;
};

/// Periods in which neighbouring motions part in chaos, and the last of these, with a tangent, that align it: chaos aligns
/// tangent vectors sooner than it separates motions.
inline constexpr std::int64_t decorrelation_periods = 300, aligning_periods = 60;
/// Starts of this many neighbouring motions at a parameter set, the first at `state`.
std::vector<MotionStart> neighbouring_starts(std::size_t parameters, const Vector& state, int motions);

/// LyapunovOptions::motions for an average over possibly chaotic motion. enough_motions: for an average computed by itself, by
/// the lanes or by Propagators. motions_in_shared_lanes: for one that shares the lanes with others; these fill the lanes, so that
/// one motion is enough unless the average is long.
int enough_motions(const HybridSystem& system, const Vector& p, const LyapunovOptions& averaging);
int motions_in_shared_lanes(const LyapunovOptions& averaging);

}  // namespace graze
