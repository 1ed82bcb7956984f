// SPDX-License-Identifier: GPL-3.0-or-later
// BP, branch point: two branches cross. Either a multiplier passes +1 and the branch does not turn, or the branch turns and a
// multiplier only touches +1 (the branch that turns in a pitchfork).
//
// Test function: det(M - I) times the sign of the parameter's component of the tangent. At a fold both factors change sign, so
// that the product keeps its sign. At a branch point the product changes its sign. This is the sign of the determinant of the
// equations' Jacobian bordered by the tangent.
//
// The defining equations have one unfolding parameter e (Beyn et al., Handbook of Dynamical Systems 2 (2002), ch. 4):
//     H(u) + e b = 0,   g(u) = 0,   w^T H_p(u) = 0,
// with g and w from the bordered matrix K(1) (see multiplier_equations.hpp). The last two state that the Jacobian in the states
// is singular, and that the parameter's column H_p lies in its range. At a branch point e = 0. An imperfection opens the
// crossing: then e != 0, and no branch point is reported.
#include <graze/continuation/conditions/test_function.hpp>

#include <graze/continuation/conditions/own_coordinates.hpp>
#include <graze/lib/numerics/null_vectors.hpp>

#include <Eigen/SVD>

#include <cmath>
#include <initializer_list>
#include <memory>

namespace graze {

namespace {

/// LocatedPoint::v is the null vector; LocatedPoint::w stays empty.
class BranchPointEquations : public DefiningEquations {
 public:
  Vector own_start() const override { return Vector::Zero(1); }  // e

  bool evaluate(BranchProblem& problem, const Vector& w, Vector& F, Matrix* jacobian) override {
    const ZeroProblem zero = problem.zero_problem();
    const Eigen::Index unknowns = problem.unknowns(), equations = problem.orbit_unknowns();
    const Vector u = w.head(unknowns);
    if (b_.size() == 0) {
      Vector H;
      Matrix H_u;
      if (!zero.evaluate(u, H, &H_u)) return false;
      const auto null = null_vectors(Matrix(H_u.leftCols(equations)));
      b_ = null.left;
      c_ = null.right;
      sizes_ = Vector::Constant(equations + 2, problem.state_scale(u));
    }
    if (!evaluate_at(zero, problem.unit(), w, F, jacobian ? &null_ : nullptr)) return false;
    if (!jacobian) return true;
    jacobian->resize(F.size(), w.size());
    for (Eigen::Index i = 0; i < unknowns; ++i) {
      const double h = 1e-6 * problem.size_of_unknown(u, i);
      Vector ahead, behind;
      if (!evaluate_at(zero, problem.unit(), w + h * Vector::Unit(w.size(), i), ahead, nullptr)) return false;
      if (!evaluate_at(zero, problem.unit(), w - h * Vector::Unit(w.size(), i), behind, nullptr)) return false;
      jacobian->col(i) = (ahead - behind) / (2.0 * h);
    }
    jacobian->col(unknowns) << b_, 0.0, 0.0;
    return true;
  }

  Vector sizes() const override { return sizes_; }
  /// Looser than the default: the Jacobian is formed by differences, which limits the accuracy.
  NewtonRule rule() const override { return newton_to_rounding(1e-9, 1e-13); }

  void describe(const Vector& w, LocatedPoint& located) const override {
    if (null_.size() > 0) located.v = null_.cast<std::complex<double>>();
    // Solved with an unfolding, the equations have no branch point here: as a method for that point Newton's has stalled.
    const bool crosses = std::abs(w[w.size() - 1]) < 1e-8;
    if (located.newton.converged() && !crosses) located.newton.status = NewtonStatus::stalled;
  }

 private:
  /// F = (H + e b, g, w^T H_p), with H_p per `unit` of the parameter. Writes the null vector v to `null` unless it is null.
  bool evaluate_at(const ZeroProblem& zero, double unit, const Vector& at, Vector& F, Vector* null) const {
    Vector H;
    Matrix H_u;
    if (!zero.evaluate(at.head(at.size() - 1), H, &H_u)) return false;
    const Eigen::Index size = H.size();
    const auto solution = solve_bordered(Matrix(H_u.leftCols(size)), b_, c_);
    if (null) *null = solution.v;
    F.resize(size + 2);
    F << H + at[at.size() - 1] * b_, solution.g, unit * solution.w.dot(H_u.col(size));
    return true;
  }

  Vector b_, c_;  ///< the borders, from the start
  Vector null_, sizes_;
};

/// The other branch through the point, on the side +1 or -1 (the two halves of a pitchfork). The tangents of both branches span
/// the kernel of the equations' Jacobian. The start is pushed along the kernel direction normal to the tangent of `branch`, on
/// which `bp` was met, and corrected there. Empty if no orbit with the same number of impacts is found.
std::optional<BranchStart> crossing_start(const SpecialPoint& bp, const Branch& branch, OrbitProblem& states, int side,
                                          const TraceOptions& options) {
  OwnCoordinates own = own_coordinates(bp, states);
  BranchProblem& problem = own.by_events ? static_cast<BranchProblem&>(*own.by_events) : states;
  BranchPointEquations equations;
  const LocatedPoint located = locate(problem, equations, own.u);
  const ZeroProblem zero = problem.zero_problem();
  Vector residual;
  Matrix jacobian;
  if (!located.newton.converged() || !zero.evaluate(located.u, residual, &jacobian)) return std::nullopt;
  // The kernel, and the direction within it that is normal to the branch, in the weighted norm.
  const Vector unit = zero.weights.cwiseSqrt();
  const Eigen::JacobiSVD<Matrix> svd(jacobian * unit.cwiseInverse().asDiagonal(), Eigen::ComputeFullV);
  const Matrix kernel = svd.matrixV().rightCols(2);
  const Vector along = kernel.transpose() * unit.cwiseProduct(direction_along(own, states, bp, branch));
  if (!(along.norm() > 0.0)) return std::nullopt;
  Vector direction = unit.cwiseInverse().cwiseProduct(kernel * Vector{{-along[1], along[0]}} / along.norm());
  Eigen::Index largest = 0;
  problem.orbit_part(direction).cwiseAbs().maxCoeff(&largest);  // the sign of a side must not depend on rounding
  if (direction[largest] * side < 0.0) direction = -direction;
  // The crossing branch need not be normal to this one. If no push along the normal leads to it, the first correction, which
  // keeps the part along the normal, tells its direction.
  struct Trial {
    bool oblique;
    double push;
  };
  for (const Trial& trial : std::initializer_list<Trial>{
           {false, 2e-4}, {false, 5e-5}, {false, 1e-5}, {false, 2e-6}, {false, 1e-3}, {true, 2e-4}, {true, 5e-5}, {true, 1e-5}}) {
    const double push = trial.push;
    BranchStart start;
    start.step = push;
    const auto corrected = [&](const Vector& towards) {
      start.u = located.u + push * towards;
      return correct(zero, towards, start.u, options).converged() ? weighted_norm(zero.weights, start.u - located.u) : 0.0;
    };
    double length = corrected(direction);
    constexpr double most_oblique = 20.0;
    if (trial.oblique && length > 0.0 && length < most_oblique * push) length = corrected((start.u - located.u) / length);
    if (length == 0.0 || !(length < 1.5 * push) || !problem.is_motion(start.u)) continue;
    start.orientation = start.u - located.u;
    start.sequence = problem.sequence();
    const BranchPoint first = problem.branch_point(start.u, 0.0);
    if (first.impacts != bp.orbit.impacts) continue;
    start.states = first.states;
    return start;
  }
  return std::nullopt;
}

}  // namespace

TestFunction branch_point_test() {
  TestFunction test;
  test.type = PointType::BP;
  test.summary = "branch point: the product of (multiplier - 1) passes zero, or the branch turns, but not both";
  test.value = [](const TestPoint& point) {
    std::complex<double> product = 1.0;
    for (const auto& mu : nontrivial(point.branch.multipliers)) product *= (mu - 1.0) / (1.0 + std::abs(mu));
    const double parameter_component = point.parameter_rate();
    return std::copysign(product.real(), product.real() * parameter_component);
  };
  test.confirm = [](const TestPoint& before, const TestPoint& after) {
    if (stands_still(before, after)) return false;
    const auto goes_up = [](const TestPoint& point) { return point.parameter_rate() > 0.0; };
    const bool passes = (real_beyond(before, 1) + real_beyond(after, 1)) % 2 == 1, turns = goes_up(before) != goes_up(after);
    return passes != turns;
  };
  test.distance = [](const BranchPoint& point) { return nearest_multiplier(point, 1.0); };
  test.equations = [](const TestPoint&) { return std::make_unique<BranchPointEquations>(); };
  test.born = Birth{.sides = {1, -1},
                    .located_only = true,
                    .missing = "no orbit of the branch that crosses there was found",
                    .start = crossing_start};
  return test;
}

}  // namespace graze
