// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/graph/branch_graph.hpp>
#include <graze/continuation/graph/sweep_against_branches.hpp>
#include <graze/floquet/orbit/mirror.hpp>
#include <graze/lib/numerics/parallel.hpp>

#include <algorithm>

namespace graze {

namespace {

/// Whether the orbit lies on the branch that is the mirror image of this one and is not listed.
bool image_contains(const HybridSystem& system, const Branch& branch, const std::vector<Vector>& states, double value) {
  if (!branch.mirrored) return false;
  Vector p = branch.parameters;
  p[static_cast<Eigen::Index>(parameter_index(system.parameters, branch.parameter))] = value;
  const std::vector<Vector> image = mirror_image(system, p, *branch.mirrored, states);
  return !image.empty() && branch_contains(system, branch, image, value);
}

}  // namespace

SweepComparison compare_sweep_with_branches(const HybridSystem& system, const std::vector<Branch>& branches,
                                            const std::vector<SweepRow>& rows, int longest_period, int threads) {
  SweepComparison out;
  std::vector<std::size_t> compared;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].attractor.type != AttractorType::periodic) continue;
    if (rows[i].attractor.period > longest_period)
      ++out.longer;
    else
      compared.push_back(i);
  }
  out.compared = compared.size();
  std::vector<char> found(compared.size(), 0);
  in_parallel_on(threads, compared.size(), [&](std::size_t k) {
    const SweepRow& row = rows[compared[k]];
    // A branch of autonomous orbits stores states between the returns.
    const std::vector<Vector> states = is_forced(system) ? row.states : std::vector<Vector>{row.end};
    found[k] = std::any_of(branches.begin(), branches.end(), [&](const Branch& branch) {
      return branch_contains(system, branch, states, row.value) || image_contains(system, branch, states, row.value);
    });
  });
  for (std::size_t k = 0; k < compared.size(); ++k)
    if (!found[k]) out.rows.push_back(compared[k]);
  return out;
}

}  // namespace graze
