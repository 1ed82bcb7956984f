// SPDX-License-Identifier: GPL-3.0-or-later
// Trajectory: the segments of a run, a record of every event on it, and why it ended.
#pragma once

#include <graze/lib/flow/flow.hpp>
#include <graze/lib/system/saltation.hpp>
#include <graze/lib/system/termination.hpp>

#include <vector>

namespace graze {

/// One event of a run. Speeds are those of the guard: normal_speed = dh/dt just before (> 0, 0 at grazing).
struct EventRecord {
  std::size_t event = 0;  ///< index in HybridSystem::events
  EventKind kind = EventKind::other;
  double t = 0.0;
  Vector x_minus, x_plus;
  std::size_t mode_plus = 0;
  bool is_chatter = false;  ///< of kind stick: a complete chatter, at its accumulation point
  double normal_speed = 0.0;
  double mass = 1.0;  ///< Event::effective_mass at the event
  /// Speed of departure: -dh/dt along the field after a hard impact, the gap's rate at the end of a soft contact.
  double exit_speed = 0.0;
  SaltationMatrix saltation;  ///< if sensitivity was asked for
  /// The event carries the motion past a guard of the next mode, so that another event follows at the same instant, as it also
  /// does near this motion. The next saltation matrix is then that of both, and this one the identity.
  bool is_followed = false;
  bool follows = false;  ///< the event before is followed by this one
};

struct Trajectory {
  std::vector<Segment> segments;
  std::vector<EventRecord> events;
  double t = 0.0;  ///< time at the end
  Vector x;        ///< state at the end
  std::size_t mode = 0;
  Termination termination = Termination::failed;
};

/// A run ends by time or by number of events, whichever comes first.
struct Until {
  double t_end = 0.0;
  std::size_t max_events = 1000000;
};

/// Simulates from (t0, x0). @throws std::invalid_argument if the start is not admissible.
Trajectory simulate(const HybridSystem& system, const Vector& p, double t0, const Vector& x0, const Until& until,
                    const FlowOptions& options = {});

/// The same over one period: a forcing period from phase 0, or from right after a return to right after the next
/// (carry_period).
Trajectory simulate_period(const HybridSystem& system, const Vector& p, const Vector& x0, const FlowOptions& options = {});

/// States at increasing times within the run, integrated from the segments' starts. Rows (t, x), one per time; NaN for times
/// outside the run.
Matrix sample(const HybridSystem& system, const Vector& p, const Trajectory& trajectory, const std::vector<double>& times,
              const FlowOptions& options = {});

/// One passage through contact (soft), or one impact (hard).
struct Contact {
  double t_entry = 0.0, t_exit = 0.0;
  double entry_speed = 0.0, exit_speed = 0.0;  ///< speeds of approach and of departure, both >= 0
  double restitution = 0.0;                    ///< exit_speed / entry_speed, the equivalent coefficient; NaN at grazing
  double energy_lost = 0.0;                    ///< m (entry_speed^2 - exit_speed^2) / 2 with EventRecord::mass
  bool complete = false;                       ///< entry and exit both lie within the run
};

/// Whether a contact ends with the event: an impact, complete chatter, the end of a soft contact. Dry friction that stops a
/// sliding body ends none: nothing jumps there.
bool ends_contact(const EventRecord& event);

/// The contacts of a run, in order (from events of kind impact or stick, or enter followed by leave).
std::vector<Contact> contacts(const std::vector<EventRecord>& events);

/// Complete contacts of a motion with the period `duration`: those that begin within the period, and those that end within it.
struct ContactsOfCycle {
  std::vector<Contact> by_entry, by_exit;
};
ContactsOfCycle contacts_of_cycle(const std::vector<EventRecord>& events, double duration);

}  // namespace graze
