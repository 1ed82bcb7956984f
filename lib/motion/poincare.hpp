// SPDX-License-Identifier: GPL-3.0-or-later
// PoincareSection: points of a Poincare section of a motion.
#pragma once

#include <graze/lib/motion/sampled_motion.hpp>

#include <functional>
#include <string>
#include <vector>

namespace graze {

enum class SectionKind {
  stroboscopic,  ///< states at forcing phase 0
  impact,        ///< (forcing phase, speed of approach) of impacts and entries; without forcing (time since the last one, speed)
  returns,       ///< states just after the returns of an autonomous system
  event          ///< states just after events of one name, and the forcing phase
};

/// "stroboscopic", "impact", "returns", "event".
const char* section_name(SectionKind kind);

struct PoincareSection {
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
  int patience = 1000;     ///< periods without a point after which the section ends
  std::function<bool()> cancelled = nullptr;
  std::function<void(std::size_t points)> progress = nullptr;
};

/// Collects points of the motion from `start` at forcing phase 0. It has fewer points if the motion ends, or if `patience`
/// periods bring none. @throws std::invalid_argument for an inadmissible start.
PoincareSection poincare_section(const HybridSystem& system, const Vector& p, const Vector& start, const SectionOptions& options);

}  // namespace graze
