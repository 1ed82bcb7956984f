// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/branch_graph.hpp>
#include <graze/continuation/orbit_problem.hpp>
#include <graze/lib/transition.hpp>

#include <algorithm>

namespace graze {

namespace {

/// The same states a fraction of a forcing period later; empty where the motion cannot be carried on.
std::vector<Vector> later(const HybridSystem& system, const Vector& p, const std::vector<Vector>& states, double fraction) {
  if (fraction == 0.0) return states;
  Propagator propagator(system, p);
  const double T = forcing_period(system, p);
  std::vector<Vector> out;
  Transition transition;
  for (const Vector& x : states) {
    carry(propagator, 0.0, fraction * T, x, {.sensitivity = Sensitivity::none}, transition);
    if (transition.termination != Termination::time) return {};
    out.push_back(transition.x1);
  }
  return out;
}

/// States on the chord from a to b at s, shifted by the number of forcing periods at which they come closest to the orbit's:
/// empty unless that is close enough for the orbit to lie on the curve between the two.
std::vector<Vector> matching_states(const std::vector<Vector>& a, const std::vector<Vector>& b, double s,
                                    const std::vector<Vector>& orbit) {
  const std::size_t n = orbit.size();
  if (a.size() != n || b.size() != n) return {};
  double step = 0.0;
  for (std::size_t k = 0; k < n; ++k) step = std::max(step, (b[k] - a[k]).lpNorm<Eigen::Infinity>());
  // Between two points the curve stays closer to its chord than half its length; Newton then decides.
  double closest = 0.5 * step + 1e-6;
  std::vector<Vector> best;
  for (std::size_t shift = 0; shift < n; ++shift) {
    std::vector<Vector> between;
    double distance = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t j = (k + shift) % n;
      between.push_back(a[j] + s * (b[j] - a[j]));
      distance = std::max(distance, (between.back() - orbit[k]).lpNorm<Eigen::Infinity>());
    }
    if (distance > closest) continue;
    closest = distance;
    best = std::move(between);
  }
  return best;
}

}  // namespace

bool lies_on(const HybridSystem& system, const Branch& branch, const std::vector<Vector>& states, double value) {
  if (states.size() != static_cast<std::size_t>(branch.period)) return false;
  const std::size_t parameter = parameter_index(system.parameters, branch.parameter);
  const auto at = [&](double v) {
    Vector p = branch.parameters;
    p[static_cast<Eigen::Index>(parameter)] = v;
    return p;
  };
  TraceOptions patient;
  patient.max_iterations = 20;
  for (std::size_t i = 0; i + 1 < branch.points.size(); ++i) {
    const BranchPoint &a = branch.points[i], &b = branch.points[i + 1];
    if (a.value == b.value || value < std::min(a.value, b.value) || value > std::max(a.value, b.value)) continue;
    const double s = (value - a.value) / (b.value - a.value);
    // Where a hard impact passes phase 0 between a and b, the states there jump: then those at another phase tell.
    for (const double phase : {0.0, 0.37}) {
      if (phase > 0.0 && !system.forcing_frequency) continue;
      const std::vector<Vector> here = later(system, at(value), states, phase);
      const std::vector<Vector> guess = here.empty() ? here
                                                     : matching_states(later(system, at(a.value), a.states, phase),
                                                                       later(system, at(b.value), b.states, phase), s, here);
      if (guess.empty()) continue;
      const int n = static_cast<int>(guess.size());
      OrbitProblem problem(system, at(value), branch.period, n, parameter, 1.0, {}, phase);
      Vector u = problem.pack(guess, a.duration + s * (b.duration - a.duration), value);
      if (!system.forcing_frequency) problem.equations().set_phase_reference(guess.front());
      if (!correct(problem.zero_problem(), problem.parameter_direction(), u, patient).converged()) continue;
      double distance = 0.0, scale = 1.0;
      for (int k = 0; k < n; ++k) {
        const Vector& state = here[static_cast<std::size_t>(k)];
        distance = std::max(distance, (u.segment(k * problem.states(), problem.states()) - state).lpNorm<Eigen::Infinity>());
        scale = std::max(scale, 1.0 + state.lpNorm<Eigen::Infinity>());
      }
      // Next to a hard grazing Newton may end on the family with one impact more or less.
      const int impacts = problem.orbit(u, {}).impacts;
      if (distance < 1e-6 * scale && (impacts == a.impacts || impacts == b.impacts)) return true;
    }
  }
  return false;
}

}  // namespace graze
