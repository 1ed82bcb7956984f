// SPDX-License-Identifier: GPL-3.0-or-later
// Reports of a Poincare section: its columns, and the contents of graze.poincare/1.
#pragma once

#include <graze/apps/problem/problem.hpp>
#include <graze/apps/text/column.hpp>

#include <graze/lib/motion/poincare.hpp>

#include <string>
#include <vector>

namespace graze::apps {

/// The contents of graze.poincare/1 beside its head.
struct ListedSection {
  const PoincareSection& section;
  std::vector<std::string> columns;
};
const Columns<ListedSection>& listed_section_columns();
Json section_json(const Problem& problem, const PoincareSection& section);

/// Names of the columns of its points.
std::vector<std::string> section_columns(const Problem& problem, SectionKind kind);

}  // namespace graze::apps
