// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/conditions/multiplier_condition.hpp>

#include <graze/lib/numerics/null_vectors.hpp>
#include <graze/lib/numerics/orbit_lu.hpp>

#include <cmath>
#include <tuple>

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
Bordered solve(const Eigen::MatrixXcd& K, const Eigen::VectorXcd& b, const Eigen::VectorXcd& c, bool real) {
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

}  // namespace

LocatedPoint locate_multiplier(BranchProblem& problem, const Vector& start, const MultiplierCondition& condition) {
  require_one_parameter(problem);
  const Eigen::Index unknowns = problem.unknowns(), equations = problem.orbit_unknowns(), extra = condition.theta_free ? 2 : 1;
  const Eigen::Index size = equations + extra;
  const bool real = !condition.theta_free;
  const auto sigma_at = [&](double theta) { return real ? Complex(std::cos(theta) < 0.0 ? -1.0 : 1.0) : std::polar(1.0, theta); };
  const ZeroProblem zero = problem.zero_problem();
  const double scale = problem.state_scale(start);
  Eigen::VectorXcd b, c;
  Bordered bordered;
  Vector residual, sensitivity;
  Complex sigma;
  double K_scale = 1.0, last_step = 0.0;
  const auto linearise = [&](const Vector& v) -> std::optional<NewtonIterate> {
    const Vector u = v.head(unknowns);
    Matrix jacobian;
    if (!zero.evaluate(u, residual, &jacobian)) return std::nullopt;
    sigma = sigma_at(real ? condition.theta : v[unknowns]);
    const Eigen::MatrixXcd K = problem.cyclic(u, sigma);
    if (b.size() == 0) {
      std::tie(b, c) = borders(K, real);
    } else {
      b = bordered.w.normalized();
      c = bordered.v.normalized();
    }
    bordered = solve(K, b, c, real);
    K_scale = std::max(1.0, K.cwiseAbs().maxCoeff());
    const Eigen::VectorXcd g_u = -problem.cyclic_derivative(u, sigma, bordered.w, bordered.v);
    Matrix A = Matrix::Zero(size, size);
    A.topLeftCorner(equations, unknowns) = jacobian;
    A.row(equations).head(unknowns) = g_u.real().transpose();
    Vector right(size);
    right.head(equations) = -residual;
    right[equations] = -bordered.g.real();
    if (condition.theta_free) {
      // K is linear in sigma: dg/dtheta = -w^H (dK/dsigma) (i sigma) v.
      const Complex g_theta =
          -bordered.w.dot((problem.cyclic(u, 1.0) - problem.cyclic(u, 0.0)) * (Complex(0.0, 1.0) * sigma * bordered.v));
      A.row(equations + 1).head(unknowns) = g_u.imag().transpose();
      A(equations, unknowns) = g_theta.real();
      A(equations + 1, unknowns) = g_theta.imag();
      right[equations + 1] = -bordered.g.imag();
    }
    const OrbitLU<Matrix> lu(A);
    NewtonIterate at;
    at.residual = std::max(residual.lpNorm<Eigen::Infinity>() / scale, std::abs(bordered.g) / K_scale);
    at.step = lu.solve(right);
    at.length = problem.largest_change(at.step.head(unknowns)) / scale;
    sensitivity = lu.solve_adjoint(Vector::Unit(size, equations));
    last_step = at.step[equations];
    return at;
  };
  Vector v(size);
  v.head(unknowns) = start;
  if (condition.theta_free) v[unknowns] = condition.theta;
  LocatedPoint located;
  located.newton = newton_to_rounding(v, linearise);
  located.u = v.head(unknowns);
  located.theta = real ? condition.theta : v[unknowns];
  located.v = bordered.v;
  located.w = bordered.w;
  if (!located.newton.converged()) return located;
  // Effect of rounding in the equations on the parameter: the 1-norm of the parameter's row of the inverse Jacobian.
  const double noise = scale * sensitivity.head(equations).lpNorm<1>() + K_scale * sensitivity.tail(extra).lpNorm<1>();
  const double by_steps =
      error_of_steps(problem, sensitivity, extended(residual, bordered.g, real), [&](BranchProblem& finer) -> Vector {
        Vector there;
        Matrix jacobian;
        if (!finer.zero_problem().evaluate(located.u, there, &jacobian)) return {};
        return extended(there, solve(finer.cyclic(located.u, sigma), b, c, real).g, real);
      });
  located.precision = std::max({rounding_of_equations * noise, std::abs(last_step), by_steps});
  return located;
}

}  // namespace graze
