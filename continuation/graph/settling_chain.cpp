// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/graph/settling_chain.hpp>

#include <graze/floquet/attractor/attractor_task.hpp>
#include <graze/floquet/orbit/returns.hpp>
#include <graze/lib/tasks/task_pool.hpp>

#include <memory>
#include <utility>

namespace graze {

MotionTask<RowChain::Found> SettlingChain::find(TaskSlot& slot, Begin begin, std::function<bool()> cancelled,
                                                std::function<void(const Vector& state)>) const {
  Found out;
  const Vector& p = parameters_[begin.number];
  AttractorOptions settling = settling_;
  settling.lyapunov.cancelled = cancelled;
  out.point.end = begin.state;
  std::vector<Vector> starts;
  if (begin.state.size() > 0) starts.push_back(begin.state);
  starts.push_back(rest_);
  for (const Vector& start : starts) {
    if (!mode_at(system_, 0.0, start, p)) continue;
    Attractor& attractor = out.point.attractor;
    attractor = co_await approach_attractor(slot, p, start, settling);
    if (attractor.termination != Termination::time) continue;
    out.point.end = attractor.state;
    if (!attractor.orbit) break;
    const StableOrbit& found = *attractor.orbit;
    PeriodicOrbit orbit = found.whole ? *found.whole : shoot(system_, p, found.states, found.period, shooting_);
    // A return lies on a guard, which may move with the parameter value.
    orbit = at_nodes(std::move(orbit));
    if (orbit.converged()) out.point.end = orbit.state;
    attractor.orbit = std::make_shared<const StableOrbit>(std::move(orbit));
    break;
  }
  out.failed = cancelled();
  co_return out;
}

}  // namespace graze
