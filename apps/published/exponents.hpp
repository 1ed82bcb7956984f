// SPDX-License-Identifier: GPL-3.0-or-later
// Published exponents beside computed ones: on the attractor that the source means, as far as it is there, exact where it is
// periodic. Where they differ, the remark says what is known: another attractor, a sign lost in print, how far eta would have to
// move, the bifurcation next to it, by how much the source's rule of stopping scatters.
#pragma once

#include <graze/apps/published/attractors.hpp>
#include <graze/apps/published/comparison.hpp>

#include <functional>
#include <optional>
#include <vector>

namespace graze::apps {

struct ExponentsOptions {
  int transient = 5000;                ///< forcing periods before anything is measured, as in the source
  double standard_error = 1e-4;        ///< wanted of an average
  std::int64_t max_periods = 1000000;  ///< of one average
  int source_runs = 8;                 ///< averages stopped by the source's rule, from as many states of a chaotic motion
  std::function<bool()> cancelled = {};
};

/// `starts`: see attractors_from. details.computed_attractor says which attractor is compared, details.beta and eta where.
/// @throws std::invalid_argument for a system that is not there.
Comparison compare_exponents(const Published& published, const PublishedExponents& item, const std::vector<Start>& starts,
                             const ExponentsOptions& options);

}  // namespace graze::apps
