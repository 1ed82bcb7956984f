// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/results/section_report.hpp>

namespace graze::apps {

std::vector<std::string> section_columns(const Problem& problem, SectionKind kind) {
  if (kind != SectionKind::impact) {
    std::vector<std::string> columns = state_columns(problem);
    if (kind == SectionKind::event) columns.emplace_back("phase");
    return columns;
  }
  return {is_forced(problem.system) ? "phase" : "interval", "speed"};
}

const Columns<ListedSection>& listed_section_columns() {
  using S = ListedSection;
  static const Columns<S> list = {
      {"section", "stroboscopic, returns, or impact", [](const S& s) { return std::string(section_name(s.section.kind)); }},
      {"periods", "of the run", [](const S& s) { return s.section.periods; }},
      {"columns", "of the points", &S::columns},
      {"points", "in the order of time", [](const S& s) { return finite(s.section.points); }}};
  return list;
}

Json section_json(const Problem& problem, const PoincareSection& section) {
  return json_of(listed_section_columns(), {section, section_columns(problem, section.kind)});
}

}  // namespace graze::apps
