// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/results/orbit_report.hpp>
#include <graze/apps/text/number.hpp>

#include <graze/floquet/verify/orbit_verification.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace graze::apps {

namespace {

const char* yes(bool value) { return value ? "yes" : "no"; }

std::string check_cell(double value) { return value < 0.0 ? "-" : rounded(value, 3); }

std::string verdict(double value, double limit) { return value < 0.0 ? "not applicable" : value <= limit ? "ok" : "FAILED"; }

}  // namespace

ContactList contacts_of_run(const std::vector<EventRecord>& events) {
  ContactList list;
  list.contacts = contacts(events);
  list.by_exit = list.contacts;  // contacts do not overlap: they end in the order in which they begin
  return list;
}

ContactList contacts_of_orbit(const PeriodicOrbit& orbit) {
  ContactsOfCycle cycle = contacts_of_cycle(orbit.events, orbit.duration);
  return {std::move(cycle.by_entry), std::move(cycle.by_exit)};
}

Json events_json(const std::vector<EventRecord>& events, const ContactList& list) {
  Json out = Json::array();
  std::size_t ended = 0;
  for (const EventRecord& event : events) {
    Json entry = {{"tau", event.t}, {"kind", event_kind_name(event.kind)}, {"speed", event.normal_speed}};
    if (ends_contact(event)) {
      const Contact& contact = list.by_exit[ended++];
      entry["restitution"] = contact.restitution;
      entry["energy_lost"] = contact.energy_lost;
    }
    entry["before"] = to_json(event.x_minus);
    entry["after"] = to_json(event.x_plus);
    out.push_back(std::move(entry));
  }
  return out;
}

Json contacts_json(const std::vector<Contact>& contacts) {
  Json out = Json::array();
  for (const Contact& contact : contacts) {
    Json entry = {
        {"entry", contact.t_entry},           {"exit", contact.t_exit},           {"duration", contact.t_exit - contact.t_entry},
        {"entry_speed", contact.entry_speed}, {"exit_speed", contact.exit_speed}, {"restitution", contact.restitution},
        {"energy_lost", contact.energy_lost}};
    if (!contact.complete) {
      // Of a contact that the run cuts off, only one end is known.
      for (const char* name : {std::isnan(contact.t_entry) ? "entry" : "exit", "duration",
                               std::isnan(contact.t_entry) ? "entry_speed" : "exit_speed", "restitution", "energy_lost"})
        entry[name] = nullptr;
    }
    out.push_back(std::move(entry));
  }
  return out;
}

Table contacts_table(const std::vector<Contact>& contacts) {
  Table table{{"contact", "entry tau", "exit tau", "duration", "entry speed", "exit speed", "restitution", "energy lost"}, {}};
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& contact = contacts[i];
    const bool entry = !std::isnan(contact.t_entry), exit = contact.complete || !entry;
    const auto cell = [](bool known, double value) { return known && !std::isnan(value) ? rounded(value, 9) : std::string("-"); };
    table.rows.push_back({std::to_string(i + 1), cell(entry, contact.t_entry), cell(exit, contact.t_exit),
                          cell(contact.complete, contact.t_exit - contact.t_entry), cell(entry, contact.entry_speed),
                          cell(exit, contact.exit_speed), cell(contact.complete, contact.restitution),
                          cell(contact.complete, contact.energy_lost)});
  }
  return table;
}

std::string z_label(int impacts, int period) { return "z = " + label(impacts, period); }

std::string z_label(int impacts, int isolated, int period) { return "z = " + label(impacts, isolated, period); }

std::string z_label(const PeriodicOrbit& orbit) { return z_label(orbit.impacts, orbit.isolated_impacts, orbit.period); }

std::string z_label_of(const Json& orbit) {
  const int impacts = orbit.at("impacts");
  return "z = " + label(impacts, orbit.value("isolated_impacts", impacts), orbit.at("period"));
}

std::string rest_text(const std::vector<double>& exponents) {
  const bool bounces = !exponents.empty() && std::isfinite(exponents.front());
  return bounces ? "the mass rests on the pressed stop for ever; the stop gives all energy back, so that a disturbance bounces "
                   "for ever too, its speed shrinking at the first exponent (-2b/3), its height at the second (-4b/3)"
                 : "the mass rests on the pressed stop for ever; every disturbance dies out in finite time";
}

void add_sticking(Json& out, int impacts, int isolated) {
  if (isolated >= impacts) return;
  out["sticking"] = true;
  out["isolated_impacts"] = isolated;
}

void write_sticking(int impacts, int isolated, JsonText& json) {
  if (isolated >= impacts) return;
  json.member("sticking", true);
  json.member("isolated_impacts", isolated);
}

Json multipliers_json(const FloquetMultipliers& multipliers) {
  return multipliers.valid ? to_json(multipliers.values) : Json::array();
}

Json exponents_json(const FloquetMultipliers& multipliers) {
  return multipliers.valid ? Json(multipliers.exponents) : Json::array();  // minus infinity is written as null
}

Json checks_json(const OrbitChecks& checks) {
  const auto number = [](double value) { return value < 0.0 ? Json(nullptr) : Json(value); };
  Json out = {{"residual", number(checks.residual)}};
  const auto& difference = checks.finite_difference;
  out["finite_difference"] = difference && difference->applicable ? Json(difference->disagreement) : Json(nullptr);
  if (difference && difference->applicable) out["finite_difference_error"] = difference->error_estimate;
  if (difference) out["finite_difference_applicable"] = difference->applicable;
  out["liouville"] = number(checks.liouville);
  return out;
}

Json orbit_json(const PeriodicOrbit& orbit) {
  const ContactList list = contacts_of_orbit(orbit);
  Json out = {{"period", orbit.period},
              {"impacts", orbit.impacts},
              {"state", to_json(orbit.state)},
              {"admissible", orbit.admissible == Admissibility::admissible},
              {"stable", orbit.stable()}};
  add_sticking(out, orbit.impacts, orbit.isolated_impacts);
  if (orbit.rests) out["rests"] = true;
  if (orbit.conservative) out.update({{"conservative", true}, {"neutral", orbit.neutral()}});
  out["multipliers"] = multipliers_json(orbit.multipliers);
  out["exponents"] = exponents_json(orbit.multipliers);
  out["zero_multipliers"] =
      std::count(orbit.multipliers.values.begin(), orbit.multipliers.values.end(), std::complex<double>(0.0));
  out["duration"] = orbit.duration;
  out["events"] = events_json(orbit.events, list);
  out["contacts"] = contacts_json(list.contacts);
  out["checks"] = checks_json(orbit.checks);
  out["newton"] = {{"status", newton_status_text(orbit.newton.status)}, {"residuals", orbit.newton.residual_history}};
  return out;
}

std::string orbit_text(const Problem& problem, const PeriodicOrbit& orbit, const std::string& stability) {
  const bool admissible = orbit.admissible == Admissibility::admissible;
  const FloquetMultipliers& multipliers = orbit.multipliers;
  const bool forced = is_forced(problem.system);
  std::string text =
      fmt::format("orbit {}: {} impact{} in {} {}{}, {}, {}\n", z_label(orbit), orbit.impacts, orbit.impacts == 1 ? "" : "s",
                  orbit.period, forced ? "forcing period" : "turn", orbit.period == 1 ? "" : "s",
                  !stability.empty() ? stability
                  : orbit.neutral()  ? "neutral (nothing dissipates)"
                  : orbit.stable()   ? "stable"
                                     : "unstable",
                  admissible ? "admissible" : "NOT ADMISSIBLE (it passes through the barrier)");
  text +=
      fmt::format("  state at {}   {}\n", forced ? "forcing phase 0" : "the start      ", state_text(problem, orbit.state, 15));
  text += fmt::format("  duration                   {}\n", rounded(orbit.duration, 15));
  if (orbit.rests) text += "  " + rest_text(orbit.multipliers.exponents) + "\n";

  if (multipliers.valid) {
    Table table{{"multiplier", "value", "modulus", "exponent"}, {}};
    for (std::size_t i = 0; i < multipliers.values.size(); ++i)
      table.rows.push_back({std::to_string(i + 1), rounded(multipliers.values[i], 13),
                            rounded(std::abs(multipliers.values[i]), 13),
                            std::isinf(multipliers.exponents[i]) ? "-infinity" : rounded(multipliers.exponents[i], 13)});
    text.append("\n").append(aligned(table));
  } else {
    text += "\n  multipliers: do not exist here (an impact of zero speed)\n";
  }

  Table checks{{"check", "value", "bound", "verdict"}, {}};
  const auto add = [&](const char* name, double value, double limit) {
    checks.rows.push_back({name, check_cell(value), rounded(limit, 3), verdict(value, limit)});
  };
  add("residual of the shooting equations", orbit.checks.residual, bound::residual);
  add("Liouville: ln|det M|", orbit.checks.liouville, bound::liouville);
  if (const auto& difference = orbit.checks.finite_difference)
    add("finite differences of the return map", difference->applicable ? difference->disagreement : -1.0,
        finite_difference_bound(*difference));
  text.append("\n").append(aligned(checks));

  const std::vector<Contact> list = contacts_of_orbit(orbit).contacts;
  text.append("\n").append(list.empty() ? "  no contact begins on this orbit\n" : aligned(contacts_table(list)));
  return text;
}

std::string quantities_text(const QuantityValues& values) {
  if (values.empty()) return {};
  Table table{{"quantity", "value"}, {}};
  for (const QuantityValue& one : values) {
    std::string cell;
    for (const double value : one.values)
      cell += (cell.empty() ? "" : ", ") + (std::isfinite(value) ? rounded(value, 13) : std::string("-"));
    table.rows.push_back({one.name, cell});
  }
  return "\n" + aligned(table);
}

Table orbits_table(const Problem& problem, const std::vector<PeriodicOrbit>& orbits, bool for_people,
                   const std::vector<QuantityValues>& measured) {
  Table table{{"orbit", "period", "impacts"}, {}};
  for (const std::string& name : for_people ? state_headings(problem) : state_columns(problem)) table.columns.push_back(name);
  const std::size_t count = orbits.empty() ? 0 : static_cast<std::size_t>(orbits.front().state.size());
  for (std::size_t k = 1; k <= count; ++k) {
    if (for_people) {
      table.columns.push_back(fmt::format("multiplier {}", k));
    } else {
      table.columns.push_back(fmt::format("mu{}_re", k));
      table.columns.push_back(fmt::format("mu{}_im", k));
    }
  }
  table.columns.insert(table.columns.end(), {"stable", "admissible"});
  if (!measured.empty()) add_columns(table, measured.front());
  for (std::size_t i = 0; i < orbits.size(); ++i) {
    const PeriodicOrbit& orbit = orbits[i];
    const auto number = [&](double value) { return for_people ? rounded(value, 10) : exact(value); };
    std::vector<std::string> row = {std::to_string(i + 1), std::to_string(orbit.period), std::to_string(orbit.impacts)};
    for (const double value : orbit.state) row.push_back(number(value));
    for (std::size_t k = 0; k < count; ++k) {
      const bool there = orbit.multipliers.valid && k < orbit.multipliers.values.size();
      const std::complex<double> mu = there ? orbit.multipliers.values[k] : 0.0;
      if (for_people) {
        row.push_back(there ? rounded(mu, 8) : "-");
      } else {
        row.push_back(there ? number(mu.real()) : "");
        row.push_back(there ? number(mu.imag()) : "");
      }
    }
    row.push_back(yes(orbit.stable()));
    row.push_back(yes(orbit.admissible == Admissibility::admissible));
    if (!measured.empty()) add_cells(row, measured[i], for_people);
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace graze::apps
