// SPDX-License-Identifier: GPL-3.0-or-later
// PD, period doubling: a multiplier passes -1. Test function: the product of (1 + mu) over all multipliers.
//
// The criticality follows from the normal form xi -> -xi + c xi^3 on the centre manifold (Kuznetsov, Elements of Applied
// Bifurcation Theory, 3rd ed., eq. (5.46)-(5.47)): with M q = -q, M^T p = -p, p.q = 1,
//     c = p . [C(q, q, q) + 3 B(q, (I - M)^{-1} B(q, q))] / 6;   c > 0: supercritical, c < 0: subcritical.
// B and C are central differences of the (exact) Jacobian of the period-n map along q.
//
// Beside a grazing this map bends over lengths proportional to the square of the weak impact's speed, and finite differences
// fail. In the coordinates of the events the equations H of the orbit traversed twice are smooth there. With K(-1) v = 0,
// w^H K(-1) = 0, phi = (v, -v), psi = (w, -w) and H_u h2 = -H_uu phi phi, the Lyapunov-Schmidt reduction gives the same
// coefficient, for the amplitude along phi:
//     c = -psi . [H_uuu phi phi phi + 3 H_uu phi h2] / (12 w . (dK/dsigma) v).
#include <graze/continuation/conditions/multiplier_equations.hpp>
#include <graze/continuation/conditions/own_coordinates.hpp>
#include <graze/continuation/conditions/test_function.hpp>
#include <graze/lib/numerics/null_vectors.hpp>

#include <graze/continuation/problems/orbit_problem.hpp>

#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

namespace graze {

namespace {

/// The multiplier -1 is double (as without damping) if its left and right unit vectors are normal to each other up to the square
/// root of rounding. It has no such normal form.
constexpr double least_overlap = 1e-6;

struct NormalForm {
  double c = 0.0;
  double error = 0.0;  ///< change of c when the difference step is halved
  /// Whether c exceeds its error by a factor of 10. The factor is needed because the error is estimated, not bounded.
  bool decides() const { return std::isfinite(c) && std::abs(c) > 10.0 * error; }
};

/// The coefficient by finite differences with Richardson extrapolation, from steps h = 4e-3, 2e-3, ... down to 1e-5. A step
/// must stay within the orbit's signature (else `coefficient` is empty), and must be large against rounding. The first step
/// with an error of at most c / 100 is taken, or else the step with the smallest relative error. Empty if no step is usable.
std::optional<NormalForm> extrapolate_differences(const std::function<std::optional<double>(double h)>& coefficient) {
  constexpr double largest = 4e-3, smallest = 1e-5, accurate = 1e-2;
  std::optional<NormalForm> best;
  for (double h = largest; h > smallest; h *= 0.5) {
    const auto coarse = coefficient(h), fine = coefficient(h / 2);
    if (!coarse || !fine || !std::isfinite(*coarse) || !std::isfinite(*fine)) continue;
    const NormalForm form{(4.0 * *fine - *coarse) / 3.0, std::abs(*fine - *coarse)};
    if (!best || form.error * std::abs(best->c) < best->error * std::abs(form.c)) best = form;
    if (form.error <= accurate * std::abs(form.c)) break;
  }
  return best;
}

/// The coefficient of the period-n map in states. Empty if the signature changes within every difference step, or if the
/// multiplier is double.
std::optional<NormalForm> normal_form(OrbitProblem& problem, const Vector& u) {
  const int n = problem.states();
  ShootingEquations& equations = problem.equations();
  const double duration = equations.duration(problem.orbit_part(u));
  const double start = equations.node_time(problem.orbit_part(u), 0);
  const Vector x0 = u.head(n);
  Transition transition;
  std::vector<std::size_t> sequence;
  const auto jacobian = [&](const Vector& x) -> std::optional<Matrix> {
    carry(equations.propagator(), start, start + duration, x, {.sensitivity = Sensitivity::state}, transition);
    if (transition.termination != Termination::time) return std::nullopt;
    if (sequence.empty()) sequence = transition.event_sequence;
    if (transition.event_sequence != sequence) return std::nullopt;
    return transition.Phi;
  };
  const std::optional<Matrix> M = jacobian(x0);
  if (!M) return std::nullopt;
  // Left and right eigenvectors for -1: null vectors of M + I.
  const NullVectors<Matrix> null = null_vectors(Matrix(*M + Matrix::Identity(n, n)));
  const Vector& q = null.right;
  Vector p = null.left;
  if (std::abs(p.dot(q)) < least_overlap * p.norm() * q.norm()) return std::nullopt;
  p /= p.dot(q);
  Matrix I_minus_M = Matrix::Identity(n, n) - *M;
  for (const PinnedState& pin : problem.pinned()) I_minus_M.row(pin.state.index) = pin.state.gradient(n);
  const Eigen::PartialPivLU<Matrix> second_order(I_minus_M);
  return extrapolate_differences([&](double h) -> std::optional<double> {
    const auto ahead = jacobian(x0 + h * q), behind = jacobian(x0 - h * q);
    if (!ahead || !behind) return std::nullopt;
    const Matrix along = (*ahead - *behind) / (2.0 * h);
    const Matrix second = (*ahead - 2.0 * *M + *behind) / (h * h);
    const Vector h2 = second_order.solve(along * q);
    return (p.dot(second * q) + 3.0 * p.dot(along * h2)) / 6.0;
  });
}

/// The coefficient in the branch's own coordinates, by the Lyapunov-Schmidt reduction.
std::optional<NormalForm> normal_form_by_events(BranchProblem& problem, const LocatedPoint& located) {
  const BranchProblem::Doubled doubled = problem.doubled(located.u);
  const ZeroProblem zero = doubled.problem->zero_problem();
  const Eigen::Index size = doubled.problem->orbit_unknowns(), half = size / 2;
  const Vector v = located.v.real(), w = located.w.real();
  Vector phi = Vector::Zero(doubled.u.size()), psi(size);
  phi.head(size) << v, -v;
  psi << w, -w;
  const auto jacobian = [&](double h) -> std::optional<Matrix> {
    Vector residual;
    Matrix J;
    if (!zero.evaluate(doubled.u + h * phi, residual, &J)) return std::nullopt;
    return Matrix(J.leftCols(size));
  };
  const std::optional<Matrix> J = jacobian(0.0);
  if (!J) return std::nullopt;
  Matrix bordered(size + 1, size + 1);
  bordered << *J, psi, phi.head(size).transpose(), 0.0;
  const OrbitLU<Matrix> second_order(bordered);
  const Matrix dK = (problem.cyclic(located.u, 1.0) - problem.cyclic(located.u, 0.0)).real();
  const double denominator = 12.0 * w.dot(dK * v);
  if (half != v.size() || !(std::abs(denominator) > 12.0 * least_overlap * w.norm() * (dK * v).norm())) return std::nullopt;
  return extrapolate_differences([&](double h) -> std::optional<double> {
    const auto ahead = jacobian(h), behind = jacobian(-h);
    if (!ahead || !behind) return std::nullopt;
    const Matrix along = (*ahead - *behind) / (2.0 * h), second = (*ahead - 2.0 * *J + *behind) / (h * h);
    Vector right(size + 1);
    right << -along * phi.head(size), 0.0;
    const Vector h2 = second_order.solve(right).head(size);
    return -(psi.dot(second * phi.head(size)) + 3.0 * psi.dot(along * h2)) / denominator;
  });
}

void describe(BranchProblem& problem, const LocatedPoint& located, SpecialPoint& point) {
  const auto verdict = [&](const NormalForm& form, const char* from) {
    point.details.insert_or_assign("criticality", std::string(form.c > 0.0 ? "supercritical" : "subcritical"));
    point.details.insert_or_assign("criticality_from", std::string(from));
  };
  Vector u;
  OrbitProblem& states = problem.stroboscopic(located.u, u);
  const std::optional<NormalForm> form = normal_form(states, u);
  if (form && form->decides()) {
    point.details["normal_form"] = form->c;
    point.details["normal_form_error"] = form->error;
    verdict(*form, "normal form");
  }
  if (&problem == static_cast<BranchProblem*>(&states)) return;
  const std::optional<NormalForm> smooth = normal_form_by_events(problem, located);
  if (!smooth || !smooth->decides() || (form && form->decides() && (form->c > 0.0) == (smooth->c > 0.0))) return;
  // The signs differ, or the first form does not decide: the map of states at fixed phases bends too sharply for differences.
  point.details.erase("normal_form");
  point.details.erase("normal_form_error");
  verdict(*smooth, "normal form in the coordinates of the events");
}

/// The orbit traversed twice, pushed apart along the eigenvector of -1. The corrector's arclength condition keeps the push, so
/// that the corrector cannot return to the parent. An orbit with hard impacts is pushed in the coordinates of its events. The
/// push is so small that the doubled orbit has twice the impacts; if no push achieves this, the period doubling lies on a grazing
/// and the result is empty. `parent`: the equations of the orbit that doubles, in states.
std::optional<BranchStart> doubled_start(const SpecialPoint& pd, OrbitProblem& parent, const TraceOptions& options) {
  OwnCoordinates own = own_coordinates(pd, parent);
  const Vector& u = own.u;
  std::optional<SignatureProblem>& by_events = own.by_events;
  BranchProblem& problem = by_events ? static_cast<BranchProblem&>(*by_events) : parent;
  const LocatedPoint located = locate(problem, *multiplier_equations({.theta = std::numbers::pi}), u);
  if (located.v.size() == 0) return std::nullopt;
  if (by_events && !located.newton.converged()) return std::nullopt;
  const BranchProblem::Doubled doubled = problem.doubled(by_events ? located.u : u);
  Vector direction = Vector::Zero(doubled.u.size());
  const Vector v = located.v.real();
  direction.head(2 * v.size()) << v, -v;
  const ZeroProblem zero = doubled.problem->zero_problem();
  direction /= weighted_norm(zero.weights, direction);
  // The push and the steps after it are small, because in a cascade the next bifurcation may follow closely. The parameter
  // grows with the square of the push, and fast beside a grazing; the smallest push is near the level of rounding.
  for (const double push : {2e-4, 5e-5, 1e-5, 2e-6, 2e-7, 2e-8, 1e-3}) {
    BranchStart start;
    start.u = doubled.u + push * direction;
    start.step = push;
    if (!correct(zero, direction, start.u, options).converged()) continue;
    start.orientation = start.u - doubled.u;
    // A correction as long as the push has converged to another orbit.
    if (!(weighted_norm(zero.weights, start.orientation) < 1.5 * push)) continue;
    if (!doubled.problem->is_motion(start.u)) continue;
    start.sequence = doubled.problem->sequence();
    // If it does not have twice the impacts of its parent, it lies beyond a grazing or on another family.
    const BranchPoint first = doubled.problem->branch_point(start.u, 0.0);
    if (first.impacts != 2 * pd.orbit.impacts) continue;
    start.states = first.states;
    return start;
  }
  return std::nullopt;
}

/// Compares the side of `pd` on which the doubled branch `child` lies with the normal form's prediction, and writes the result
/// to the details of `pd`.
void confirm_criticality(const Branch& child, SpecialPoint& pd, const Branch& parent, bool begins) {
  if (child.points.empty()) return;
  const std::size_t k = pd.after_point;
  if (k + 1 >= parent.points.size()) return;
  const BranchPoint &before = parent.points[k], &after = parent.points[k + 1];
  const bool unstable_above = (after.multipliers.unstable() > before.multipliers.unstable()) == (after.value > before.value);
  // Up to its nearest fold the doubled branch stays on one side, and there it is farthest away. Next to its birth its error is
  // the corrector's tolerance divided by the distance from the parent.
  const auto is_fold = [](const SpecialPoint& point) { return point.type == PointType::LP; };
  std::size_t farthest = begins ? child.points.size() - 1 : 0;
  if (begins) {
    const auto fold = std::find_if(child.special_points.begin(), child.special_points.end(), is_fold);
    if (fold != child.special_points.end()) farthest = std::min(farthest, fold->after_point);
  } else {
    const auto fold = std::find_if(child.special_points.rbegin(), child.special_points.rend(), is_fold);
    if (fold != child.special_points.rend()) farthest = std::min(child.points.size() - 1, fold->after_point + 1);
  }
  const double away = child.points[farthest].value - pd.value;
  if (!(std::abs(away) > 4.0 * pd.precision)) return;
  const bool child_above = away > 0.0;
  // Supercritical: the doubled orbit exists where its parent is unstable.
  const std::string seen = unstable_above == child_above ? "supercritical" : "subcritical";
  const auto predicted = pd.details.find("criticality");
  if (predicted == pd.details.end()) {
    pd.details.insert_or_assign("criticality", seen);
    pd.details.insert_or_assign("criticality_from", std::string("branch"));
    return;
  }
  const bool agrees = std::get<std::string>(predicted->second) == seen;
  const char* from = agrees ? "normal form, confirmed by the branch" : "normal form; the branch starts on the other side";
  pd.details.insert_or_assign("criticality_from", std::string(from));
}

}  // namespace

TestFunction period_doubling_test() {
  TestFunction test;
  test.type = PointType::PD;
  test.summary = "period doubling: the product of (1 + multiplier) passes zero (a multiplier passes -1)";
  test.value = [](const TestPoint& point) {
    std::complex<double> product = 1.0;
    for (const auto& mu : nontrivial(point.branch.multipliers)) product *= (1.0 + mu) / (1.0 + std::abs(mu));
    return product.real();
  };
  test.confirm = [](const TestPoint& before, const TestPoint& after) {
    return (real_beyond(before, -1) + real_beyond(after, -1)) % 2 == 1;
  };
  test.distance = [](const BranchPoint& point) { return nearest_multiplier(point, -1.0); };
  test.equations = [](const TestPoint&) { return multiplier_equations({.theta = std::numbers::pi}); };
  test.describe = describe;
  Birth doubled{.multiple = 2, .certain = true, .missing = "no doubled orbit was found"};
  doubled.start = [](const SpecialPoint& pd, const Branch&, OrbitProblem& states, int, const TraceOptions& options) {
    return doubled_start(pd, states, options);
  };
  doubled.confirm = confirm_criticality;
  test.born = doubled;
  return test;
}

}  // namespace graze
