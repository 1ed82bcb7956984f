// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/basins/basin_shares.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace graze {

Basins with_shares(Basins basins) {
  for (CoexistingAttractor& found : basins.attractors) found.count = 0;
  basins.admissible = basins.lost = 0;
  basins.complete = true;
  for (const StartOutcome& outcome : basins.outcomes) {
    if (outcome.fate == Fate::reached) ++basins.attractors[outcome.attractor].count;
    if (outcome.fate == Fate::lost) ++basins.lost;
    if (outcome.fate == Fate::reached || outcome.fate == Fate::lost) ++basins.admissible;
    if (outcome.fate == Fate::not_run) basins.complete = false;
  }
  for (CoexistingAttractor& found : basins.attractors) {
    const auto N = static_cast<double>(basins.admissible), f = static_cast<double>(found.count) / N;
    found.fraction = f;
    found.fraction_error = std::sqrt(f * (1.0 - f) / N);
  }
  std::vector<std::size_t> order(basins.attractors.size());
  std::vector<std::uint32_t> place(order.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto before = [&](std::size_t a, std::size_t b) {
    const CoexistingAttractor &A = basins.attractors[a], &B = basins.attractors[b];
    if (A.count != B.count) return A.count > B.count;
    return std::lexicographical_compare(A.attractor.state.begin(), A.attractor.state.end(), B.attractor.state.begin(),
                                        B.attractor.state.end());
  };
  std::sort(order.begin(), order.end(), before);
  std::vector<CoexistingAttractor> sorted;
  for (std::size_t i = 0; i < order.size(); ++i) {
    place[order[i]] = static_cast<std::uint32_t>(i);
    sorted.push_back(std::move(basins.attractors[order[i]]));
  }
  basins.attractors = std::move(sorted);
  for (StartOutcome& outcome : basins.outcomes)
    if (outcome.fate == Fate::reached) outcome.attractor = place[outcome.attractor];
  return basins;
}

}  // namespace graze
