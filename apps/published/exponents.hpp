// SPDX-License-Identifier: GPL-3.0-or-later
// Published exponents beside computed ones: on the attractor that the source describes, if it exists, and exact if that is
// periodic. If they differ, the remark states the known reasons: another attractor, a sign lost in print, the required change
// in eta, a nearby bifurcation, the scatter of the source's stopping rule.
#pragma once

#include <graze/apps/published/attractors.hpp>
#include <graze/apps/published/comparison.hpp>

#include <functional>
#include <optional>
#include <vector>

namespace graze::apps {

struct ExponentsOptions {
  int transient = 5000;                ///< forcing periods before any measurement, as in the source
  double standard_error = 1e-4;        ///< requested of an average
  std::int64_t max_periods = 1000000;  ///< of one average
  int source_runs = 8;  ///< number of averages stopped by the source's rule, each from another state of a chaotic motion
  std::function<bool()> cancelled = {};
};

/// `starts`: see attractors_from. details.computed_attractor names the attractor compared, details.beta and eta its parameters.
/// @throws std::invalid_argument for an unknown system.
Comparison compare_exponents(const Published& published, const PublishedExponents& item, const std::vector<Start>& starts,
                             const ExponentsOptions& options);

}  // namespace graze::apps
