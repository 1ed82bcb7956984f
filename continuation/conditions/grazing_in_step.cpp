// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/conditions/grazing_in_step.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

namespace graze {

SpecialPoint grazing_point(const HybridSystem& system, const LocatedGrazing& located, int impacts_before, int impacts_after,
                           const Branch& branch) {
  SpecialPoint point;
  point.type = PointType::GR;
  point.after_point = branch.points.size() - 1;
  point.status = PointStatus::converged;
  point.newton = located.newton;
  point.value = located.u[located.u.size() - 1];
  point.precision = std::max(located.precision, 4e-16 * std::abs(point.value));
  point.interval[0] = point.value - point.precision;
  point.interval[1] = point.value + point.precision;
  point.orbit = located.orbit;
  // Its own check fails: a free run meets the contact that the orbit leaves out. It is a motion if the orbits beside it are.
  point.orbit.admissible = branch.points.back().admissible;
  point.touching = located.contacts;
  set_impacts(point, impacts_before, impacts_after);
  point.details["scenario"] = std::string(grazing_scenario_name(located.scenario));
  point.details["time"] = located.t;
  if (is_forced(system)) {
    const double T = forcing_period(system, point.orbit.parameters);
    point.details["phase"] = 2.0 * std::numbers::pi * std::fmod(located.t / T, 1.0);
  }
  return point;
}

GrazingInStep grazing_in_step(OrbitProblem& problem, const CurvePoint& before, const CurvePoint& after,
                              const BranchPoint& reached, const Branch& branch) {
  const BranchPoint& last = branch.points.back();
  const bool lost = reached.impacts < last.impacts;
  const int change = std::abs(reached.isolated_impacts - last.isolated_impacts);
  const Vector& with_impact = lost ? before.u : after.u;
  const double low = std::min(last.value, reached.value), high = std::max(last.value, reached.value), width = high - low;
  // A node within a contact cuts it in two: then the nodes are moved.
  const double section = problem.equations().section_phase();
  for (const double further : {0.0, 0.37, 0.71}) {
    const bool moving = further > 0.0;
    if (moving && problem.equations().autonomous()) break;
    std::optional<OrbitProblem> moved;
    if (moving) moved.emplace(problem.with_section(std::fmod(section + further, 1.0)));
    std::optional<Vector> u = moving ? problem.to_section(*moved, with_impact) : with_impact;
    // Contacts that graze together are tested one by one: with each on a stretch of its own, the others do not count before it.
    if (change > 1 && u) {
      OrbitProblem& coarse = moving ? *moved : problem;
      OrbitProblem fine = coarse.with_nodes(4);
      u = coarse.to_nodes(fine, *u);
      moved.emplace(std::move(fine));
    }
    OrbitProblem& here = moved ? *moved : problem;
    // The grazing contact need not be the weakest one yet.
    constexpr int considered = 4;
    const std::vector<GrazingGuess> guesses =
        u ? weakest_contacts(here, *u, change > 1 ? change : considered) : std::vector<GrazingGuess>{};
    const auto within_step = [&](const LocatedGrazing& found) {
      const double value = found.confirmed ? here.value(found.u) : std::numeric_limits<double>::quiet_NaN();
      return value >= low - 0.01 * width && value <= high + 0.01 * width;
    };
    LocatedGrazing located;
    for (std::size_t k = 0; k < guesses.size() && !within_step(located); ++k)
      if (k == 0 || change == 1) located = locate_grazing(here, *u, guesses[k]);
    if (!within_step(located)) continue;
    const double value = here.value(located.u);
    const auto apart = [&](const GrazingGuess& other) {
      const LocatedGrazing found = locate_grazing(here, *u, other);
      return !found.confirmed || std::abs(here.value(found.u) - value) > 1e-10 * here.size_of_value(value);
    };
    if (change > 1 && std::any_of(guesses.begin() + 1, guesses.end(), apart)) continue;
    const Vector along = before.u + (value - problem.value(before.u)) / problem.value(after.u - before.u) * (after.u - before.u);
    const Vector& place = moved ? along : located.u;
    return {place, grazing_point(problem.system(), located, last.impacts, reached.impacts, branch)};
  }
  SpecialPoint point;
  point.type = PointType::GR;
  point.after_point = branch.points.size() - 1;
  point.value = 0.5 * (low + high);
  point.precision = 0.5 * width;
  point.interval[0] = low;
  point.interval[1] = high;
  point.orbit = problem.orbit(with_impact);
  point.details["kind"] = lost ? "lost" : "gained";
  point.details["impacts"] = std::vector<double>{static_cast<double>(last.impacts), static_cast<double>(reached.impacts)};
  return {0.5 * (before.u + after.u), std::move(point)};
}

}  // namespace graze
