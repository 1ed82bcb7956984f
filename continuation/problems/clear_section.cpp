// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/problems/clear_section.hpp>
#include <graze/continuation/problems/orbit_problem.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace graze {

namespace {

/// The place within its stretches, as a fraction of a stretch, at which a motion without contacts comes nearest to one: there
/// the first contact will appear.
double nearest_approach(OrbitProblem& problem, const Vector& shortened, double length) {
  constexpr int samples = 32;
  ShootingEquations& equations = problem.equations();
  double nearest = -std::numeric_limits<double>::infinity(), place = 0.5;
  Transition transition;
  for (int j = 0; j < problem.nodes(); ++j) {
    const double start = equations.node_time(shortened, j), step = length / samples;
    Vector x = equations.node(shortened, j);
    for (int k = 0; k < samples; ++k) {
      for (const Event& event : problem.system()->events) {
        if (event.from != equations.stretch(j).mode0) continue;
        const double gap = event.guard.value(start + k * step, x, equations.parameters());
        if (!(gap > nearest)) continue;
        nearest = gap;
        place = static_cast<double>(k) / samples;
      }
      carry(equations.propagator(), start + k * step, start + (k + 1) * step, x, {.sensitivity = Sensitivity::none}, transition);
      if (transition.termination != Termination::time) return 0.5;
      x = transition.x1;
    }
  }
  return place;
}

}  // namespace

double clear_section(OrbitProblem& problem, const Vector& u) {
  const double current = problem.equations().section_phase();
  if (!problem.evaluate(u, {.sensitivity = Sensitivity::none, .keep_events = true})) return current;
  // Places of the events within their stretches, as fractions from the start of the stretch.
  const Vector shortened = problem.orbit_part(u);
  const double length = problem.equations().duration(shortened) / problem.nodes();
  std::vector<double> places;
  for (int j = 0; j < problem.nodes(); ++j)
    for (const EventRecord& event : problem.equations().stretch(j).events)
      places.push_back((event.t - problem.equations().node_time(shortened, j)) / length);
  if (places.empty()) places.push_back(nearest_approach(problem, shortened, length));
  std::sort(places.begin(), places.end());
  const double room = std::min(places.front(), 1.0 - places.back());
  constexpr double too_close = 0.02;
  if (room > too_close) return current;
  const Gap gap = widest_gap(places);
  if (0.5 * gap.length < 2.0 * room) return current;
  // One stretch is period / nodes forcing periods.
  return std::fmod(current + gap.middle * problem.period() / problem.nodes(), 1.0);
}

}  // namespace graze
