// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/motion/singularity.hpp>

#include <graze/lib/equations/pieces.hpp>

#include <fmt/format.h>

#include <cmath>

namespace graze {

using namespace equations;

namespace {

/// Range of times after the end of a run to search, relative to 1 + |t|. The shortest step of a run is 1e-14, so that it stops
/// this close before a point where its field is not finite.
constexpr double shortest_glance = 1e-15, longest_glance = 1e-8;

}  // namespace

std::optional<EquationError> find_singularity(const TextSystem& text, const Trajectory& run, const Vector& p) {
  if (run.segments.empty()) return std::nullopt;
  const Segment& last = run.segments.back();
  if (!last.x0.allFinite()) {
    if (run.events.empty()) return std::nullopt;
    const EventRecord& event = run.events.back();
    const auto found = find_not_finite_reset(text, event.event, event.t, event.x_minus, p);
    return found ? std::optional(not_finite_error(text, *found, event.t, event.x_minus)) : std::nullopt;
  }
  const Vector& x = last.x1;
  const double t = last.t1;
  if (const auto found = find_not_finite(text, last.mode, t, x, p)) return not_finite_error(text, *found, t, x);
  if (const auto found = find_pole(text, last.mode, last.t0, last.x0, t, x, p, false))
    return not_finite_error(text, *found, t, x);
  Vector f(x.size());
  text.system.modes[last.mode].field(t, x, p, f);
  for (const bool adjacent : {false, true})
    for (double glance = shortest_glance; glance < longest_glance; glance *= 2.0) {
      const double ahead = glance * (1.0 + std::abs(t));
      const Vector there = x + ahead * f;
      auto found = find_not_finite(text, last.mode, t + ahead, there, p);
      if (!found) found = find_pole(text, last.mode, t, x, t + ahead, there, p, adjacent);
      if (found) return not_finite_error(text, *found, t + ahead, there);
    }
  if (const auto found = find_not_finite_derivative(text, last.mode, t, x, p)) return not_finite_error(text, *found, t, x);
  return std::nullopt;
}

std::optional<EquationError> find_sliding(const TextSystem& text, const Trajectory& run) {
  constexpr double same_instant = 1e-6;
  if (run.events.size() < 2) return std::nullopt;
  const EventRecord &before = run.events[run.events.size() - 2], &last = run.events.back();
  const Event &there = text.system.events[before.event], &back = text.system.events[last.event];
  const bool split = text.events[before.event].text == split_event && text.events[last.event].text == split_event;
  if (!split || back.continuous || back.from != there.to || back.to != there.from || last.t - before.t > same_instant)
    return std::nullopt;
  const std::string argument = back.name.substr(0, back.name.rfind(' '));  // behind it: rises or falls
  return not_finite_error(
      text,
      {text.events[last.event].when,
       fmt::format("the equations jump at {} = 0, where [[friction]] or [[surfaces]] are needed: the motion slides", argument),
       true},
      last.t, last.x_minus);
}

}  // namespace graze
