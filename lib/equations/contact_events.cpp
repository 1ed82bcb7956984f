// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/contact_events.hpp>

#include <graze/lib/equations/constraints.hpp>

#include <string>

namespace graze::equations {

namespace {

std::vector<int> changed(std::vector<int> status, std::size_t c, int to) {
  status[c] = to;
  return status;
}

/// A change of the contacts' states by an event.
struct Change {
  std::string suffix;  ///< of the event's name, behind that of the contact
  EventKind kind;
  Expression guard;
  std::vector<int> to;    ///< the states behind the event
  bool may_rest = false;  ///< the guard may be constant along the motion
};

/// Adds the event of contact `c` from `at`, with the guard in terms of that mode; nullptr: the guard is constant along the
/// motion, or there is no target mode. The result is valid until the next event is added.
EventPiece* add_event(const Coordinates& coordinates, const ContactModes& modes, const Combination& at, std::size_t c,
                      const Change& change, std::vector<EventPiece>& events) {
  Graph& graph = coordinates.graph;
  const Contact& contact = modes.contacts[c];
  const Expression here = graph.substitute(change.guard, at.replacement);
  const Combination* target = modes.find(change.to);
  if (!target || (!change.may_rest && !dependence(graph, here).moves())) return nullptr;
  EventPiece event;
  event.name = contact.name.text + change.suffix;
  event.text = made_event;
  event.kind = change.kind;
  if (begins_contact(change.kind) || change.kind == EventKind::stick) event.count = contact.count;
  event.from = at.mode;
  event.to = target->mode;
  event.guard = here;
  event.decided = true;
  for (std::size_t i = 0; i < 2 * coordinates.n; ++i) event.map.push_back(graph.state(i));
  event.when = contact.where;
  event.reset = contact.law;
  events.push_back(std::move(event));
  return &events.back();
}

std::optional<Expression> mass_of(const Coordinates& coordinates, const Contact& contact) {
  Graph& graph = coordinates.graph;
  const Expression mass = coordinates.tidy(graph.divide(graph.constant(1.0), contact.compliance));
  return graph.is_constant(mass, 1.0) ? std::nullopt : std::optional(mass);
}

/// Adds the accumulation of an impact. Between the impacts of a series, the stops that were closed before are closed again
/// and carry the load.
void add_accumulation(const Coordinates& coordinates, const ContactModes& modes, EventPiece& event, const Combination& before,
                      const Combination& behind, std::size_t c) {
  Graph& graph = coordinates.graph;
  const std::size_t n = coordinates.n;
  const Contact& stop = modes.contacts[c];
  const Combination* between = &behind;
  std::vector<int> status = behind.status;
  for (std::size_t other = 0; other < modes.contacts.size(); ++other)
    if (modes.contacts[other].is_stop) status[other] = before.status[other];
  if (modes.find(status) && modes.find(changed(status, c, closed))) between = modes.find(status);
  const Combination* held = modes.find(changed(between->status, c, closed));
  if (!held) return;
  AccumulationPiece out;
  out.sticking_mode = held->mode;
  for (std::size_t i = 0; i < n; ++i)
    out.map.push_back(graph.subtract(coordinates.q(i), graph.multiply(stop.share[i], stop.gap)));
  for (std::size_t i = 0; i < n; ++i)
    out.map.push_back(graph.subtract(coordinates.v(i), graph.multiply(stop.share[i], stop.rate)));
  Replacement projected;
  for (std::size_t i = 0; i < 2 * n; ++i) projected.emplace(graph.state(i).index, out.map[i]);
  for (const Solution& one : held->solved) out.map[one.state] = graph.substitute(one.value, projected);
  out.pressing = graph.negate(
      graph.substitute(rate_along(graph, stop.rate, coordinates.field_of(between->acceleration)), between->replacement));
  event.accumulation = std::move(out);
}

void strike(const Coordinates& coordinates, const ContactModes& modes, const Combination& at, std::size_t c,
            std::vector<EventPiece>& events) {
  Graph& graph = coordinates.graph;
  const std::size_t n = coordinates.n;
  const Contact& stop = modes.contacts[c];
  Column map;
  for (std::size_t i = 0; i < n; ++i) map.push_back(coordinates.q(i));
  const Expression jump = graph.multiply(graph.add(graph.constant(1.0), stop.restitution), stop.rate);
  for (std::size_t i = 0; i < n; ++i) map.push_back(graph.subtract(coordinates.v(i), graph.multiply(stop.share[i], jump)));
  for (std::size_t i = 0; i < 2 * n; ++i) {
    // A state that a constraint determines and the impulse does not change stays unchanged.
    if (map[i] != graph.state(i)) map[i] = graph.substitute(map[i], at.replacement);
  }
  // Contacts that the impulse reaches through M: closed rigid stops open; friction continues with the sign of its speed.
  std::vector<int> to = at.status;
  std::vector<std::size_t> slipping;
  for (std::size_t other = 0; other < modes.contacts.size(); ++other) {
    const Contact& reached = modes.contacts[other];
    if (other == c || coordinates.vanishes(coordinates.dot(reached.direction, stop.response))) continue;
    if (reached.is_stop && reached.rigid) to[other] = open;
    if (!reached.is_stop) slipping.push_back(other);
  }
  Replacement after;
  for (std::size_t i = 0; i < map.size(); ++i) after.emplace(graph.state(i).index, map[i]);
  const std::size_t choices = std::size_t{1} << slipping.size();
  for (std::size_t choice = 0; choice < choices; ++choice) {
    // The first choice fires in which all bodies that slip forward have a positive speed. Those that slip backward then have
    // none.
    std::vector<Expression> conditions;
    for (std::size_t k = 0; k < slipping.size(); ++k) {
      const bool goes_backward = (choice >> k & 1U) != 0;
      to[slipping[k]] = goes_backward ? backward : forward;
      if (!goes_backward) conditions.push_back(graph.substitute(modes.contacts[slipping[k]].rate, after));
    }
    EventPiece* event = add_event(coordinates, modes, at, c, {"", EventKind::impact, graph.negate(stop.gap), to}, events);
    if (!event) return;
    event->map = map;
    event->effective_mass = mass_of(coordinates, stop);
    // The guard is written in the states that the mode leaves free. Behind the impact they may move apart from the gap.
    if (!at.solved.empty()) event->opening_rate = stop.rate;
    if (!dependence(graph, stop.restitution).moves()) event->restitution = stop.restitution;
    if (choice + 1 < choices) event->otherwise = AlternativePiece{conditions, events.size()};
    add_accumulation(coordinates, modes, *event, at, *modes.find(to), c);
  }
}

void release(const Coordinates& coordinates, const ContactModes& modes, const Combination& at, std::size_t c,
             std::vector<EventPiece>& events) {
  Graph& graph = coordinates.graph;
  const Contact& stop = modes.contacts[c];
  const auto to = changed(at.status, c, open);
  const Combination* free = modes.find(to);
  if (!free) return;
  const Expression opening = rate_along(graph, stop.rate, coordinates.field_of(free->acceleration));
  // Rounding moves a body off a moving stop: without this reset it would hit the stop at once.
  const auto stay_at_stop = [&](EventPiece& event) {
    for (const Solution& one : at.solved)
      if (dependence(graph, one.value).time) event.map[one.state] = one.value;
  };
  // Friction of a body that its stop holds at rest keeps the direction in which it came. At the release it holds the body if it
  // can.
  for (std::size_t other = 0; other < modes.contacts.size(); ++other) {
    const Contact& friction = modes.contacts[other];
    if (friction.is_stop || at.status[other] == stuck || !coordinates.vanishes(graph.substitute(friction.rate, at.replacement)))
      continue;
    const Combination* held = modes.find(changed(to, other, stuck));
    EventPiece* event =
        held ? add_event(coordinates, modes, at, c, {" release", EventKind::release, opening, held->status, true}, events)
             : nullptr;
    if (!event) continue;
    stay_at_stop(*event);
    const Expression needed = graph.substitute(held->multiplier_of(other), held->replacement);
    event->otherwise =
        AlternativePiece{{graph.subtract(friction.limit, needed), graph.add(friction.limit, needed)}, events.size()};
  }
  // At release the contact force is zero: state and field are continuous.
  EventPiece* event = add_event(coordinates, modes, at, c, {" release", EventKind::release, opening, to, true}, events);
  if (!event) return;
  event->continuous = true;
  stay_at_stop(*event);
}

void lose_speed(const Coordinates& coordinates, const ContactModes& modes, const Combination& at, std::size_t c,
                std::vector<EventPiece>& events) {
  Graph& graph = coordinates.graph;
  const Contact& friction = modes.contacts[c];
  const bool goes_forward = at.status[c] == forward;
  const Expression guard = goes_forward ? graph.negate(friction.rate) : friction.rate;
  const auto sticks = changed(at.status, c, stuck);
  if (const Combination* held = modes.find(sticks)) {
    if (EventPiece* event = add_event(coordinates, modes, at, c, {" stick", EventKind::stick, guard, sticks}, events)) {
      for (const Solution& one : held->solved) event->map[one.state] = one.value;
      const Expression needed = held->multiplier_of(c);
      event->otherwise =
          AlternativePiece{{goes_forward ? graph.subtract(friction.limit, graph.substitute(needed, held->replacement))
                                         : graph.add(friction.limit, graph.substitute(needed, held->replacement))},
                           events.size()};
    }
  }
  add_event(coordinates, modes, at, c,
            {" reversal", EventKind::other, guard, changed(at.status, c, goes_forward ? backward : forward)}, events);
}

void leave_sticking(const Coordinates& coordinates, const ContactModes& modes, const Combination& at, std::size_t c,
                    std::vector<EventPiece>& events) {
  Graph& graph = coordinates.graph;
  const Contact& friction = modes.contacts[c];
  const Expression needed = at.multiplier_of(c);
  for (const int to : {backward, forward}) {
    const Expression guard = graph.subtract(to == backward ? needed : graph.negate(needed), friction.limit);
    const std::string suffix = to == backward ? " slip backward" : " slip forward";
    if (EventPiece* event =
            add_event(coordinates, modes, at, c, {suffix, EventKind::release, guard, changed(at.status, c, to), true}, events))
      event->continuous = friction.same_limit;
  }
}

}  // namespace

void add_contact_events(const Coordinates& coordinates, const ContactModes& modes, const Combination& at, std::size_t c,
                        std::vector<EventPiece>& events) {
  Graph& graph = coordinates.graph;
  const Contact& contact = modes.contacts[c];
  const int status = at.status[c];
  if (!contact.is_stop) {
    status == stuck ? leave_sticking(coordinates, modes, at, c, events) : lose_speed(coordinates, modes, at, c, events);
  } else if (contact.rigid) {
    status == open ? strike(coordinates, modes, at, c, events) : release(coordinates, modes, at, c, events);
  } else if (status == open) {
    EventPiece* event = add_event(coordinates, modes, at, c,
                                  {" enter", EventKind::enter, graph.negate(contact.gap), changed(at.status, c, closed)}, events);
    if (!event) return;
    event->effective_mass = mass_of(coordinates, contact);
    event->continuous = contact.begins_softly;
  } else if (status == closed && contact.states == 3) {
    if (EventPiece* event =
            add_event(coordinates, modes, at, c,
                      {" leave", EventKind::leave, graph.negate(contact.force), changed(at.status, c, apart)}, events)) {
      event->continuous = true;
      event->effective_mass = mass_of(coordinates, contact);
      event->opening_rate = contact.rate;
    }
    add_event(coordinates, modes, at, c, {" open", EventKind::leave, contact.gap, changed(at.status, c, open)}, events);
  } else if (status == closed) {
    if (EventPiece* event = add_event(coordinates, modes, at, c,
                                      {" leave", EventKind::leave, contact.gap, changed(at.status, c, open)}, events)) {
      event->continuous = contact.begins_softly;
      event->effective_mass = mass_of(coordinates, contact);
    }
  } else {
    if (EventPiece* event =
            add_event(coordinates, modes, at, c, {" open", EventKind::other, contact.gap, changed(at.status, c, open)}, events))
      event->continuous = true;
    EventPiece* event =
        add_event(coordinates, modes, at, c, {" press", EventKind::enter, contact.force, changed(at.status, c, closed)}, events);
    if (!event) return;
    event->effective_mass = mass_of(coordinates, contact);
    event->continuous = true;
  }
}

void add_contact_surfaces(const ContactModes& modes, const Combination& at, std::size_t c, std::vector<SurfacePiece>& surfaces) {
  const Contact& contact = modes.contacts[c];
  if (contact.is_stop) {
    if (!contact.rigid || at.status[c] != closed) return;
    const Combination* free = modes.find(changed(at.status, c, open));
    for (const Expression h : {contact.gap, contact.rate})
      surfaces.push_back({h, free->mode, free->mode, at.mode, at.replacement});
  } else if (at.status[c] == forward) {
    SurfacePiece surface{contact.rate, modes.find(changed(at.status, c, backward))->mode, at.mode, {}, {}};
    if (const Combination* held = modes.find(changed(at.status, c, stuck))) {
      surface.sliding = held->mode;
      surface.state_on_surface = held->replacement;
    }
    surfaces.push_back(std::move(surface));
  }
}

}  // namespace graze::equations
