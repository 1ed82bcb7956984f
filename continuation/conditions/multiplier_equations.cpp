// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/conditions/multiplier_equations.hpp>

#include <graze/lib/numerics/null_vectors.hpp>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

namespace graze {

namespace {

using Complex = std::complex<double>;

using Bordered = BorderedSolution<Eigen::MatrixXcd>;

/// If sigma is real, all quantities are real, and real arithmetic needs a quarter of the work.
Bordered bordered_solution(const Eigen::MatrixXcd& K, const Eigen::VectorXcd& b, const Eigen::VectorXcd& c, bool real) {
  if (!real) return solve_bordered(K, b, c);
  const auto solution = solve_bordered(Matrix(K.real()), Vector(b.real()), Vector(c.real()));
  return {solution.g, solution.v.cast<Complex>(), solution.w.cast<Complex>()};
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

/// F = (H, Re g, Im g); without Im g if sigma is real.
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
    Bordered bordered = bordered_solution(K, b_, c_, real());
    F.resize(equations + (real() ? 1 : 2));
    F.head(equations) = H;
    F[equations] = bordered.g.real();
    if (!real()) F[equations + 1] = bordered.g.imag();
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
