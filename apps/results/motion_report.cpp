// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/results/motion_report.hpp>

namespace graze::apps {

Json motion_json(const Motion& motion, const ContactList& list) {
  Json out;
  out["periods"] = motion.periods;
  out["end"] = termination_text(motion.termination);
  out["columns"] = {"tau", "x", "v"};
  out["samples"] = motion.samples;
  out["stroboscopic"] = Json::array();
  for (const Vector& state : motion.strobe) out["stroboscopic"].push_back(to_json(state));
  out["events"] = events_json(motion.events, list);
  out["contacts"] = contacts_json(list.contacts);
  return out;
}

}  // namespace graze::apps
