// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/models/soft.hpp>

#include <graze/lib/models/oscillator.hpp>

namespace graze {

void attach_soft_contact(HybridSystem& system, Mode contact) {
  static constexpr std::size_t free = 0, in_contact = 1;
  contact.name = "contact";
  system.modes.push_back(std::move(contact));
  Event enter;
  enter.name = "enter";
  enter.from = free;
  enter.to = in_contact;
  enter.kind = EventKind::enter;
  enter.continuous = true;
  enter.guard = make_level_guard({.coordinate = 0, .level = oscillator_parameter::r, .sign = 1.0});
  Event leave = enter;
  leave.name = "leave";
  leave.from = in_contact;
  leave.to = free;
  leave.kind = EventKind::leave;
  leave.guard = make_level_guard({.coordinate = 0, .level = oscillator_parameter::r, .sign = -1.0});
  system.events.push_back(std::move(enter));
  system.events.push_back(std::move(leave));
  system.initial_mode = [](double t, const Vector& x, const Vector& p) -> std::optional<std::size_t> {
    const double gap = x[0] - p[oscillator_parameter::r];
    if (gap != 0.0) return gap > 0.0 ? in_contact : free;
    if (x[1] != 0.0) return x[1] > 0.0 ? in_contact : free;
    return barrier_acceleration(t, p) > 0.0 ? in_contact : free;
  };
}

}  // namespace graze
