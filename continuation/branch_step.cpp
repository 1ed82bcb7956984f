// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/branch_step.hpp>
#include <graze/continuation/test_functions/test_function.hpp>
#include <graze/lib/transition.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace graze {

namespace {

/// Half of an orbit's states minus the other half: zero where a doubled orbit has collapsed onto its parent.
Vector antisymmetric_part(const Branch& branch, const std::vector<Vector>& states) {
  const std::size_t half = states.size() / 2;
  if (branch.period % 2 != 0 || states.size() % 2 != 0) return {};
  const Eigen::Index n = states.front().size();
  Vector difference(n * static_cast<Eigen::Index>(half));
  for (std::size_t j = 0; j < half; ++j) difference.segment(static_cast<Eigen::Index>(j) * n, n) = states[j] - states[j + half];
  return difference;
}

/// Number of real multipliers beyond -1 and beyond +1, and of complex ones outside the circle.
std::array<int, 3> unstable_kinds(const BranchPoint& point) {
  std::array<int, 3> count{};
  for (const auto& mu : nontrivial(point.multipliers)) {
    if (std::abs(mu) <= 1.0) continue;
    ++count[mu.imag() != 0.0 ? 2 : mu.real() < 0.0 ? 0 : 1];
  }
  return count;
}

/// Whether the events can be those of a symmetric orbit: each with another one, at the barrier opposite, half the period later.
bool may_be_symmetric(const Signature& signature) {
  const std::size_t half = signature.events.size() / 2;
  if (signature.events.size() % 2 != 0) return false;
  for (std::size_t k = 0; k < half; ++k)
    if (signature.events[k] == signature.events[k + half]) return false;
  return true;
}

/// How far the orbit is from its mirror image half its (odd) period later, relative to 1 + |x|. NaN where the motion cannot be
/// carried there.
double asymmetry(const HybridSystem& system, const Branch& branch, const BranchPoint& point) {
  Vector p = branch.parameters;
  p[static_cast<Eigen::Index>(parameter_index(system.parameters, branch.parameter))] = point.value;
  Propagator propagator(system, p);
  Transition transition;
  const Vector& start = point.states[static_cast<std::size_t>(branch.period / 2)];
  carry(propagator, 0.0, 0.5 * forcing_period(system, p), start, {.sensitivity = Sensitivity::none}, transition);
  if (transition.termination != Termination::time) return std::nan("");
  return (transition.x1 + point.state()).lpNorm<Eigen::Infinity>() / (1.0 + point.state().lpNorm<Eigen::Infinity>());
}

/// From a to b: states at phase 0 and parameter, in the arclength's own measure.
Vector between(const BranchPoint& a, const BranchPoint& b, double scale) {
  const auto count = static_cast<Eigen::Index>(a.states.size()), n = a.state().size();
  Vector out(count * n + 1);
  for (Eigen::Index j = 0; j < count; ++j) {
    const auto k = static_cast<std::size_t>(j);
    out.segment(j * n, n) = (b.states[k] - a.states[k]) / std::sqrt(static_cast<double>(count));
  }
  out[count * n] = (b.value - a.value) / scale;
  return out;
}

bool skips_something(const BranchStep& step) {
  const auto a = unstable_kinds(step.last()), b = unstable_kinds(step.next);
  return std::abs(a[0] - b[0]) > 1 || std::abs(a[1] - b[1]) > 1 || std::abs(a[2] - b[2]) > 2;
}

bool changes_symmetry(const HybridSystem& system, const BranchStep& step) {
  // Between the two a small enough step ends, if symmetry is lost without a branch point: by the parameter itself, or at a
  // branch point that was met exactly.
  constexpr double symmetric = 1e-8, broken = 1e-5;
  const Branch& branch = step.branch;
  if (!system.forcing_frequency || branch.period % 2 == 0) return false;
  if (step.last().signature.events.size() != step.next.signature.events.size()) return false;
  if (!may_be_symmetric(step.last().signature) || !may_be_symmetric(step.next.signature)) return false;
  const double before = asymmetry(system, branch, step.last());
  if (before < symmetric) return asymmetry(system, branch, step.next) > broken;
  return before > broken && asymmetry(system, branch, step.next) < symmetric;
}

}  // namespace

bool leaves_branch(const HybridSystem& system, const BranchStep& step) {
  return skips_something(step) || changes_symmetry(system, step);
}

bool goes_through_half(const BranchStep& step) {
  const BranchPoint &last = step.last(), &next = step.next;
  const Vector before = antisymmetric_part(step.branch, last.states), after = antisymmetric_part(step.branch, next.states);
  // Through zero, and not over it: where an impact passes phase 0 the states jump.
  const double within = 6.0 * std::sqrt(static_cast<double>(next.states.size())) * (next.arclength - last.arclength);
  return before.size() > 0 && before.dot(after) < 0.0 && before.lpNorm<Eigen::Infinity>() < within &&
         after.lpNorm<Eigen::Infinity>() < within;
}

std::optional<PassedPoint> passed_again(const BranchStep& step) {
  const std::vector<BranchPoint>& points = step.branch.points;
  const Vector chord = between(step.last(), step.next, step.scale);
  const double length = chord.norm();
  // A curve that turns by 0.3 at most from one end of the step to the other stays closer to the chord than this.
  double nearest = 0.1 * length;
  std::optional<PassedPoint> passed;
  const double around = nearest * step.scale, low = std::min(step.last().value, step.next.value) - around,
               high = std::max(step.last().value, step.next.value) + around;
  // The last point but one is where this step comes from.
  for (std::size_t k = 1; k + 2 < points.size(); ++k) {
    if (points[k].value < low || points[k].value > high) continue;  // most of a long branch
    const Vector there = between(step.last(), points[k], step.scale);
    const double part = chord.dot(there) / (length * length), distance = (there - part * chord).norm();
    if (!(part > 0.0 && part <= 1.0) || distance >= nearest) continue;
    if (between(points[k], points[k + 1], step.scale).dot(chord) <= 0.0) continue;
    nearest = distance;
    passed = PassedPoint{k, part};
  }
  return passed;
}

bool same_states(const BranchPoint& a, const BranchPoint& b) {
  if (a.states.size() != b.states.size()) return false;
  for (std::size_t k = 0; k < a.states.size(); ++k)
    if ((a.states[k] - b.states[k]).lpNorm<Eigen::Infinity>() > 1e-8 * (1.0 + a.states[k].lpNorm<Eigen::Infinity>()))
      return false;
  return true;
}

}  // namespace graze
