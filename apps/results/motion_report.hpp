// SPDX-License-Identifier: GPL-3.0-or-later
// Report of a motion, as JSON.
#pragma once

#include <graze/apps/results/orbit_report.hpp>
#include <graze/lib/motion/sampled_motion.hpp>

namespace graze::apps {

/// The members of graze.trajectory/1 beside its head.
struct ListedMotion {
  const Motion& motion;
  const ContactList& list;
  std::vector<std::string> columns;
};
const Columns<ListedMotion>& listed_motion_columns();
Json motion_json(const Problem& problem, const Motion& motion, const ContactList& list, const Quantities& expressions = {});

/// "tau" and the states: the columns of a motion's samples.
std::vector<std::string> motion_columns(const Problem& problem, const Quantities& expressions = {});

}  // namespace graze::apps
