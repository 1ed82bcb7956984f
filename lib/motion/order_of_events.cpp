// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/motion/order_of_events.hpp>

#include <algorithm>
#include <cmath>
#include <optional>

namespace graze {

namespace {

/// A guard counts as met at the instant of another event if |h| is at most this, relative to 1 + |x|: a hundred times the
/// tolerance of a run.
constexpr double same_instant = 100.0 * guard_tolerance;
/// Two states are the same up to this, relative to 1 + |x|: the effect of a difference between the instants.
constexpr double same_state = 1e-8;
/// Limit of events at one instant, enough for a Newton's cradle of as many balls.
constexpr int most_events = 64;

struct Instant {
  double t = 0.0;
  Vector x;
  std::size_t mode = 0;
};

/// Whether the event belongs to the mode, and its guard is met and rising.
bool is_met(const HybridSystem& system, const Vector& p, const Instant& at, const Event& event) {
  const double h = event.guard.value(at.t, at.x, p);
  if (event.from != at.mode || std::abs(h) > same_instant * (1.0 + at.x.lpNorm<Eigen::Infinity>())) return false;
  Vector f(at.x.size());
  system.modes[at.mode].field(at.t, at.x, p, f);
  return transversality(event.guard, at.t, at.x, f, p) > same_state * (1.0 + f.lpNorm<Eigen::Infinity>());
}

void fire(const HybridSystem& system, const Vector& p, Instant& at, std::size_t index) {
  const Event* event = &system.events[index];
  while (event->otherwise && !(event->otherwise->condition(at.t, at.x, p) > 0.0)) event = &system.events[event->otherwise->event];
  const Vector before = at.x;
  if (event->reset.map) event->reset.map(at.t, before, p, at.x);
  at.mode = event->to;
}

/// For each event, whether it fires only as the alternative of another one (Alternative).
std::vector<bool> alternatives(const HybridSystem& system) {
  std::vector<bool> list(system.events.size(), false);
  for (const Event& event : system.events)
    if (event.otherwise) list[event.otherwise->event] = true;
  return list;
}

/// Whether one event is an alternative of the other, so that they share a guard.
bool share_guard(const HybridSystem& system, std::size_t a, std::size_t b) {
  const auto leads_to = [&](std::size_t from, std::size_t to) {
    while (from != to && system.events[from].otherwise) from = system.events[from].otherwise->event;
    return from == to;
  };
  return leads_to(a, b) || leads_to(b, a);
}

/// The state right after the instant if event `first` fires first, and then the events whose guards are met, in the order of
/// their declaration. Empty: `most_events` events do not complete the instant.
std::optional<Vector> behind(const HybridSystem& system, const Vector& p, Instant at, std::size_t first) {
  fire(system, p, at, first);
  for (int fired = 1; fired < most_events; ++fired) {
    const auto next = std::find_if(system.events.begin(), system.events.end(),
                                   [&](const Event& event) { return is_met(system, p, at, event); });
    if (next == system.events.end()) return at.x;
    fire(system, p, at, static_cast<std::size_t>(next - system.events.begin()));
  }
  return std::nullopt;
}

}  // namespace

std::vector<OrderedPair> noncommuting_events(const HybridSystem& system, const Vector& p,
                                             const std::vector<EventRecord>& events) {
  std::vector<OrderedPair> pairs;
  const std::vector<bool> is_alternative = alternatives(system);
  for (const EventRecord& record : events) {
    const Event& event = system.events[record.event];
    const Instant at{record.t, record.x_minus, event.from};
    for (std::size_t k = 0; k < system.events.size(); ++k) {
      const std::string& name = system.events[k].name;
      if (name == event.name || is_alternative[k] || share_guard(system, record.event, k) ||
          !is_met(system, p, at, system.events[k]))
        continue;
      const bool is_known = std::any_of(pairs.begin(), pairs.end(), [&](const OrderedPair& one) {
        const std::string &a = system.events[one.first].name, &b = system.events[one.second].name;
        return (a == event.name && b == name) || (a == name && b == event.name);
      });
      if (is_known) continue;
      const auto one = behind(system, p, at, record.event), other = behind(system, p, at, k);
      if (!one || !other || (*one - *other).lpNorm<Eigen::Infinity>() <= same_state * (1.0 + one->lpNorm<Eigen::Infinity>()))
        continue;
      pairs.push_back({record.event, k, record.t, record.x_minus, *one, *other});
    }
  }
  return pairs;
}

}  // namespace graze
