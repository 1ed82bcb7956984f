// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/branch/branch_step.hpp>
#include <graze/continuation/conditions/test_function.hpp>
#include <graze/floquet/orbit/mirror.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace graze {

namespace {

/// Numbers of real multipliers below -1, of real ones above +1, and of complex ones outside the unit circle.
std::array<int, 3> unstable_kinds(const BranchPoint& point) {
  std::array<int, 3> count{};
  for (const auto& mu : nontrivial(point.multipliers)) {
    if (std::abs(mu) <= 1.0) continue;
    ++count[mu.imag() != 0.0 ? 2 : mu.real() < 0.0 ? 0 : 1];
  }
  return count;
}

/// True if the events can be those of a symmetric orbit: each has a partner at the opposite barrier, half the period later.
bool may_be_symmetric(const Signature& signature) {
  const std::size_t half = signature.events.size() / 2;
  if (signature.events.size() % 2 != 0) return false;
  for (std::size_t k = 0; k < half; ++k)
    if (signature.events[k] == signature.events[k + half]) return false;
  return true;
}

/// Distance of the orbit from its mirror image, relative to 1 + |x|. The image is taken half its (odd) period later if the
/// symmetry has a shift; without forcing at once or half its period later, whichever is nearer. NaN if the motion cannot be
/// carried there.
double asymmetry(const HybridSystem& system, const Symmetry& symmetry, const Branch& branch, const BranchPoint& point) {
  Vector p = branch.parameters;
  p[static_cast<Eigen::Index>(parameter_index(system.parameters, branch.parameter))] = point.value;
  Propagator propagator(system, p);
  const auto distance = [&](const Vector& image) {
    return (image - point.state()).lpNorm<Eigen::Infinity>() / (1.0 + point.state().lpNorm<Eigen::Infinity>());
  };
  const std::size_t half = symmetry.shift == 0.0 ? 0 : static_cast<std::size_t>(branch.period / 2);
  const auto mirrored = mirrored_state(propagator, symmetry, point.states[half]);
  if (!mirrored) return std::nan("");
  if (is_forced(system)) return distance(*mirrored);
  Transition transition;
  carry(propagator, 0.0, 0.5 * point.duration, *mirrored, {.sensitivity = Sensitivity::none}, transition);
  if (transition.termination != Termination::time) return std::nan("");
  return std::min(distance(*mirrored), distance(transition.x1));
}

bool skips_bifurcation(const BranchPoint& last, const BranchPoint& next) {
  const auto a = unstable_kinds(last), b = unstable_kinds(next);
  // A complex pair outside the unit circle that meets on the real axis and separates there crosses the circle nowhere.
  for (const std::size_t real : {0, 1})
    if (a[real] + a[2] == b[real] + b[2] && a[1 - real] == b[1 - real] && std::abs(a[2] - b[2]) == 2) return false;
  return std::abs(a[0] - b[0]) > 1 || std::abs(a[1] - b[1]) > 1 || std::abs(a[2] - b[2]) > 2;
}

bool changes_symmetry(const HybridSystem& system, const Symmetry& symmetry, const Branch& branch, const BranchPoint& next) {
  // A sufficiently small step ends between these two bounds where symmetry is lost without a branch point: through the
  // parameter itself, or at a branch point that was met exactly.
  constexpr double symmetric = 1e-8, broken = 1e-5;
  const BranchPoint& last = branch.points.back();
  if (last.signature.events.size() != next.signature.events.size()) return false;
  if (symmetry.shift != 0.0) {
    if (branch.period % 2 == 0) return false;
    if (!may_be_symmetric(last.signature) || !may_be_symmetric(next.signature)) return false;
  }
  const double before = asymmetry(system, symmetry, branch, last);
  if (before < symmetric) return asymmetry(system, symmetry, branch, next) > broken;
  return before > broken && asymmetry(system, symmetry, branch, next) < symmetric;
}

}  // namespace

bool leaves_branch(const HybridSystem& system, std::span<const Symmetry> symmetries, const Branch& branch,
                   const BranchPoint& next) {
  return skips_bifurcation(branch.points.back(), next) ||
         std::any_of(symmetries.begin(), symmetries.end(),
                     [&](const Symmetry& symmetry) { return changes_symmetry(system, symmetry, branch, next); });
}

std::optional<double> zero_crossing(const Vector& before, const Vector& after) {
  // A curve that turns by at most 0.3 within the step stays closer to its chord than this fraction of the chord.
  constexpr double bend = 0.1;
  if (before.size() == 0 || after.size() == 0 || !(before.dot(after) < 0.0)) return std::nullopt;
  const Vector chord = after - before;
  const double part = -before.dot(chord) / chord.squaredNorm();
  if (!((before + part * chord).norm() < bend * chord.norm())) return std::nullopt;
  return part;
}

std::vector<CurvePoint> images_of(const BranchProblem& problem, const CurvePoint& point) {
  std::vector<CurvePoint> list;
  for (BranchProblem::Image& image : problem.images(point.u, point.tangent)) {
    CurvePoint same = point;
    same.u = std::move(image.u);
    same.tangent = std::move(image.tangent);
    list.push_back(std::move(same));
  }
  return list;
}

}  // namespace graze
