// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/motion/poincare.hpp>

#include <cmath>
#include <numbers>

namespace graze {

namespace {

constexpr int stretch = 50;  // periods that are carried at a time

}  // namespace

const char* section_name(SectionKind kind) {
  switch (kind) {
  case SectionKind::impact:
    return "impact";
  case SectionKind::returns:
    return "returns";
  case SectionKind::event:
    return "event";
  case SectionKind::stroboscopic:
    break;
  }
  return "stroboscopic";
}

PoincareSection poincare_section(const HybridSystem& system, const Vector& p, const Vector& start,
                                 const SectionOptions& options) {
  PoincareSection section;
  section.kind = options.kind;
  const auto wanted = static_cast<std::size_t>(options.points);
  const bool forced = is_forced(system);
  const auto frequency = system.forcing_frequency;
  const double eta = frequency ? p[static_cast<Eigen::Index>(*frequency)]
                     : forced  ? 2.0 * std::numbers::pi / forcing_period(system, p)
                               : 0.0;
  const bool impacts = options.kind == SectionKind::impact, events = options.kind == SectionKind::event;
  Vector state = start;
  int idle = 0;
  double last_impact = 0.0;  // of an autonomous motion, since the start of the current run
  bool has_struck = false;
  bool on_section = forced;  // the start of an autonomous motion is not
  while (section.points.size() < wanted && idle < options.patience && section.termination == Termination::time) {
    const Motion motion = run_motion(system, p, state, {.periods = stretch, .cancelled = options.cancelled});
    const std::size_t before = section.points.size();
    // A run of n periods gives n points; the next run begins with the state at its end.
    for (std::size_t k = on_section ? 0 : 1;
         !impacts && !events && k < static_cast<std::size_t>(motion.periods) && section.points.size() < wanted; ++k)
      section.points.push_back(motion.strobe[k]);
    on_section = true;
    for (const EventRecord& event : motion.events) {
      if (section.points.size() == wanted) break;
      const double phase = std::fmod(eta * event.t, 2.0 * std::numbers::pi), interval = event.t - last_impact;
      if (events && system.events[event.event].name == options.event) {
        section.points.emplace_back(event.x_plus.size() + 1);
        section.points.back() << event.x_plus, phase;
      }
      if (!impacts || !begins_contact(event.kind)) continue;
      if (forced || has_struck) section.points.push_back(Vector{{forced ? phase : interval, event.normal_speed}});
      has_struck = true;
      last_impact = event.t;
    }
    last_impact -= motion.duration;
    section.periods += motion.periods;
    section.termination = motion.termination;
    state = section.state = motion.strobe.back();
    idle = section.points.size() > before ? 0 : idle + stretch;
    if (options.progress) options.progress(section.points.size());
  }
  return section;
}

}  // namespace graze
