// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/published/attractors.hpp>
#include <graze/apps/results/attractor_report.hpp>
#include <graze/apps/results/orbit_report.hpp>
#include <graze/apps/text/number.hpp>

#include <graze/floquet/orbit/shooting.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace graze::apps {

std::vector<FoundAttractor> attractors_from(const Problem& problem, const std::vector<Start>& starts,
                                            const AttractorOptions& options) {
  std::vector<FoundAttractor> list;
  for (const Start& start : starts) {
    Attractor found;
    try {
      found = approach_attractor(problem.system, problem.parameters, start.state, options);
    } catch (const std::invalid_argument&) {  // a printed state, rounded, may lie beyond a hard stop
      continue;
    }
    if (found.termination != Termination::time) continue;
    const bool known = std::any_of(list.begin(), list.end(), [&](const FoundAttractor& other) {
      if (found.type != other.attractor.type) return false;
      return found.type != AttractorType::periodic || same_orbit(*found.orbit->whole, *other.attractor.orbit->whole);
    });
    if (!known) list.push_back({start.origin, std::move(found)});
  }
  return list;
}

int match_level(const Attractor& attractor, const PublishedAttractor& described) {
  if (described.type == "chaotic") return attractor.type == AttractorType::periodic ? 0 : 3;
  if (attractor.type != AttractorType::periodic) return 0;
  if (described.type == "impactless") return attractor.impacts == 0 ? 3 : 1;
  if (attractor.impacts == 0) return 0;
  if (described.periods == 0) return 3;
  if (attractor.period != described.periods) return 1;
  return !described.z || attractor.impacts == (*described.z)[0] ? 3 : 2;
}

bool is_described(const Attractor& attractor, const PublishedAttractor& described) {
  return match_level(attractor, described) == 3 && (described.type != "chaotic" || attractor.type == AttractorType::chaotic);
}

std::optional<double> end_of_impactless(const Problem& problem) {
  if (parameter(problem, "beta") != 0.0) return std::nullopt;
  // xi^2 = r^2 ((1 - eta^2)^2 + (2 b eta)^2), the smaller root in eta^2.
  const double b = parameter(problem, "b"), r = parameter(problem, "r"), xi = parameter(problem, "xi");
  const double half = 1.0 - 2.0 * b * b, root = half * half - 1.0 + xi * xi / (r * r);
  const double square = half - std::sqrt(root);
  return root >= 0.0 && square > 0.0 ? std::optional(std::sqrt(square)) : std::nullopt;
}

std::string no_impactless_motion(const Problem& problem, double eta) {
  const auto end = end_of_impactless(problem);
  if (!end || !(eta > *end)) return {};
  return fmt::format("no motion without impact exists above eta = {}: its amplitude exceeds the clearance", rounded(*end, 9));
}

double slowest_impact(const PeriodicOrbit& orbit) {
  double slowest = 0.0;
  for (const EventRecord& event : orbit.events)
    if (begins_contact(event.kind) && (slowest == 0.0 || event.normal_speed < slowest)) slowest = event.normal_speed;
  return slowest;
}

}  // namespace graze::apps
