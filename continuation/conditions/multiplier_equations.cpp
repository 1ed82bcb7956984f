// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/conditions/multiplier_equations.hpp>

#include <graze/lib/numerics/null_vectors.hpp>
#include <graze/lib/numerics/orbit_lu.hpp>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

namespace graze {

namespace {

using Complex = std::complex<double>;

struct Bordered {
  Complex g;
  Eigen::VectorXcd v, w;
};

template <class SquareMatrix>
Bordered solve_bordered(const SquareMatrix& K, const typename NullVectors<SquareMatrix>::Column& b,
                        const typename NullVectors<SquareMatrix>::Column& c) {
  using Column = typename NullVectors<SquareMatrix>::Column;
  const Eigen::Index size = K.rows();
  SquareMatrix A = SquareMatrix::Zero(size + 1, size + 1);
  A.topLeftCorner(size, size) = K;
  A.col(size).head(size) = b;
  A.row(size).head(size) = c.adjoint();
  const Column right = Column::Unit(size + 1, size);
  const OrbitLU<SquareMatrix> lu(A);
  const Column direct = lu.solve(right), adjoint = lu.solve_adjoint(right);
  return {direct[size], direct.head(size), adjoint.head(size)};
}

/// If sigma is real, all quantities are real, and real arithmetic needs a quarter of the work.
Bordered solve_bordered(const Eigen::MatrixXcd& K, const Eigen::VectorXcd& b, const Eigen::VectorXcd& c, bool real) {
  return real ? solve_bordered(Matrix(K.real()), Vector(b.real()), Vector(c.real())) : solve_bordered(K, b, c);
}

/// Borders that make the bordered matrix regular: the left and right null vectors of K.
std::pair<Eigen::VectorXcd, Eigen::VectorXcd> borders(const Eigen::MatrixXcd& K, bool real) {
  if (!real) {
    auto null = null_vectors(K);
    return {std::move(null.left), std::move(null.right)};
  }
  const auto null = null_vectors(Matrix(K.real()));
  return {null.left.cast<Complex>(), null.right.cast<Complex>()};
}

/// The equations (H, Re g, Im g) as one vector; without Im g if all quantities are real.
Vector extended(const Vector& residual, Complex g, bool real) {
  Vector F(residual.size() + (real ? 1 : 2));
  F.head(residual.size()) = residual;
  F[residual.size()] = g.real();
  if (!real) F[residual.size() + 1] = g.imag();
  return F;
}

class MultiplierEquations : public DefiningEquations {
 public:
  explicit MultiplierEquations(const MultiplierCondition& condition) : condition_(condition) {}

  Vector own_start() const override { return real() ? Vector() : Vector{{condition_.theta}}; }

  bool evaluate(BranchProblem& problem, const Vector& w, Vector& F, Matrix* jacobian) override {
    const Eigen::Index unknowns = problem.unknowns(), equations = problem.orbit_unknowns();
    const Vector u = w.head(unknowns);
    Vector H;
    Matrix H_u;
    if (!problem.zero_problem().evaluate(u, H, &H_u)) return false;
    const Complex sigma = real() ? Complex(std::cos(condition_.theta) < 0.0 ? -1.0 : 1.0) : std::polar(1.0, w[unknowns]);
    const Eigen::MatrixXcd K = problem.cyclic(u, sigma);
    if (b_.size() == 0) {
      std::tie(b_, c_) = borders(K, real());
      scale_ = problem.state_scale(u);
    } else if (jacobian) {
      b_ = bordered_.w.normalized();
      c_ = bordered_.v.normalized();
    }
    Bordered bordered = solve_bordered(K, b_, c_, real());
    F = extended(H, bordered.g, real());
    if (!jacobian) return true;
    bordered_ = std::move(bordered);
    sizes_ = Vector::Constant(F.size(), std::max(1.0, K.cwiseAbs().maxCoeff()));
    sizes_.head(equations).setConstant(scale_);
    const Eigen::VectorXcd g_u = -problem.cyclic_derivative(u, sigma, bordered_.w, bordered_.v);
    *jacobian = Matrix::Zero(F.size(), w.size());
    jacobian->topLeftCorner(equations, unknowns) = H_u;
    jacobian->row(equations).head(unknowns) = g_u.real().transpose();
    if (real()) return true;
    // K is linear in sigma: dg/dtheta = -w^H (dK/dsigma) (i sigma) v.
    const Complex g_theta =
        -bordered_.w.dot((problem.cyclic(u, 1.0) - problem.cyclic(u, 0.0)) * (Complex(0.0, 1.0) * sigma * bordered_.v));
    jacobian->row(equations + 1).head(unknowns) = g_u.imag().transpose();
    (*jacobian)(equations, unknowns) = g_theta.real();
    (*jacobian)(equations + 1, unknowns) = g_theta.imag();
    return true;
  }

  Vector sizes() const override { return sizes_; }

  void describe(const Vector& w, LocatedPoint& located) const override {
    located.theta = real() ? condition_.theta : w[w.size() - 1];
    located.v = bordered_.v;
    located.w = bordered_.w;
  }

 private:
  bool real() const { return !condition_.theta_free; }

  MultiplierCondition condition_;
  Eigen::VectorXcd b_, c_;  ///< the borders of the last evaluation with Jacobian, from the null vectors of the one before
  Bordered bordered_;
  double scale_ = 1.0;
  Vector sizes_;
};

}  // namespace

std::unique_ptr<DefiningEquations> multiplier_equations(const MultiplierCondition& condition) {
  return std::make_unique<MultiplierEquations>(condition);
}

}  // namespace graze
