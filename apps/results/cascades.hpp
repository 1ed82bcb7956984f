// SPDX-License-Identifier: GPL-3.0-or-later
// Cascades: successive period doublings, and how fast their distances shrink.
#pragma once

#include <graze/apps/text/column.hpp>

#include <graze/continuation/problems/branch.hpp>

#include <string>
#include <vector>

namespace graze::apps {

/// The limit of the ratios in every cascade of a smooth family.
constexpr double feigenbaum = 4.669201609102990;

struct Doubling {
  std::string label;
  int branch = 0, period = 0;  ///< the branch on which the doubling lies, and the period of the orbits there
  double value = 0.0;
};

/// Each doubling lies on the branch that begins at the previous doubling (or ends there, if it was followed from its other
/// end). If there are several on a branch, the first one met from that end is taken; the others belong to cascades of their
/// own.
struct Cascade {
  std::vector<Doubling> points;
  /// (a[k] - a[k-1]) / (a[k+1] - a[k]) of the values a.
  std::vector<double> ratios() const;
};

/// Cascades of at least three doublings, in the order of the branches on which they begin.
std::vector<Cascade> cascades(const std::vector<Branch>& branches);

const Columns<Doubling>& doubling_columns();
const Columns<Cascade>& cascade_columns();
template <> struct JsonForm<Doubling> : RecordForm<Doubling, doubling_columns> {};
template <> struct JsonForm<Cascade> : RecordForm<Cascade, cascade_columns> {};

/// A table of each cascade, with Feigenbaum's constant; empty if there are none.
std::string cascades_text(const std::vector<Cascade>& list, const std::string& parameter);

}  // namespace graze::apps
