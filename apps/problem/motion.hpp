// SPDX-License-Identifier: GPL-3.0-or-later
// Motion: a run sampled forcing period by forcing period, so that it can be stopped in between and as long as one likes; of an
// autonomous system from return to return, or in stretches of a given time.
#pragma once

#include <graze/apps/problem/problem.hpp>

#include <graze/lib/motion/trajectory.hpp>

#include <functional>
#include <vector>

namespace graze::apps {

struct Motion {
  std::vector<Vector> samples;      ///< tau and the states at equal steps; tau = 0 at the start
  std::vector<EventRecord> events;  ///< with t counted from the start
  std::vector<Vector> strobe;       ///< states at forcing phase 0 (behind returns): the start, and after each period
  int periods = 0;                  ///< completed
  double duration = 0.0;            ///< time carried
  Termination termination = Termination::failed;
};

struct MotionOptions {
  int periods = 1;
  int samples = 0;       ///< per period; 0: none are taken
  double stretch = 0.0;  ///< > 0: of an autonomous system, the time that stands for a period instead of a return
  std::function<bool()> cancelled = nullptr;
  std::function<void(int periods)> progress = nullptr;
};

/// The motion from `state` at forcing phase 0.
Motion run_motion(const HybridSystem& system, const Vector& parameters, const Vector& state, const MotionOptions& options);

}  // namespace graze::apps
