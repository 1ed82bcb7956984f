// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/orbits_ahead.hpp>
#include <graze/continuation/sweep_chain.hpp>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace graze {

namespace {

/// Forcing periods of a transient after which the motion is handed on to the next value, where the row before has not settled:
/// it is on its attractor by then, if that is chaotic.
constexpr int handed_on_early = 64;

void describe_briefly(PeriodicOrbit& orbit) {
  orbit.nodes = {};
  orbit.signature = {};
  orbit.newton.residual_history = {};
  orbit.events = {};
  orbit.monodromy = {};
}

void add_speeds(const std::vector<EventRecord>& events, std::vector<double>& speeds) {
  for (const EventRecord& event : events)
    if (begins_contact(event.kind)) speeds.push_back(event.normal_speed);
}

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

void SweepChain::look_ahead(const Before& before) {
  const std::size_t begin = block_of(before.number);
  if (begin == block_begin_) return;
  block_begin_ = begin;
  std::vector<Vector> next;
  for (std::size_t k = begin; k < std::min(begin + block, values_.size()); ++k) next.push_back(parameters(values_[k]));
  ahead_ = orbits_ahead(system_, before.orbits, next, options_.attractor.lyapunov.flow);
}

/// What is known of it after the transient, or after the part of it that comes before it is handed on. Empty where the state
/// before lies inside the barrier of this value.
std::optional<Attractor> SweepChain::attractor(const Before& before, const Vector& p) {
  look_ahead(before);
  Attractor out;
  if (const std::size_t place = before.number - block_begin_; place < ahead_.size()) {
    settle_on(out, ahead_[place]);
    return out;
  }
  AttractorOptions finding = options_.attractor;
  finding.lyapunov.cancelled = options_.cancelled;
  finding.transient = transient_of(before);
  try {
    out =
        before.settled ? approach_attractor(system_, p, before.end, finding) : handed_on(p, before.end, handed_on_after(before));
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
  return out;
}

std::optional<SweepRow> SweepChain::row(const Before& before) {
  SweepRow row;
  row.value = values_[before.number];
  row.direction = direction_;
  const Vector p = parameters(row.value);
  auto found = attractor(before, p);
  const auto cancelled = [this] { return options_.cancelled && options_.cancelled(); };
  if (!found || found->termination != Termination::time || cancelled()) return std::nullopt;
  row.attractor = std::move(*found);
  if (row.attractor.type == AttractorType::periodic) {
    AttractorOptions averaging = options_.attractor;
    averaging.lyapunov.cancelled = options_.cancelled;
    average_on_attractor(system_, p, row.attractor, averaging);
    if (row.attractor.time_average.stop == LyapunovStop::interrupted) return std::nullopt;
    sample_orbit(row);
  }
  row.end = row.attractor.state;
  return row;
}

int SweepChain::transient_of(const Before& before) const {
  return before.number == 0 ? options_.first_transient : options_.attractor.transient;
}
int SweepChain::handed_on_after(const Before& before) const { return std::min(handed_on_early, transient_of(before)); }
int SweepChain::transient_left(const Before& before) const {
  return before.settled ? 0 : transient_of(before) - handed_on_after(before);
}

/// A motion that may be chaotic after so many forcing periods.
Attractor SweepChain::handed_on(const Vector& p, const Vector& start, int periods) const {
  initial_mode(system_, 0.0, start, p);
  Attractor out;
  out.state = start;
  out.termination = Termination::time;
  Propagator propagator(system_, p, {}, options_.attractor.lyapunov.flow);
  Transition transition;
  for (int k = 0; k < periods && out.termination == Termination::time; ++k) {
    carry(propagator, 0.0, forcing_period(system_, p), out.state, {.sensitivity = Sensitivity::none}, transition);
    out.termination = transition.termination;
    out.state = transition.x1;
  }
  return out;
}

void SweepChain::sample_orbit(SweepRow& row) const {
  PeriodicOrbit& orbit = *row.attractor.orbit;
  row.states = orbit.states;
  row.impact_speeds.clear();
  const bool known = orbit.impacts == 0 || !orbit.events.empty();
  add_speeds(orbit.events, row.impact_speeds);
  describe_briefly(orbit);
  if (known) return;
  const Vector p = parameters(row.value);
  Propagator propagator(system_, p, {}, options_.attractor.lyapunov.flow);
  Transition transition;
  for (const Vector& state : orbit.states) {
    carry(propagator, 0.0, forcing_period(system_, p), state, {.sensitivity = Sensitivity::none, .keep_events = true},
          transition);
    add_speeds(transition.events, row.impact_speeds);
  }
}

void SweepChain::sample_motion(SweepRow& row) const {
  const Vector p = parameters(row.value);
  Propagator propagator(system_, p, {}, options_.attractor.lyapunov.flow);
  const double T = forcing_period(system_, p);
  Transition transition;
  Vector x = row.attractor.state;
  for (int k = 0; k < options_.samples; ++k) {
    row.states.push_back(x);
    carry(propagator, 0.0, T, x, {.sensitivity = Sensitivity::none, .keep_events = true}, transition);
    if (transition.termination != Termination::time) break;
    add_speeds(transition.events, row.impact_speeds);
    x = transition.x1;
  }
}

}  // namespace graze
