// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/motion/trajectory.hpp>

#include <graze/lib/motion/propagator.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace graze {

std::string_view termination_text(Termination reason) {
  switch (reason) {
  case Termination::failed:
    break;
  case Termination::time:
    return "the end time was reached";
  case Termination::event_limit:
    return "the largest number of events in a run or at one instant was reached; with lengths, times or forces far from 1 in size, "
           "other units may help";
  case Termination::inadmissible_start:
    return "the start lies inside the barrier";
  case Termination::integration_failed:
    return "the integration could not be carried on (step size or number of steps)";
  case Termination::grazing:
    return "the motion meets a guard without speed (it grazes), where small deviations do not grow linearly; change a parameter "
           "or the "
           "start a little";
  case Termination::interrupted:
    return "it was interrupted";
  case Termination::escape:
    return "the motion grows without bound: it escapes from the softening spring (beta < 0)";
  case Termination::resonance:
    return "the motion grows without bound, by the same amount each forcing period: undamped resonance without impacts";
  case Termination::no_return:
    return "the motion does not return: none of the events that are returns follows";
  }
  return "it was not carried out";
}

namespace {

enum class Within { time, period };

Trajectory run(Propagator& propagator, HybridState state, const Until& until, Within within) {
  const FlowOptions& options = propagator.options();
  Trajectory trajectory;
  for (;;) {
    if (options.cancelled && options.cancelled()) {
      trajectory.termination = Termination::interrupted;
      break;
    }
    const StepEnd end = propagator.step(state, until.t_end);
    trajectory.segments.push_back(propagator.segment());
    if (end == StepEnd::failed) {
      trajectory.termination = propagator.failure();
      if (propagator.segment().x1.allFinite()) {
        state.t = propagator.segment().t1;
        state.x = propagator.segment().x1;
      }
      break;
    }
    if (end == StepEnd::time) {
      trajectory.termination = within == Within::time ? Termination::time : Termination::no_return;
      break;
    }
    trajectory.events.push_back(propagator.record());
    if (const auto ended = within == Within::period ? propagator.period_end(state) : std::nullopt) {
      trajectory.termination = *ended;
      break;
    }
    if (trajectory.events.size() >= until.max_events) {
      trajectory.termination = Termination::event_limit;
      break;
    }
  }
  trajectory.t = state.t;
  trajectory.x = state.x;
  trajectory.mode = state.mode;
  return trajectory;
}

}  // namespace

Trajectory simulate(const HybridSystem& system, const Vector& p, double t0, const Vector& x0, const Until& until,
                    const FlowOptions& options) {
  if (!std::isfinite(t0) || !std::isfinite(until.t_end))
    throw std::invalid_argument(fmt::format("a run from t = {} to {}; both must be finite numbers", t0, until.t_end));
  Propagator propagator(system, p, {}, options);
  return run(propagator, propagator.start(t0, x0), until, Within::time);
}

Trajectory simulate_period(const HybridSystem& system, const Vector& p, const Vector& x0, const FlowOptions& options) {
  if (is_forced(system)) return simulate(system, p, 0.0, x0, {.t_end = forcing_period(system, p)}, options);
  initial_mode(system, 0.0, x0, p);
  Propagator propagator(system, p, {}, options);
  return run(propagator, *propagator.start_period(x0), {.t_end = longest_return}, Within::period);
}

Matrix sample(const HybridSystem& system, const Vector& p, const Trajectory& trajectory, const std::vector<double>& times,
              const FlowOptions& options) {
  Matrix rows(static_cast<Eigen::Index>(times.size()), static_cast<Eigen::Index>(system.states) + 1);
  rows.setConstant(std::numeric_limits<double>::quiet_NaN());
  std::vector<Flow> flows;
  for (std::size_t mode = 0; mode < system.modes.size(); ++mode) flows.push_back(make_flow(system, mode, p, {}, options));
  std::size_t index = 0;
  Segment stretch;
  double t = 0.0;
  Vector x;
  bool started = false;
  for (std::size_t i = 0; i < times.size(); ++i) {
    while (index < trajectory.segments.size() && times[i] > trajectory.segments[index].t1) {
      ++index;
      started = false;
    }
    if (index == trajectory.segments.size()) break;
    if (times[i] < trajectory.segments.front().t0) continue;
    const Segment& segment = trajectory.segments[index];
    if (!started) {
      t = segment.t0;
      x = segment.x0;
      started = true;
    }
    if (times[i] > t && times[i] < segment.t1) {
      flows[segment.mode].carry({t, times[i], Sensitivity::none, false}, x, stretch);  // up to its end no guard is met
      t = times[i];
      x = stretch.x1;
    }
    rows(static_cast<Eigen::Index>(i), 0) = times[i];
    rows.row(static_cast<Eigen::Index>(i)).tail(x.size()) = (times[i] == segment.t1 ? segment.x1 : x).transpose();
  }
  return rows;
}

bool ends_contact(const EventRecord& event) {
  // Where friction stops a body, its velocity, which is a rounding error, becomes exactly zero.
  constexpr double jump = 1e-9;
  if (event.kind == EventKind::stick)
    return event.is_chatter ? event.x_plus != event.x_minus
                            : (event.x_plus - event.x_minus).lpNorm<Eigen::Infinity>() >
                                  jump * (1.0 + event.x_minus.lpNorm<Eigen::Infinity>());
  return event.kind == EventKind::impact || event.kind == EventKind::leave;
}

std::vector<Contact> contacts(const std::vector<EventRecord>& events) {
  std::vector<Contact> list;
  const auto finish = [](Contact& contact, double mass) {
    contact.restitution =
        contact.entry_speed > 0.0 ? contact.exit_speed / contact.entry_speed : std::numeric_limits<double>::quiet_NaN();
    contact.energy_lost = 0.5 * mass * (contact.entry_speed * contact.entry_speed - contact.exit_speed * contact.exit_speed);
    contact.complete = true;
  };
  bool open = false;
  for (const EventRecord& event : events) {
    switch (event.kind) {
    case EventKind::impact:
    case EventKind::stick: {
      if (!ends_contact(event)) break;
      Contact contact;
      contact.t_entry = contact.t_exit = event.t;
      contact.entry_speed = event.normal_speed;
      contact.exit_speed = event.exit_speed;
      finish(contact, event.mass);
      list.push_back(contact);
      break;
    }
    case EventKind::enter: {
      Contact contact;
      contact.t_entry = event.t;
      contact.entry_speed = event.normal_speed;
      contact.restitution = std::numeric_limits<double>::quiet_NaN();
      list.push_back(contact);
      open = true;
      break;
    }
    case EventKind::leave:
      if (!open) {  // the run began in contact
        Contact contact;
        contact.entry_speed = contact.restitution = contact.t_entry = std::numeric_limits<double>::quiet_NaN();
        contact.energy_lost = std::numeric_limits<double>::quiet_NaN();
        contact.t_exit = event.t;
        contact.exit_speed = event.exit_speed;
        list.push_back(contact);
        break;
      }
      list.back().t_exit = event.t;
      list.back().exit_speed = event.exit_speed;
      finish(list.back(), event.mass);
      open = false;
      break;
    case EventKind::release:
    case EventKind::other:
      break;
    }
  }
  return list;
}

ContactsOfCycle contacts_of_cycle(const std::vector<EventRecord>& events, double duration) {
  // Two periods: every contact is then complete at least once.
  std::vector<EventRecord> twice = events;
  for (EventRecord event : events) {
    event.t += duration;
    twice.push_back(std::move(event));
  }
  std::vector<Contact> complete = contacts(twice);
  std::erase_if(complete, [](const Contact& contact) { return !contact.complete; });
  const auto count = std::count_if(events.begin(), events.end(), ends_contact);
  ContactsOfCycle cycle;
  cycle.by_entry.assign(complete.begin(), complete.begin() + count);
  cycle.by_exit.assign(complete.end() - count, complete.end());
  return cycle;
}

}  // namespace graze
