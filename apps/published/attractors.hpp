// SPDX-License-Identifier: GPL-3.0-or-later
// Attractors met at the parameters of a published figure, and the one of them that the source means.
#pragma once

#include <graze/apps/published/published.hpp>

#include <graze/floquet/attractor/attractor.hpp>

#include <functional>
#include <string>
#include <vector>

namespace graze::apps {

/// A state to start from, and where it comes from: "the printed state", "the sweep up", "rest".
struct Start {
  std::string origin;
  Vector state;
};

struct FoundAttractor {
  std::string origin;  ///< of the first start that led there
  Attractor attractor;
};

/// What is reached from the starts, each attractor once. Motions that are on no stable orbit after the transient count as one
/// attractor; their exponents are still to be averaged.
std::vector<FoundAttractor> attractors_from(const Problem& problem, const std::vector<Start>& starts,
                                            const AttractorOptions& options);

/// How well an attractor is what the source describes: 3: all that is said of it; 2: its period; 1: its type; 0: not at all.
int likeness(const Attractor& attractor, const PublishedAttractor& described);

/// Likeness 3.
bool is_described(const Attractor& attractor, const PublishedAttractor& described);

/// Above it no motion without impact exists: its amplitude exceeds the clearance. Empty where the model has no closed form, or no
/// such value.
std::optional<double> end_of_impactless(const Problem& problem);

/// The sentence that says so where eta lies above; else empty.
std::string no_impactless_motion(const Problem& problem, double eta);

/// The slowest impact of an orbit; 0 if it has none.
double slowest_impact(const PeriodicOrbit& orbit);

}  // namespace graze::apps
