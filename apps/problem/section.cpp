// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/problem/motion.hpp>
#include <graze/apps/problem/section.hpp>

#include <cmath>
#include <numbers>

namespace graze::apps {

namespace {

constexpr int stretch = 50;  // forcing periods that are run at a time

}  // namespace

const char* section_name(SectionKind kind) { return kind == SectionKind::impact ? "impact" : "stroboscopic"; }

Section collect_section(const Problem& problem, const Vector& start, const SectionOptions& options) {
  Section section;
  section.kind = options.kind;
  const auto wanted = static_cast<std::size_t>(options.points);
  const auto frequency = problem.system.forcing_frequency;
  const double eta = frequency ? problem.parameters[static_cast<Eigen::Index>(*frequency)]
                               : 2.0 * std::numbers::pi / forcing_period(problem.system, problem.parameters);
  const bool impacts = options.kind == SectionKind::impact;
  Vector state = start;
  int idle = 0;
  while (section.points.size() < wanted && idle < patience && section.termination == Termination::time) {
    const Motion motion =
        run_motion(problem.system, problem.parameters, state, {.periods = stretch, .cancelled = options.cancelled});
    const std::size_t before = section.points.size();
    // A run of n periods gives n points, the next run begins with the state at its end.
    for (std::size_t k = 0; !impacts && k < static_cast<std::size_t>(motion.periods) && section.points.size() < wanted; ++k)
      section.points.push_back(motion.strobe[k]);
    for (const EventRecord& event : motion.events) {
      if (!impacts || section.points.size() == wanted || !begins_contact(event.kind)) continue;
      section.points.push_back(Vector{{std::fmod(eta * event.t, 2.0 * std::numbers::pi), event.normal_speed}});
    }
    section.periods += motion.periods;
    section.termination = motion.termination;
    state = motion.strobe.back();
    idle = section.points.size() > before ? 0 : idle + stretch;
    if (options.progress) options.progress(section.points.size());
  }
  return section;
}

std::vector<std::string> section_columns(const Problem& problem, SectionKind kind) {
  return kind == SectionKind::impact ? std::vector<std::string>{"phase", "speed"} : state_columns(problem);
}

Json section_json(const Problem& problem, const Section& section) {
  Json out;
  out["section"] = section_name(section.kind);
  out["periods"] = section.periods;
  out["columns"] = section_columns(problem, section.kind);
  out["points"] = to_json(section.points);
  return out;
}

}  // namespace graze::apps
