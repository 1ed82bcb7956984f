// SPDX-License-Identifier: GPL-3.0-or-later
// Time averages in SIMD lanes (LaneCarrier), for oscillators that they know: over several motions side by side, whose average is
// that over the attractor sooner, or over motions that share the lanes with those of other averages.
//
// Of two directions the first is carried along, u' = Phi u / |Phi u| with growth ln|Phi u|; what the second grows by is
// ln|det Phi| less that (the same numbers as from QR).
#pragma once

#include <graze/floquet/exponents/lyapunov.hpp>
#include <graze/lib/tasks/task.hpp>

#include <memory>

namespace graze {

class TaskSlot;
struct MotionStart;

/// Over LyapunovOptions::motions, side by side until they have met the options' rule. Those beyond the first begin next to it
/// (1e-7 (1 + |x|) further from the barrier each) and are carried for `parting` periods, not counted, in which chaos parts them,
/// and the last of which turn their tangent vectors. @throws std::invalid_argument as lyapunov_spectrum does, and where
/// LaneCarrier does not apply.
LyapunovSpectrum lane_spectrum(const HybridSystem& system, const AverageStart& start, const LyapunovOptions& options);

/// The same at a place in a pool, with stops on the way. (Keep the options alive.)
class LaneAverage {
 public:
  LaneAverage(const TaskSlot& lane, const HybridSystem& system, const AverageStart& start, const LyapunovOptions& options);
  LaneAverage(const LaneAverage&) = delete;
  LaneAverage& operator=(const LaneAverage&) = delete;
  ~LaneAverage();

  /// Until it ends (false), or has averaged over so many periods (true).
  MotionTask<bool> carry(TaskSlot& lane, std::int64_t periods);
  /// Where its first motion is.
  const Vector& state() const;
  LyapunovSpectrum result() &&;

 private:
  class Motions;
  std::unique_ptr<Motions> motions_;
};

inline constexpr std::int64_t parting = 300;
/// So many motions next to each other, at a parameter set, the first at `state`.
std::vector<MotionStart> next_to_each_other(std::size_t parameters, const Vector& state, int motions);

}  // namespace graze
