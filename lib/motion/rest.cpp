// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/motion/rest.hpp>
#include <graze/lib/motion/transition.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace graze {

namespace {

/// Bounces of a period from which on the pressing acceleration is as good as constant over one: what a bounce does to the
/// action beyond that is of the square of 2 pi over their number.
constexpr std::size_t many_bounces = 64;
/// The part of the expected decrease of the action's logarithm that must be there, and by which it may be exceeded.
constexpr double decrease_tolerance = 0.5;

bool loses_energy(const Event& event, const Vector& p) {
  return !event.log_volume_change || event.log_volume_change(p) < 0.0;
}

double divergence(const HybridSystem& system, const Event& event, double t, const Vector& x, const Vector& p) {
  Matrix J(x.size(), x.size());
  system.modes[event.from].field_dx(t, x, p, J);
  return J.trace();
}

}  // namespace

const Event* holding_event(const HybridSystem& system, std::size_t mode) {
  const auto event = std::find_if(system.events.begin(), system.events.end(), [&](const Event& one) {
    return one.accumulation && one.accumulation->sticking_mode == mode;
  });
  return event == system.events.end() ? nullptr : &*event;
}

HeldMap held_map(const HybridSystem& system, const Event& holding, double t, const Vector& x, const Vector& p,
                 double duration) {
  HeldMap out{Matrix(x.size(), x.size()), -std::numeric_limits<double>::infinity()};
  if (loses_energy(holding, p)) {
    holding.accumulation->reset.dx(t, x, p, out.Phi);
    return out;
  }
  const bool position_and_speed = x.size() == 2 && holding.reset.rebound;
  const double D = position_and_speed ? divergence(system, holding, t, x, p) : std::numeric_limits<double>::quiet_NaN();
  out.log_det = D * duration;
  out.Phi.setConstant(std::isnan(D) ? D : 0.0);
  if (!position_and_speed) return out;
  out.Phi(0, 0) = std::exp(2.0 / 3.0 * out.log_det);
  out.Phi(1, 1) = std::exp(1.0 / 3.0 * out.log_det);
  return out;
}

std::optional<Vector> rest_for_ever(Propagator& propagator, const Vector& state) {
  const HybridSystem& system = propagator.system();
  const Vector& p = propagator.parameters();
  if (!system.forcing_frequency || !state.allFinite()) return std::nullopt;
  Transition transition;
  for (const Event& event : system.events) {
    if (!event.accumulation) continue;
    Vector rest = state;
    event.accumulation->reset.map(0.0, state, p, rest);
    if (mode_at(system, 0.0, rest, p) != event.accumulation->sticking_mode) continue;
    carry(propagator, 0.0, forcing_period(system, p), rest, {.sensitivity = Sensitivity::none}, transition);
    if (transition.termination == Termination::time && transition.event_sequence.empty()) return rest;
  }
  return std::nullopt;
}

bool comes_to_rest(Propagator& propagator, const Vector& state, const Vector& rest) {
  if (state == rest) return true;
  const HybridSystem& system = propagator.system();
  const Vector& p = propagator.parameters();
  Transition transition;
  carry(propagator, 0.0, forcing_period(system, p), state, {.sensitivity = Sensitivity::none, .keep_events = true}, transition);
  if (transition.termination == Termination::time && transition.x1 == rest) return true;
  const bool carried = transition.termination == Termination::time || transition.termination == Termination::event_limit;
  if (!carried || transition.events.size() < many_bounces) return false;
  const EventRecord &first = transition.events.front(), &last = transition.events.back();
  const Event& event = system.events[first.event];
  const auto same = [&](const EventRecord& one) { return one.event == first.event && one.kind == EventKind::impact; };
  if (!event.accumulation || !std::all_of(transition.events.begin(), transition.events.end(), same)) return false;
  Vector f(state.size());
  const auto log_action = [&](const EventRecord& bounce) {
    propagator.field(event.from, bounce.t, rest, f);
    return 3.0 * std::log(bounce.normal_speed) - std::log(std::abs(f[f.size() - 1]));
  };
  const double lost = event.log_volume_change ? 1.5 * event.log_volume_change(p) : 0.0;  // 3 ln k_r
  const double expected =
      lost * static_cast<double>(transition.events.size() - 1) + divergence(system, event, 0.0, rest, p) * (last.t - first.t);
  const double found = log_action(last) - log_action(first);
  return expected < 0.0 && std::abs(found - expected) < decrease_tolerance * std::abs(expected);
}

Bounces bounces_to_rest(Propagator& propagator, const Vector& rest) {
  const HybridSystem& system = propagator.system();
  const Event* holding = holding_event(system, initial_mode(system, 0.0, rest, propagator.parameters()));
  if (!holding || !holding->guard.level || rest.size() != 2) return {};
  constexpr int samples = 64;
  const double T = forcing_period(system, propagator.parameters()), sign = holding->guard.level->sign;
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  Vector f(2);
  for (int k = 0; k < samples; ++k) {
    propagator.field(holding->from, T * k / samples, rest, f);
    least = std::min(least, std::abs(f[1]));
    most = std::max(most, std::abs(f[1]));
  }
  constexpr double smallest = 1e-6;  // of the first speed
  const double first = least * T / (4.0 * static_cast<double>(many_bounces));
  for (double speed = first; speed > smallest * first; speed *= 0.5) {
    const double height = 0.5 * speed * speed / most;
    const auto small_enough = [&](double times) {
      const double y = times * times * height, v = times * speed;
      const Vector high{{rest[0] - sign * y, 0.0}}, fast{{rest[0], -sign * v}};
      const Vector back{{rest[0] - sign * 0.5 * y, sign * 0.5 * v}};
      return comes_to_rest(propagator, high, rest) && comes_to_rest(propagator, fast, rest) &&
             comes_to_rest(propagator, back, rest);
    };
    if (small_enough(1.0) && small_enough(0.5)) return {height, speed};
  }
  return {};
}

}  // namespace graze
