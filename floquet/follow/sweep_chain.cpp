// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/attractor/attractor.hpp>
#include <graze/floquet/attractor/attractor_decision.hpp>
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

}  // namespace

SweepChain::SweepChain(const HybridSystem& system, const Vector& p, const Vector& start, const SweepOptions& options,
                       SweepDirection direction)
    : system_(system), options_(options), parameter_(parameter_index(system.parameters, options.parameter)), p_(p), start_(start),
      direction_(direction), values_(sweep_values(options.from, options.to, options.step)) {
  if (direction == SweepDirection::down) std::reverse(values_.begin(), values_.end());
}

Vector SweepChain::parameters(double value) const {
  Vector p = p_;
  p[static_cast<Eigen::Index>(parameter_)] = value;
  return p;
}

bool SweepChain::alike(const SweepRow& before, const SweepRow& row) {
  const Attractor &a = before.attractor, &b = row.attractor;
  return a.type == AttractorType::periodic && b.type == AttractorType::periodic && a.period == b.period &&
         a.impacts == b.impacts && before.states.size() == row.states.size();
}

SweepRow SweepChain::row(std::size_t number) const {
  SweepRow row;
  row.value = values_[number];
  row.direction = direction_;
  return row;
}

SweepChain::Block SweepChain::look_ahead(std::size_t number, const std::vector<std::vector<Vector>>& before) const {
  Block ahead{block_of(number), {}};
  std::vector<Vector> next;
  for (std::size_t k = ahead.begin; k < std::min(ahead.begin + block, values_.size()); ++k)
    next.push_back(parameters(values_[k]));
  ahead.orbits = predicted_orbits(system_, before, next, options_.attractor.lyapunov.flow);
  return ahead;
}

std::optional<SweepRow> SweepChain::known(Block& ahead, std::size_t number) const {
  const std::size_t place = number - block_of(number);
  if (block_of(number) != ahead.begin || place >= ahead.orbits.size()) return std::nullopt;
  SweepRow out = row(number);
  PredictedOrbit& found = ahead.orbits[place];
  describe_orbit(out.attractor, found.orbit);
  out.end = out.attractor.state;
  out.states = std::move(found.orbit.states);
  out.impact_speeds = std::move(found.impact_speeds);
  return out;
}

/// The state of a possibly chaotic motion after this many periods; empty if it cannot be carried so far.
MotionTask<std::optional<Vector>> SweepChain::carry_on(TaskSlot& lane, const Vector& p, const Vector& state, int periods) const {
  initial_mode(system_, 0.0, state, p);
  lane.set_parameters(p);
  const CarriedPeriods carried = co_await lane.carry(state, static_cast<std::size_t>(periods));
  Vector end = state;
  if (carried.size() > 0) {
    if (carried.termination(carried.size() - 1) != Termination::time) co_return std::nullopt;
    carried.state(carried.size() - 1, end);
  }
  co_return end;
}

/// The state from which the next row starts. In a forced system it is `state`. A return lies on a guard, which may have moved
/// at the next value; the state between two returns is used instead.
Vector SweepChain::off_guards(const Vector& p, const Vector& state) const {
  if (is_forced(system_)) return state;
  Propagator propagator(system_, p, {}, options_.attractor.lyapunov.flow);
  const std::optional<Midway> between = midway(propagator, state);
  return between ? between->state : state;
}

/// The start of a row, from the state left by the row before. A mass that rested on its stop moves with it if the stop now
/// comes closer.
Vector SweepChain::with_its_stop(const Begin& begin, const Vector& p) const {
  if (mode_at(system_, 0.0, begin.state, p)) return begin.state;
  const FlowOptions& flow = options_.attractor.lyapunov.flow;
  Propagator before(system_, parameters(values_[begin.number - 1]), {}, flow), now(system_, p, {}, flow);
  if (permanent_rest(before, begin.state) != begin.state) return begin.state;
  return permanent_rest(now, begin.state).value_or(begin.state);
}

MotionTask<SweepRow> SweepChain::find(TaskSlot& lane, Begin begin, AttractorOptions finding,
                                      std::function<void(const Vector& state)> publish) const {
  SweepRow out = row(begin.number);
  const Vector p = parameters(out.value);
  if (!begin.at_start) begin.state = with_its_stop(begin, p);
  if (begin.at_start) finding.transient = options_.first_transient;
  const auto cancelled = [&finding] { return finding.lyapunov.cancelled && finding.lyapunov.cancelled(); };
  lane.hurry(true);
  out.end = begin.state;
  if (!begin.settled) {
    const int early = std::min(handed_on_early, finding.transient);
    // A motion that cannot be carried so far may have come to rest on its stop: it is published only when that is known.
    if (std::optional<Vector> end = co_await carry_on(lane, p, begin.state, early)) {
      out.end = off_guards(p, *end);
      finding.transient -= early;
      publish(out.end);
      lane.hurry(false);
    }
  }
  const Vector from = out.end;
  out.attractor = co_await approach_attractor(lane, system_, p, from, finding);
  if (begin.settled && out.attractor.type != AttractorType::periodic && out.attractor.termination == Termination::time) {
    out.end = off_guards(p, out.attractor.state);
    publish(out.end);
  }
  lane.hurry(false);
  co_await average_on_attractor(lane, system_, p, out.attractor, finding);
  if (out.attractor.termination == Termination::no_return) {  // perturbed like noise: rest may be unstable at the next value
    out.end = out.attractor.state;
    push_off(system_, p, 0, out.end);
  }
  if (out.attractor.type == AttractorType::periodic || !cancelled()) co_await sample(lane, p, out);
  co_return out;
}

/// Records the states and impact speeds of a row.
MotionTask<> SweepChain::sample(TaskSlot& lane, const Vector& p, SweepRow& row) const {
  const bool periodic = row.attractor.type == AttractorType::periodic;
  const int wanted = periodic ? row.attractor.period : options_.samples;
  if (wanted < 1 || row.attractor.termination != Termination::time) co_return;
  const PeriodicOrbit* const whole = periodic ? row.attractor.orbit->whole.get() : nullptr;
  if (whole) {
    for (const EventRecord& event : whole->events)
      if (begins_contact(event.kind)) row.impact_speeds.push_back(event.normal_speed);
  } else if (!periodic || row.attractor.impacts > 0) {
    lane.set_parameters(p);
    ImpactSpeeds speeds;
    Vector state = row.attractor.state;
    const Vector from = state;
    const CarriedPeriods periods = co_await lane.carry(from, static_cast<std::size_t>(wanted), &speeds);
    row.states = {from};
    for (std::size_t k = 0; k + 1 < periods.size() && periods.termination(k) == Termination::time; ++k) {
      periods.state(k, state);
      row.states.push_back(state);
    }
    row.impact_speeds = speeds.list();
  }
  if (!periodic) co_return;
  row.end = off_guards(p, row.attractor.state);
  row.states = row.attractor.orbit->states;
  row.attractor.orbit.reset();
}

}  // namespace graze
