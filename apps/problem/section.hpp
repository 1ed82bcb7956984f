// SPDX-License-Identifier: GPL-3.0-or-later
// Section: points of a Poincaré section of a motion, collected until there are enough.
#pragma once

#include <graze/apps/problem/head.hpp>
#include <graze/apps/text/column.hpp>

#include <graze/lib/motion/trajectory.hpp>

#include <functional>
#include <vector>

namespace graze::apps {

enum class SectionKind {
  stroboscopic,  ///< states at forcing phase 0
  impact,   ///< (forcing phase, speed of approach) of each impact or entry; without forcing (time since the one before, speed)
  returns,  ///< states right behind the returns of an autonomous system
  event     ///< states right behind events with one name, and the forcing phase
};

/// "stroboscopic", "impact", "returns", "event".
const char* section_name(SectionKind kind);

/// Forcing periods without any impact after which an impact section is given up.
inline constexpr int patience = 1000;

struct Section {
  SectionKind kind = SectionKind::stroboscopic;
  std::vector<Vector> points;
  int periods = 0;
  Vector state;  ///< at the end of the last period
  Termination termination = Termination::time;
};

struct SectionOptions {
  SectionKind kind = SectionKind::stroboscopic;
  int points = 1000;
  std::string event = {};  ///< name of SectionKind::event
  std::function<bool()> cancelled = nullptr;
  std::function<void(std::size_t points)> progress = nullptr;
};

/// From `start` at forcing phase 0, until there are enough points, or nothing comes any more.
Section collect_section(const Problem& problem, const Vector& start, const SectionOptions& options);

/// What graze.poincare/1 has beside its head.
struct ListedSection {
  const Section& section;
  std::vector<std::string> columns;
};
const Columns<ListedSection>& listed_section_columns();
Json section_json(const Problem& problem, const Section& section);

/// Names of the columns of its points.
std::vector<std::string> section_columns(const Problem& problem, SectionKind kind);

}  // namespace graze::apps
