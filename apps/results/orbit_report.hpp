// SPDX-License-Identifier: GPL-3.0-or-later
// Report of an orbit and of the contacts of a motion: as JSON, as text, as table rows. Used by every command that finds orbits.
#pragma once

#include <graze/apps/problem/problem.hpp>
#include <graze/apps/quantities/quantities.hpp>
#include <graze/apps/text/column.hpp>
#include <graze/apps/text/table.hpp>

#include <graze/floquet/orbit/periodic_orbit.hpp>

#include <vector>

namespace graze::apps {

/// Contacts of a motion in the order of their beginnings. `by_exit` holds, for each event that ends a contact (impact, stick,
/// leave), the contact that it ends.
struct ContactList {
  std::vector<Contact> contacts;
  std::vector<Contact> by_exit;
};
/// Contacts of a run from start to end: the first contact may lack its beginning, the last one its end.
ContactList contacts_of_run(const std::vector<EventRecord>& events);
/// Contacts of an orbit: a contact that extends beyond the end of the period is completed by its beginning.
ContactList contacts_of_orbit(const PeriodicOrbit& orbit);

/// An event, and the contact that it ends.
struct ListedEvent {
  const EventRecord* event = nullptr;
  std::optional<Contact> ended;
};
std::vector<ListedEvent> listed(const std::vector<EventRecord>& events, const ContactList& list);

Table contacts_table(const std::vector<Contact>& contacts);

/// "z = 2/3": impacts and forcing periods.
std::string z_label(int impacts, int period);
std::string z_label(int impacts, int isolated, int period);  ///< `isolated` of them: sticking, see PeriodicOrbit
std::string z_label(const PeriodicOrbit& orbit);
std::string z_label_of(const Json& orbit);  ///< of an orbit, a special point or a periodic attractor in a result
/// The behaviour of a mass at rest on its stop, from the exponents of a disturbance (lib/motion/rest.hpp).
std::string rest_text(const std::vector<double>& exponents);
/// The columns of "orbit" in graze.orbit/1 and of its members.
const Columns<ListedEvent>& event_columns();
const Columns<Contact>& contact_columns();
const Columns<NewtonReport>& newton_columns();
const Columns<OrbitChecks>& check_columns();
const Columns<PeriodicOrbit>& orbit_columns();

template <>
struct JsonForm<EventKind> : ChoiceForm<EventKind, event_kind_name, EventKind::impact, EventKind::enter, EventKind::leave,
                                        EventKind::stick, EventKind::release, EventKind::other> {};
template <>
struct JsonForm<NewtonStatus>
    : ChoiceForm<NewtonStatus, newton_status_text, NewtonStatus::not_run, NewtonStatus::converged, NewtonStatus::iteration_limit,
                 NewtonStatus::stalled, NewtonStatus::evaluation_failed, NewtonStatus::singular> {};
template <> struct JsonForm<ListedEvent> : RecordForm<ListedEvent, event_columns> {};
template <> struct JsonForm<Contact> : RecordForm<Contact, contact_columns> {};
template <> struct JsonForm<NewtonReport> : RecordForm<NewtonReport, newton_columns> {};
template <> struct JsonForm<OrbitChecks> : RecordForm<OrbitChecks, check_columns> {};
template <> struct JsonForm<PeriodicOrbit> : RecordForm<PeriodicOrbit, orbit_columns> {};
/// The values only; an empty list: they do not exist.
template <> struct JsonForm<FloquetMultipliers> {
  using Values = std::vector<std::complex<double>>;
  static Json json(const FloquetMultipliers& multipliers) {
    return JsonForm<Values>::json(multipliers.valid ? multipliers.values : Values());
  }
  static FloquetMultipliers value(const Json& json) {
    FloquetMultipliers out;
    out.values = JsonForm<Values>::value(json);
    out.valid = !out.values.empty();
    return out;
  }
  static void write(const FloquetMultipliers& multipliers, JsonText& text) {
    text.value(multipliers.valid ? multipliers.values : Values());
  }
  static Json schema() { return JsonForm<Values>::schema(); }
};

/// Floquet exponents; empty: they do not exist.
MaybeNumbers exponents_of(const FloquetMultipliers& multipliers);

/// Columns shared by all types that hold an orbit: PeriodicOrbit, BranchPoint, Attractor.
template <class T> Column<T> admissible_column() {
  return Column<T>(
      "admissible", "it does not pass through a barrier",
      [](const T& orbit) { return orbit.admissible == Admissibility::admissible; },
      [](T& orbit, bool value) { orbit.admissible = value ? Admissibility::admissible : Admissibility::inadmissible; });
}
template <class T> Column<T> multipliers_column() {
  return Column<T>("multipliers", "Floquet multipliers [re, im] by decreasing modulus; none: they do not exist", &T::multipliers);
}
template <class T> Column<T> impacts_column() {
  return Column<T>(
      "impacts", "number of impacts", [](const T& orbit) { return orbit.impacts; },
      [](T& orbit, int value) { orbit.impacts = orbit.isolated_impacts = value; });
}
/// Columns of an orbit that sticks.
template <class T> Columns<T> sticking_columns() {
  const auto sticks = [](const T& orbit) { return orbit.isolated_impacts < orbit.impacts; };
  return {{"sticking", "the mass sticks to a stop, after infinitely many impacts", sticks, only(sticks)},
          {"isolated_impacts", "impacts outside complete chatters", &T::isolated_impacts, only(sticks)}};
}
/// The orbit's states at forcing phase 0, and its shooting nodes if they differ from these.
template <class T> Columns<T> states_columns() {
  const auto has_nodes = [](const T& orbit) { return orbit.section_phase != 0.0; };
  const auto set_states = [](T& orbit, const std::vector<Vector>& states) { orbit.states = orbit.nodes = states; };
  // A grazing that could only be bracketed may have an orbit without states.
  const auto first_state = [](const T& orbit) { return orbit.states.empty() ? Vector() : orbit.states.front(); };
  return {{"state", "at forcing phase 0", first_state, [=](T& orbit, const Vector& state) { set_states(orbit, {state}); }},
          {"states", "at forcing phase 0, after each of several periods", [](const T& orbit) { return orbit.states; }, set_states,
           only([](const T& orbit) { return orbit.states.size() > 1; })},
          {"section_phase", "forcing phase over 2 pi of the first node", &T::section_phase, only(has_nodes)},
          {"nodes", "of the shooting equations, equally spaced in time", &T::nodes, only(has_nodes)}};
}
template <class T> Column<T> duration_column() {
  return Column<T>("duration [time]", "of an autonomous orbit", &T::duration).where([](const T& orbit) {
    return orbit.multipliers.section == graze::Section::autonomous;
  });
}

/// The whole text that `graze orbit` prints for one orbit. `stability`: in words; empty: derived from the multipliers.
std::string orbit_text(const Problem& problem, const PeriodicOrbit& orbit, const std::string& stability = {});

/// Headings of `count` multipliers: one each for people, otherwise two, for real and imaginary part.
std::vector<std::string> multiplier_heads(std::size_t count, bool for_people);

/// One row per orbit: state, z, multipliers, stable, admissible, quantities.
Table orbits_table(const Problem& problem, const std::vector<PeriodicOrbit>& orbits, bool for_people,
                   const std::vector<QuantityValues>& measured = {});

/// One line for each quantity.
std::string quantities_text(const QuantityValues& values);

}  // namespace graze::apps
