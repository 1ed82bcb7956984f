// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/results/motion_report.hpp>

namespace graze::apps {

std::vector<std::string> motion_columns(const Problem& problem, const Quantities& expressions) {
  std::vector<std::string> columns = state_columns(problem);
  columns.insert(columns.begin(), "tau");
  for (const Quantity& one : expressions.list) columns.push_back(one.text);
  return columns;
}

Json motion_json(const Problem& problem, const Motion& motion, const ContactList& list, const Quantities& expressions) {
  Json out;
  out["periods"] = motion.periods;
  out["end"] = termination_text(motion.termination);
  out["columns"] = motion_columns(problem, expressions);
  out["samples"] = to_json(motion.samples);
  out["stroboscopic"] = to_json(motion.strobe);
  out["events"] = json_of(listed(motion.events, list));
  out["contacts"] = json_of(list.contacts);
  return out;
}

}  // namespace graze::apps
