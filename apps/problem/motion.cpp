// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/problem/motion.hpp>

namespace graze::apps {

Motion run_motion(const HybridSystem& system, const Vector& parameters, const Vector& state, const MotionOptions& options) {
  Motion motion;
  const double T = forcing_period(system, parameters);
  Vector x = state;
  motion.strobe.push_back(x);
  motion.termination = Termination::time;
  std::vector<double> times(static_cast<std::size_t>(options.samples));
  for (int i = 0; i < options.samples; ++i) times[static_cast<std::size_t>(i)] = T * i / options.samples;
  for (; motion.periods < options.periods; ++motion.periods) {
    if (options.cancelled && options.cancelled()) {
      motion.termination = Termination::interrupted;
      break;
    }
    const Trajectory run = simulate(system, parameters, 0.0, x, {.t_end = T});
    const double offset = T * motion.periods;
    if (!times.empty()) {
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
    x = run.x;
    motion.termination = run.termination;
    if (run.termination != Termination::time) break;
    motion.strobe.push_back(x);
    if (options.progress) options.progress(motion.periods + 1);
  }
  if (options.samples > 0 && motion.termination == Termination::time) {
    Vector last(x.size() + 1);
    last << T * motion.periods, x;
    motion.samples.push_back(std::move(last));
  }
  return motion;
}

}  // namespace graze::apps
