// SPDX-License-Identifier: GPL-3.0-or-later
// Attractors found at the parameters of a published figure, and the choice of the one that the source describes.
#pragma once

#include <graze/apps/published/published.hpp>

#include <graze/floquet/attractor/attractor.hpp>

#include <functional>
#include <string>
#include <vector>

namespace graze::apps {

/// A state to start from, and its origin: "the printed state", "the sweep up", "rest".
struct Start {
  std::string origin;
  Vector state;
};

struct FoundAttractor {
  std::string origin;  ///< origin of the first start that reached it
  Attractor attractor;
};

/// The attractors reached from the starts, each once. Motions that are not on a stable orbit after the transient count as one
/// attractor; their exponents are not averaged yet.
std::vector<FoundAttractor> attractors_from(const Problem& problem, const std::vector<Start>& starts,
                                            const AttractorOptions& options);

/// How well an attractor matches the description of the source: 3: in every respect; 2: its period; 1: its type; 0: not at all.
int match_level(const Attractor& attractor, const PublishedAttractor& described);

/// Whether the likeness is 3.
bool is_described(const Attractor& attractor, const PublishedAttractor& described);

/// The eta above which no motion without impact exists, because its amplitude exceeds the clearance. Empty if the model has no
/// closed form, or no such value.
std::optional<double> end_of_impactless(const Problem& problem);

/// A sentence on this if eta lies above it; otherwise empty.
std::string no_impactless_motion(const Problem& problem, double eta);

/// The speed of an orbit's slowest impact; 0 if it has none.
double slowest_impact(const PeriodicOrbit& orbit);

}  // namespace graze::apps
