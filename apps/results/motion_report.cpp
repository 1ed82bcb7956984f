// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/results/motion_report.hpp>

namespace graze::apps {

std::vector<std::string> motion_columns(const Problem& problem, const Quantities& expressions) {
  std::vector<std::string> columns = state_columns(problem);
  columns.insert(columns.begin(), "tau");
  for (const Quantity& one : expressions.list) columns.push_back(one.text);
  return columns;
}

const Columns<ListedMotion>& listed_motion_columns() {
  using M = ListedMotion;
  static const Columns<M> list = {
      {"periods", "completed forcing periods or returns", [](const M& m) { return m.motion.periods; }},
      {"end", "how the run ended", [](const M& m) { return std::string(termination_text(m.motion.termination)); }},
      {"columns", "of the samples", &M::columns},
      {"samples", "at equal steps of time", [](const M& m) { return finite(m.motion.samples); }},
      {"stroboscopic", "states at forcing phase 0 (behind returns)", [](const M& m) { return m.motion.strobe; }},
      {"events", "on the way", [](const M& m) { return listed(m.motion.events, m.list); }},
      {"contacts", "contacts that begin or end during the run", [](const M& m) { return m.list.contacts; }}};
  return list;
}

Json motion_json(const Problem& problem, const Motion& motion, const ContactList& list, const Quantities& expressions) {
  return json_of(listed_motion_columns(), {motion, list, motion_columns(problem, expressions)});
}

}  // namespace graze::apps
