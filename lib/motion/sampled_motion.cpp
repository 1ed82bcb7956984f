// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/motion/sampled_motion.hpp>

namespace graze {

Motion run_motion(const HybridSystem& system, const Vector& parameters, const Vector& state, const MotionOptions& options) {
  Motion motion;
  const double T = is_forced(system) ? forcing_period(system, parameters) : options.stretch;
  Vector x = state;
  motion.strobe.push_back(x);
  motion.termination = Termination::time;
  std::vector<double> times(static_cast<std::size_t>(options.samples));
  for (; motion.periods < options.periods; ++motion.periods) {
    if (options.cancelled && options.cancelled()) {
      motion.termination = Termination::interrupted;
      break;
    }
    const Trajectory run = T > 0.0 ? simulate(system, parameters, 0.0, x, {.t_end = T}) : simulate_period(system, parameters, x);
    const double offset = T > 0.0 ? T * motion.periods : motion.duration;
    if (!times.empty()) {
      for (int i = 0; i < options.samples; ++i) times[static_cast<std::size_t>(i)] = (T > 0.0 ? T : run.t) * i / options.samples;
      const Matrix rows = sample(system, parameters, run, times);
      for (Eigen::Index i = 0; i < rows.rows(); ++i)
        if (rows.row(i).allFinite()) {
          motion.samples.emplace_back(rows.row(i).transpose());
          motion.samples.back()[0] += offset;
        }
    }
    for (EventRecord event : run.events) {
      event.t += offset;
      motion.events.push_back(std::move(event));
    }
    motion.duration = offset + run.t;
    x = run.x;
    motion.termination = run.termination;
    if (run.termination != Termination::time) break;
    motion.strobe.push_back(x);
    if (options.progress) options.progress(motion.periods + 1);
  }
  motion.state = x;
  if (options.samples > 0 && motion.termination != Termination::interrupted && x.allFinite()) {
    const bool completed = T > 0.0 && motion.termination == Termination::time;
    Vector last(x.size() + 1);
    last << (completed ? T * motion.periods : motion.duration), x;
    motion.samples.push_back(std::move(last));
  }
  return motion;
}

}  // namespace graze
