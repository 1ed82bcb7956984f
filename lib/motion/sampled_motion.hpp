// SPDX-License-Identifier: GPL-3.0-or-later
// Motion: a run over many periods, with samples and events. It is carried period by period, so that it can be cancelled in
// between: forcing periods, or, of an autonomous system, from return to return or in stretches of a given time.
#pragma once

#include <graze/lib/motion/trajectory.hpp>

#include <functional>
#include <vector>

namespace graze {

struct Motion {
  std::vector<Vector> samples;      ///< (time, states) at equal steps; the time is 0 at the start
  std::vector<EventRecord> events;  ///< with t counted from the start
  std::vector<Vector> strobe;       ///< states at forcing phase 0 (or just after returns): the start, then after each period
  int periods = 0;                  ///< completed
  double duration = 0.0;            ///< time carried
  Vector state;                     ///< at the end; of a run that failed within a period, where it failed
  Termination termination = Termination::failed;
};

struct MotionOptions {
  int periods = 1;
  int samples = 0;       ///< per period; 0: none are taken
  double stretch = 0.0;  ///< > 0: time that replaces the return of an autonomous system as its period
  std::function<bool()> cancelled = nullptr;
  std::function<void(int periods)> progress = nullptr;
};

/// Carries the motion from `state` at forcing phase 0. @throws std::invalid_argument for an inadmissible start.
Motion run_motion(const HybridSystem& system, const Vector& parameters, const Vector& state, const MotionOptions& options);

}  // namespace graze
