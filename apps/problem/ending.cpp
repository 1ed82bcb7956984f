// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/problem/ending.hpp>

#include <graze/lib/motion/singularity.hpp>

namespace graze::apps {

std::string singularity_text(const Problem& problem, Termination reason, const Vector& state) {
  const bool sliding = reason == Termination::event_limit;
  if ((reason != Termination::integration_failed && !sliding) || !problem.written) return {};
  if (!state.allFinite() || !mode_at(problem.system, 0.0, state, problem.parameters)) return {};
  const Trajectory run = simulate_period(problem.system, problem.parameters, state);
  if (run.termination != reason) return {};
  const auto found = sliding ? find_sliding(*problem.written, run) : find_singularity(*problem.written, run, problem.parameters);
  return found ? found->what() : "";
}

std::string ending_text(const Problem& problem, Termination reason, const Vector& state) {
  const std::string singularity = singularity_text(problem, reason, state);
  return singularity.empty() ? std::string(termination_text(reason)) : singularity;
}

}  // namespace graze::apps
