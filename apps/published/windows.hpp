// SPDX-License-Identifier: GPL-3.0-or-later
// Published bifurcation diagrams beside sweeps: what each window of the printed diagram holds.
#pragma once

#include <graze/apps/published/attractors.hpp>
#include <graze/apps/published/comparison.hpp>

#include <graze/floquet/follow/sweep.hpp>

#include <vector>

namespace graze::apps {

/// A diagram and the sweeps up and down along it.
struct SweptDiagram {
  PublishedDiagram diagram;
  Problem problem;
  std::vector<SweepRow> rows;
};

/// One row per window: it agrees where at every value of eta, in its direction or in both, the attractor is the one described;
/// what the source's note names beside it (a window of period 10, z = 2/3 that coexists) counts as described too.
std::vector<Comparison> compare_windows(const SweptDiagram& swept);

/// The attractors of the sweeps at this value of eta, as states to start from.
std::vector<Start> starts_from(const SweptDiagram& swept, double eta);

}  // namespace graze::apps
