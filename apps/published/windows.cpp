// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/published/windows.hpp>
#include <graze/apps/results/attractor_report.hpp>
#include <graze/apps/results/orbit_report.hpp>
#include <graze/apps/text/number.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <regex>

namespace graze::apps {

namespace {

/// The attractors that a note names: "z = 7/10", "period-24", "period 24".
std::vector<PublishedAttractor> named_in(const std::string& note) {
  std::vector<PublishedAttractor> list;
  const std::regex z("(\\d+)/(\\d+)"), period("period[- ](\\d+)");
  for (std::sregex_iterator it(note.begin(), note.end(), z), end; it != end; ++it) {
    PublishedAttractor attractor;
    attractor.type = "periodic";
    attractor.z = {std::stoi((*it)[1]), std::stoi((*it)[2])};
    attractor.periods = (*attractor.z)[1];
    list.push_back(std::move(attractor));
  }
  for (std::sregex_iterator it(note.begin(), note.end(), period), end; it != end; ++it)
    list.push_back({"periodic", std::nullopt, std::stoi((*it)[1])});
  return list;
}

bool in_window(const SweepRow& row, const PublishedWindow& window, double step) {
  const bool direction = window.direction == "both" || window.direction == sweep_direction_name(row.direction);
  return direction && row.value > window.from - 0.01 * step && row.value < window.to + 0.01 * step;
}

/// "up z = 0/1 (0.65 to 0.71), z = 1/1 (0.711); down ..." for rows in the order of a sweep.
std::string stretches(const std::vector<const SweepRow*>& rows) {
  std::string text;
  const SweepRow* first = nullptr;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const SweepRow& row = *rows[i];
    if (!first) {
      first = &row;
      const bool turned = i == 0 || rows[i - 1]->direction != row.direction;
      if (turned)
        text += fmt::format("{}{} ", i == 0 ? "" : "; ", sweep_direction_name(row.direction));
      else
        text += ", ";
    }
    const bool ends = i + 1 == rows.size() || rows[i + 1]->direction != row.direction ||
                      attractor_name(rows[i + 1]->attractor) != attractor_name(row.attractor);
    if (!ends) continue;
    text += attractor_name(row.attractor);
    text += first == &row ? fmt::format(" ({})", rounded(row.value, 6))
                          : fmt::format(" ({} to {})", rounded(first->value, 6), rounded(row.value, 6));
    first = nullptr;
  }
  return text;
}

Json rows_json(const std::vector<const SweepRow*>& rows) {
  Json list = Json::array();
  for (const SweepRow* row : rows)
    list.push_back({{"eta", row->value},
                    {"direction", sweep_direction_name(row->direction)},
                    {"attractor", attractor_name(row->attractor)},
                    {"exponent", row->attractor.exponents.empty() ? Json(nullptr) : Json(row->attractor.exponents[0])}});
  return list;
}

}  // namespace

std::vector<Comparison> compare_windows(const SweptDiagram& swept) {
  std::vector<Comparison> list;
  for (const PublishedWindow& window : swept.diagram.windows) {
    Comparison row;
    row.figure = swept.diagram.figure;
    row.system = swept.diagram.system;
    row.quantity = "window";
    row.eta = window.from;
    row.published = {{"eta", {window.from, window.to}},
                     {"direction", window.direction},
                     {"attractor", label(window.attractor)},
                     {"note", window.note}};
    row.published_text =
        fmt::format("{} {} to {}: {}", window.direction, rounded(window.from, 6), rounded(window.to, 6), label(window.attractor));
    const std::vector<PublishedAttractor> named = named_in(window.note);
    std::vector<const SweepRow*> all, beside, others;
    for (const SweepRow& swept_row : swept.rows) {
      if (!in_window(swept_row, window, swept.diagram.step)) continue;
      all.push_back(&swept_row);
      if (is_described(swept_row.attractor, window.attractor)) continue;
      const bool noted = std::any_of(named.begin(), named.end(), [&](const PublishedAttractor& attractor) {
        return is_described(swept_row.attractor, attractor);
      });
      (noted ? beside : others).push_back(&swept_row);
    }
    const bool any = all.size() > beside.size() + others.size();
    row.verdict = any && others.empty() ? Verdict::agrees : Verdict::differs;
    row.computed = rows_json(all);
    row.computed_text = stretches(all);
    if (!beside.empty()) add_remark(row.remark, "as the source notes: " + stretches(beside));
    if (!others.empty())
      add_remark(row.remark, fmt::format("{} of {} values differ: {}", others.size(), all.size(), stretches(others)));
    if (all.empty()) add_remark(row.remark, "the sweep has no value there");
    if (window.attractor.type == "impactless" && !others.empty())
      add_remark(row.remark, no_impactless_motion(swept.problem, window.to));
    list.push_back(std::move(row));
  }
  return list;
}

std::vector<Start> starts_from(const SweptDiagram& swept, double eta) {
  std::vector<Start> starts;
  for (const SweepRow& row : swept.rows)
    if (std::abs(row.value - eta) < 0.01 * swept.diagram.step)
      starts.push_back(
          {fmt::format("the sweep {} of figure {}", sweep_direction_name(row.direction), swept.diagram.figure), row.end});
  return starts;
}

}  // namespace graze::apps
