// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/results/orbit_report.hpp>
#include <graze/apps/text/number.hpp>

#include <graze/floquet/verify/orbit_verification.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace graze::apps {

namespace {

std::string check_cell(double value) { return value < 0.0 ? "-" : rounded(value, 3); }

std::string verdict(double value, double limit, const std::string& obstacle) {
  return value < 0.0 ? "not applicable: " + obstacle : value <= limit ? "ok" : "FAILED";
}

std::optional<double> known(bool is_known, double value) {
  return is_known && !std::isnan(value) ? std::optional(value) : std::nullopt;
}

Table numbered(Table table, const char* head) {
  table.columns.insert(table.columns.begin(), head);
  for (std::size_t i = 0; i < table.rows.size(); ++i) table.rows[i].insert(table.rows[i].begin(), std::to_string(i + 1));
  return table;
}

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

std::vector<ListedEvent> listed(const std::vector<EventRecord>& events, const ContactList& list) {
  std::vector<ListedEvent> out;
  std::size_t ended = 0;
  for (const EventRecord& event : events)
    out.push_back({&event, ends_contact(event) ? std::optional(list.by_exit[ended++]) : std::nullopt});
  return out;
}

const Columns<ListedEvent>& event_columns() {
  using E = ListedEvent;
  const auto ends = [](const E& one) { return one.ended.has_value(); };
  static const Columns<E> list = {
      {"tau [time]", "time since forcing phase 0, or since the start of the run", [](const E& e) { return e.event->t; }},
      {"kind", "kind of event", [](const E& e) { return e.event->kind; }},
      {"speed [speed]", "normal speed", [](const E& e) { return e.event->normal_speed; }},
      {"restitution", "of the contact that ends; null: not known", [](const E& e) { return known(true, e.ended->restitution); },
       only(ends)},
      {"energy_lost [energy]", "in the contact that ends", [](const E& e) { return known(true, e.ended->energy_lost); },
       only(ends)},
      {"before", "state right before", [](const E& e) { return e.event->x_minus; }},
      {"after", "state right behind", [](const E& e) { return e.event->x_plus; }}};
  return list;
}

const Columns<Contact>& contact_columns() {
  using C = Contact;
  // A contact that is cut off by the run has only one known end.
  const auto begun = [](const C& contact) { return !std::isnan(contact.t_entry); };
  const auto ended = [](const C& contact) { return contact.complete || std::isnan(contact.t_entry); };
  static const Columns<C> list = {
      {"entry [time]", "time at which it begins; null: before the run", [=](const C& c) { return known(begun(c), c.t_entry); }},
      {"exit [time]", "time at which it ends; null: behind the run", [=](const C& c) { return known(ended(c), c.t_exit); }},
      {"duration [time]", "null: it is cut off by the run", [](const C& c) { return known(c.complete, c.t_exit - c.t_entry); }},
      {"entry_speed [speed]", "speed of approach", [=](const C& c) { return known(begun(c), c.entry_speed); }},
      {"exit_speed [speed]", "speed of departure", [=](const C& c) { return known(ended(c), c.exit_speed); }},
      {"restitution", "exit over entry speed; null at a grazing", [](const C& c) { return known(c.complete, c.restitution); }},
      {"energy_lost [energy]", "m (entry speed^2 - exit speed^2) / 2",
       [](const C& c) { return known(c.complete, c.energy_lost); }}};
  return list;
}

Table contacts_table(const std::vector<Contact>& contacts) {
  constexpr int digits = 9;
  Table table = table_of(contact_columns(),
                         {{"entry", {"entry tau"}, digits},
                          {"exit", {"exit tau"}, digits},
                          {"duration", {"duration"}, digits},
                          {"entry_speed", {"entry speed"}, digits},
                          {"exit_speed", {"exit speed"}, digits},
                          {"restitution", {"restitution"}, digits},
                          {"energy_lost", {"energy lost"}, digits}},
                         contacts);
  return numbered(table, "contact");
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

MaybeNumbers exponents_of(const FloquetMultipliers& multipliers) {
  return multipliers.valid ? finite(multipliers.exponents) : MaybeNumbers();
}

const Columns<NewtonReport>& newton_columns() {
  static const Columns<NewtonReport> list = {
      {"status", "how Newton's method ended", &NewtonReport::status},
      {"residuals", "largest residual before each step and after the last, relative to 1 + |x|",
       [](const NewtonReport& report) { return finite(report.residual_history); },
       [](NewtonReport& report, const MaybeNumbers& values) { report.residual_history = numbers(values, std::nan("")); }}};
  return list;
}

const Columns<OrbitChecks>& check_columns() {
  using C = OrbitChecks;
  const auto difference = [](C& checks) -> FiniteDifferenceCheck& {
    return checks.finite_difference ? *checks.finite_difference : checks.finite_difference.emplace();
  };
  const auto applicable = [](const C& checks) { return checks.finite_difference && checks.finite_difference->applicable; };
  const auto maybe = [](bool there, double value) { return there ? std::optional(value) : std::nullopt; };
  static const Columns<C> list = {
      {"residual", "largest mismatch of the shooting equations / (1 + |x|)",
       [=](const C& c) { return maybe(c.residual >= 0.0, c.residual); },
       [](C& c, std::optional<double> value) { c.residual = value.value_or(-1.0); }},
      {"finite_difference", "largest |M - M by finite differences| / (1 + |M|); null: not applicable, or not asked for",
       [=](const C& c) { return maybe(applicable(c), applicable(c) ? c.finite_difference->disagreement : 0.0); },
       [=](C& c, std::optional<double> value) {
         if (value) difference(c).disagreement = *value;
       }},
      {"finite_difference_error", "error of the finite differences by extrapolation, on the same scale",
       [](const C& c) { return c.finite_difference->error_estimate; },
       [=](C& c, double value) { difference(c).error_estimate = value; }, only(applicable)},
      {"finite_difference_applicable", "false: a step of useful size leaves the orbit's sequence of impacts",
       [](const C& c) { return c.finite_difference->applicable; }, [=](C& c, bool value) { difference(c).applicable = value; },
       only([](const C& c) { return c.finite_difference.has_value(); })},
      {"liouville", "|sum of ln|det| - Liouville's identity|; null: not applicable",
       [=](const C& c) { return maybe(c.liouville >= 0.0, c.liouville); },
       [](C& c, std::optional<double> value) { c.liouville = value.value_or(-1.0); }}};
  return list;
}

const Columns<PeriodicOrbit>& orbit_columns() {
  using O = PeriodicOrbit;
  const auto conservative = [](const O& orbit) { return orbit.conservative; };
  static const Columns<O> list =
      joined<O>({{{"period", "forcing periods, or returns of an autonomous orbit", &O::period},
                  {"impacts", "number of impacts", &O::impacts},
                  {"state", "at forcing phase 0", &O::state},
                  admissible_column<O>(),
                  {"stable", "no multiplier lies outside the unit circle", &O::stable}},
                 sticking_columns<O>(),
                 {{"rests", "the mass is held at its stop all the time", &O::rests, only(&O::rests)},
                  {"conservative", "nothing dissipates", &O::conservative, only(conservative)},
                  {"neutral", "elliptic, or at the border to that", &O::neutral, only(conservative)},
                  multipliers_column<O>(),
                  {"exponents [1/time]", "Floquet exponents ln|mu| / duration; null: -infinity",
                   [](const O& o) { return exponents_of(o.multipliers); }},
                  {"zero_multipliers", "multipliers that are exactly zero",
                   [](const O& o) { return std::count(o.multipliers.values.begin(), o.multipliers.values.end(), 0.0); }},
                  {"duration [time]", "of the orbit", &O::duration},
                  {"events", "along the orbit", [](const O& o) { return listed(o.events, contacts_of_orbit(o)); }},
                  {"contacts", "contacts that begin along the orbit", [](const O& o) { return contacts_of_orbit(o).contacts; }},
                  {"checks", "proofs that come with the orbit", &O::checks},
                  {"newton", "course of Newton's method", &O::newton}}});
  return list;
}

std::string orbit_text(const Problem& problem, const PeriodicOrbit& orbit, const std::string& stability) {
  const bool admissible = orbit.admissible == Admissibility::admissible;
  const FloquetMultipliers& multipliers = orbit.multipliers;
  const bool forced = is_forced(problem.system);
  std::string text =
      fmt::format("orbit {}: {} in {}, {}, {}\n", z_label(orbit), counted(static_cast<std::size_t>(orbit.impacts), "impact"),
                  counted_periods(problem, orbit.period),
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
  const auto add = [&](const char* name, double value, double limit, const std::string& obstacle) {
    checks.rows.push_back({name, check_cell(value), rounded(limit, 3), verdict(value, limit, obstacle)});
  };
  add("residual of the shooting equations", orbit.checks.residual, bound::residual, "the orbit could not be carried");
  add("Liouville: ln|det M|", orbit.checks.liouville, bound::liouville, liouville_obstacle(orbit));
  if (const auto& difference = orbit.checks.finite_difference)
    add("finite differences of the return map", difference->applicable ? difference->disagreement : -1.0,
        finite_difference_bound(*difference), difference_obstacle);
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

std::vector<std::string> multiplier_heads(std::size_t count, bool for_people) {
  std::vector<std::string> heads;
  for (std::size_t k = 1; k <= count; ++k) {
    heads.push_back(fmt::format(fmt::runtime(for_people ? "multiplier {}" : "mu{}_re"), k));
    if (!for_people) heads.push_back(fmt::format("mu{}_im", k));
  }
  return heads;
}

Table orbits_table(const Problem& problem, const std::vector<PeriodicOrbit>& orbits, bool for_people,
                   const std::vector<QuantityValues>& measured) {
  const std::size_t count = orbits.empty() ? 0 : static_cast<std::size_t>(orbits.front().state.size());
  Table table = table_of(orbit_columns(),
                         {{"period"},
                          {"impacts"},
                          {"state", for_people ? state_headings(problem) : state_columns(problem), for_people ? 10 : 0},
                          {"multipliers", multiplier_heads(count, for_people), for_people ? 8 : 0},
                          {"stable"},
                          {"admissible"}},
                         orbits);
  if (!measured.empty()) add_columns(table, measured.front());
  for (std::size_t i = 0; i < measured.size(); ++i) add_cells(table.rows[i], measured[i], for_people);
  return numbered(std::move(table), "orbit");
}

}  // namespace graze::apps
