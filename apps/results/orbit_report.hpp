// SPDX-License-Identifier: GPL-3.0-or-later
// What is said of an orbit and of the contacts of a motion: as JSON, as text, as table rows. Used by every command that finds
// orbits.
#pragma once

#include <graze/apps/problem/problem.hpp>
#include <graze/apps/quantities/quantities.hpp>
#include <graze/apps/text/json_text.hpp>
#include <graze/apps/text/table.hpp>

#include <graze/floquet/orbit/periodic_orbit.hpp>

#include <vector>

namespace graze::apps {

/// Contacts of a motion, in the order of their beginnings; and, for each event that ends one (impact, stick, leave), the contact
/// it ends.
struct ContactList {
  std::vector<Contact> contacts;
  std::vector<Contact> by_exit;
};
/// Of a run from rest to end: its first contact may lack its beginning, its last one its end.
ContactList contacts_of_run(const std::vector<EventRecord>& events);
/// Of an orbit: a contact that reaches over the end of the period is completed by its beginning.
ContactList contacts_of_orbit(const PeriodicOrbit& orbit);

Json events_json(const std::vector<EventRecord>& events, const ContactList& list);
Json contacts_json(const std::vector<Contact>& contacts);
Table contacts_table(const std::vector<Contact>& contacts);

/// "z = 2/3": impacts and forcing periods.
std::string z_label(int impacts, int period);
std::string z_label(int impacts, int isolated, int period);  ///< of them isolated: sticking, see PeriodicOrbit
std::string z_label(const PeriodicOrbit& orbit);
std::string z_label_of(const Json& orbit);  ///< of an orbit, a special point or a periodic attractor as a result has it
/// What a mass at rest on its stop does, by the exponents of a disturbance (lib/rest.hpp).
std::string rest_text(const std::vector<double>& exponents);
/// "sticking": true and "isolated_impacts" (those outside complete chatters), for an orbit that sticks.
void add_sticking(Json& out, int impacts, int isolated);
void write_sticking(int impacts, int isolated, JsonText& json);

Json multipliers_json(const FloquetMultipliers& multipliers);
Json exponents_json(const FloquetMultipliers& multipliers);
Json checks_json(const OrbitChecks& checks);

/// As "orbit" in graze.orbit/1.
Json orbit_json(const PeriodicOrbit& orbit);

/// All that `graze orbit` prints of one orbit. `stability`: in words; empty: what its multipliers say.
std::string orbit_text(const Problem& problem, const PeriodicOrbit& orbit, const std::string& stability = {});

/// One row per orbit: state, z, multipliers, stable, admissible, quantities.
Table orbits_table(const Problem& problem, const std::vector<PeriodicOrbit>& orbits, bool for_people,
                   const std::vector<QuantityValues>& measured = {});

/// A line for each quantity.
std::string quantities_text(const QuantityValues& values);

}  // namespace graze::apps
