// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/attractor/attractor_decision.hpp>
#include <graze/floquet/attractor/attractor_task.hpp>
#include <graze/floquet/follow/sweep_chain.hpp>
#include <graze/floquet/orbit/returns.hpp>
#include <graze/lib/motion/rest.hpp>
#include <graze/lib/tasks/task_pool.hpp>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace graze {

namespace {

/// Forcing periods of a transient after which the state is published for the next value if the row before has not settled: a
/// chaotic motion is on its attractor by then.
constexpr int handed_on_early = 64;

/// Whether an average is incomplete.
bool broken_off(LyapunovStop stop) {
  return stop == LyapunovStop::interrupted || stop == LyapunovStop::failed || stop == LyapunovStop::not_run;
}

/// Whether the motion met endless events at one instant, or a guard without speed.
bool is_on_edge(const Attractor& attractor) {
  const LyapunovSpectrum& average = attractor.time_average;
  return attractor.termination == Termination::event_limit ||
         (average.stop == LyapunovStop::failed && average.termination == Termination::grazing);
}

}  // namespace

SweepChain::SweepChain(const SharedSystem& system, Vector p, Vector start, SweepOptions options, SweepDirection direction)
    : system_(system), options_(std::move(options)), parameter_(parameter_index(system->parameters, options_.parameter)),
      p_(std::move(p)), start_(std::move(start)), values_(sweep_values(options_.from, options_.to, options_.step)) {
  if (direction == SweepDirection::down) std::reverse(values_.begin(), values_.end());
}

Vector SweepChain::parameters(std::size_t number) const {
  Vector p = p_;
  p[static_cast<Eigen::Index>(parameter_)] = values_[number];
  return p;
}

std::vector<PredictedOrbit> SweepChain::predict(std::size_t begin, std::size_t end,
                                                const std::vector<std::vector<Vector>>& before) const {
  std::vector<Vector> next;
  for (std::size_t k = begin; k < end; ++k) next.push_back(parameters(k));
  return predicted_orbits(system_, before, next, options_.attractor.lyapunov.flow);
}

/// The state of a possibly chaotic motion after this many periods; empty if it cannot be carried so far.
MotionTask<std::optional<Vector>> SweepChain::carry_on(TaskSlot& slot, const Vector& p, const Vector& state, int periods) const {
  initial_mode(system_, 0.0, state, p);
  slot.set_parameters(p);
  const CarriedPeriods carried = co_await slot.carry(state, static_cast<std::size_t>(periods));
  Vector end = state;
  if (carried.size() > 0) {
    if (carried.termination(carried.size() - 1) != Termination::time) co_return std::nullopt;
    carried.state(carried.size() - 1, end);
  }
  co_return end;
}

/// The state from which the next row starts. In a forced system it is `state`. A return lies on a guard, which may have moved
/// at the next value; the state between two returns is used instead, unless friction holds the body from the return on.
Vector SweepChain::off_guards(const Vector& p, const Vector& state) const {
  if (is_forced(system_) || held_by_friction(system_, 0.0, state, p)) return state;
  Propagator propagator(system_, p, {}, options_.attractor.lyapunov.flow);
  const std::optional<Midway> between = midway(propagator, state);
  return between ? between->state : state;
}

/// The start of a value, from the state left by the one before. A body held by friction stays held. A mass that rested on its
/// stop moves with it if the stop now comes closer.
Vector SweepChain::start_of(const Begin& begin, const Vector& p) const {
  if (begin.state.size() == 0) return start_;
  const Vector p_before = parameters(begin.number - 1);
  Vector held = begin.state;
  keep_held(system_, 0.0, p_before, p, held);
  if (mode_at(system_, 0.0, held, p)) return held;
  const FlowOptions& flow = options_.attractor.lyapunov.flow;
  Propagator before(system_, p_before, {}, flow), now(system_, p, {}, flow);
  if (permanent_rest(before, begin.state) != begin.state) return begin.state;
  return permanent_rest(now, begin.state).value_or(begin.state);
}

MotionTask<RowChain::Found> SweepChain::find(TaskSlot& slot, Begin begin, std::function<bool()> cancelled,
                                             std::function<void(const Vector& state)> publish) const {
  Found out;
  AttractorOptions finding = options_.attractor;
  finding.lyapunov.cancelled = cancelled;
  if (begin.state.size() == 0) finding.transient = options_.first_transient;
  try {
    out.point = co_await follow(slot, begin, finding, publish);
  } catch (const std::invalid_argument&) {  // the start lies inside a barrier
  }
  const Attractor& attractor = out.point.attractor;
  const bool periodic = attractor.type == AttractorType::periodic;
  const bool rests = attractor.termination == Termination::no_return;  // also a valid result
  out.revokes = periodic;
  // A cancelled value need not show it.
  out.failed = !periodic && !rests && (broken_off(attractor.time_average.stop) || cancelled());
  co_return out;
}

MotionTask<RowPoint> SweepChain::follow(TaskSlot& slot, const Begin& begin, AttractorOptions finding,
                                        const std::function<void(const Vector& state)>& publish) const {
  RowPoint out;
  const Vector p = parameters(begin.number);
  const auto cancelled = [&finding] { return finding.lyapunov.cancelled && finding.lyapunov.cancelled(); };
  bool published = false;
  const auto hand_on = [&](const Vector& state) {
    out.end = off_guards(p, state);
    published = true;
    publish(out.end);
  };
  slot.hurry(true);
  out.end = start_of(begin, p);
  Vector from = out.end;
  if (!begin.settled) {
    const int early = std::min(handed_on_early, finding.transient);
    // A motion that cannot be carried so far may have come to rest on its stop: it is published only when that is known.
    if (std::optional<Vector> end = co_await carry_on(slot, p, from, early)) {
      hand_on(*end);
      from = out.end;
      finding.transient -= early;
      slot.hurry(false);
    }
  }
  // Twice, if the motion is on an edge that rounding cannot tell, as where friction just holds: noise would move it off.
  for (const bool again : {false, true}) {
    out.attractor = co_await approach_attractor(slot, p, from, finding);
    if (begin.settled && !published && out.attractor.type != AttractorType::periodic &&
        out.attractor.termination == Termination::time)
      hand_on(out.attractor.state);
    slot.hurry(false);
    co_await average_on_attractor(slot, p, out.attractor, finding);
    if (again || !is_on_edge(out.attractor) || cancelled()) break;
    push_off(system_, p, 0, from);
  }
  if (out.attractor.termination == Termination::no_return && !published) {
    out.end = out.attractor.state;  // perturbed like noise: rest may be unstable at the next value
    push_off(system_, p, 0, out.end);
  }
  const bool periodic = out.attractor.type == AttractorType::periodic;
  if (!periodic && cancelled()) co_return out;
  if (periodic) out.end = off_guards(p, out.attractor.state);
  co_await sample_attractor(slot, p, options_.samples, out);
  co_return out;
}

MotionTask<> sample_attractor(TaskSlot& slot, const Vector& p, int samples, FollowedAttractor& at) {
  const bool periodic = at.attractor.type == AttractorType::periodic;
  if ((!periodic && samples < 1) || at.attractor.termination != Termination::time) co_return;
  if (periodic) {
    at.impact_speeds = co_await impact_speeds_of(slot, p, *at.attractor.orbit);
    at.states = at.attractor.orbit->states;
    at.attractor.orbit.reset();
    co_return;
  }
  slot.set_parameters(p);
  ImpactSpeeds speeds;
  const CarriedPeriods periods = co_await slot.carry(at.attractor.state, static_cast<std::size_t>(samples), &speeds);
  at.states = {at.attractor.state};
  append_states(periods.part(0, periods.size() - 1), 0, at.states);
  at.impact_speeds = speeds.list();
}

}  // namespace graze
