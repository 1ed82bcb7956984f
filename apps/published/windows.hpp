// SPDX-License-Identifier: GPL-3.0-or-later
// Published bifurcation diagrams beside sweeps: the attractors in each window of the printed diagram.
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

/// One row per window. A window agrees if the described attractor is found at every value of eta, in its direction or in both.
/// Attractors that the source's note also names (a window of period 10, a coexisting z = 2/3) count as described.
std::vector<Comparison> compare_windows(const SweptDiagram& swept);

/// The attractors of the sweeps at this value of eta, as states to start from.
std::vector<Start> starts_from(const SweptDiagram& swept, double eta);

}  // namespace graze::apps
