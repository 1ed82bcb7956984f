// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/conditions/branch_point_equations.hpp>

#include <graze/lib/numerics/null_vectors.hpp>

#include <cmath>

namespace graze {

namespace {

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
    Matrix A = Matrix::Zero(size + 1, size + 1);
    A.topLeftCorner(size, size) = H_u.leftCols(size);
    A.col(size).head(size) = b_;
    A.row(size).head(size) = c_.transpose();
    const Vector right = Vector::Unit(size + 1, size);
    const OrbitLU<Matrix> lu(A);
    const Vector v = lu.solve(right), w = lu.solve_adjoint(right);
    if (null) *null = v.head(size);
    F.resize(size + 2);
    F << H + at[at.size() - 1] * b_, v[size], unit * w.head(size).dot(H_u.col(size));
    return true;
  }

  Vector b_, c_;  ///< the borders, from the start
  Vector null_, sizes_;
};

}  // namespace

std::unique_ptr<DefiningEquations> branch_point_equations() { return std::make_unique<BranchPointEquations>(); }

}  // namespace graze
