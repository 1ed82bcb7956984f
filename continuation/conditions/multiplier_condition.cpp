// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/conditions/multiplier_condition.hpp>

#include <graze/lib/numerics/null_vectors.hpp>
#include <graze/lib/numerics/orbit_lu.hpp>

#include <cmath>

namespace graze {

namespace {

using Complex = std::complex<double>;

/// Rounding of one evaluation of the equations, relative to 1 + |x|: measured scatter of a period's map is a few times 1e-15.
constexpr double rounding = 1e-14;

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

/// Where sigma is real, so is everything, at a fourth of the work.
Bordered solve(const Eigen::MatrixXcd& K, const Eigen::VectorXcd& b, const Eigen::VectorXcd& c, bool real) {
  return real ? solve_bordered(Matrix(K.real()), Vector(b.real()), Vector(c.real())) : solve_bordered(K, b, c);
}

/// Borders with which K is regular: its left and right null vectors.
std::pair<Eigen::VectorXcd, Eigen::VectorXcd> borders(const Eigen::MatrixXcd& K, bool real) {
  if (!real) {
    auto null = null_vectors(K);
    return {std::move(null.left), std::move(null.right)};
  }
  const auto null = null_vectors(Matrix(K.real()));
  return {null.left.cast<Complex>(), null.right.cast<Complex>()};
}

}  // namespace

LocatedPoint locate_multiplier(BranchProblem& problem, const Vector& start, const MultiplierCondition& condition) {
  LocatedPoint located;
  located.u = start;
  located.theta = condition.theta;
  Vector residual;
  Matrix jacobian;
  const ZeroProblem zero = problem.zero_problem();
  if (!zero.evaluate(located.u, residual, &jacobian)) {
    located.newton.status = NewtonStatus::evaluation_failed;
    return located;
  }
  const Eigen::Index unknowns = problem.unknowns(), extra = condition.theta_free ? 2 : 1;
  const Eigen::Index size = unknowns - 1 + extra;
  const bool real = !condition.theta_free;
  const auto sigma_at = [&](double theta) { return real ? Complex(std::cos(theta) < 0.0 ? -1.0 : 1.0) : std::polar(1.0, theta); };
  auto [b, c] = borders(problem.cyclic(located.u, sigma_at(located.theta)), real);
  const double scale = problem.state_scale(located.u);
  double last_step = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < 20; ++iteration) {
    const Complex sigma = sigma_at(located.theta);
    const Eigen::MatrixXcd K = problem.cyclic(located.u, sigma);
    const Bordered bordered = solve(K, b, c, real);
    const double K_scale = std::max(1.0, K.cwiseAbs().maxCoeff());
    const double size_now = std::max(residual.lpNorm<Eigen::Infinity>() / scale, std::abs(bordered.g) / K_scale);
    located.newton.residual_history.push_back(size_now);
    located.v = bordered.v;
    located.w = bordered.w;
    const Eigen::VectorXcd g_u = -problem.cyclic_derivative(located.u, sigma, bordered.w, bordered.v);
    Matrix A = Matrix::Zero(size, unknowns + extra - 1);
    A.topLeftCorner(unknowns - 1, unknowns) = jacobian;
    A.row(unknowns - 1).head(unknowns) = g_u.real().transpose();
    Vector right(size);
    right.head(unknowns - 1) = -residual;
    right[unknowns - 1] = -bordered.g.real();
    if (condition.theta_free) {
      // K is linear in sigma: dg/dtheta = -w^H (dK/dsigma) (i sigma) v.
      const Complex g_theta = -bordered.w.dot((problem.cyclic(located.u, 1.0) - problem.cyclic(located.u, 0.0)) *
                                              (Complex(0.0, 1.0) * sigma * bordered.v));
      A.row(unknowns).head(unknowns) = g_u.imag().transpose();
      A(unknowns - 1, unknowns) = g_theta.real();
      A(unknowns, unknowns) = g_theta.imag();
      right[unknowns] = -bordered.g.imag();
    }
    const OrbitLU<Matrix> lu(A);
    const Vector step = lu.solve(right);
    if (!step.allFinite()) {
      located.newton.status = NewtonStatus::singular;
      return located;
    }
    // How rounding of the equations shows in the parameter: the corresponding row of the inverse, in the 1-norm.
    Vector noise = Vector::Zero(size);
    noise[unknowns - 1] = 1.0;
    const Vector sensitivity = lu.solve_adjoint(noise);
    located.precision =
        rounding * (scale * sensitivity.head(unknowns - 1).lpNorm<1>() + K_scale * sensitivity.tail(extra).lpNorm<1>());
    const double step_size = step.head(unknowns).lpNorm<Eigen::Infinity>() / scale;
    if (size_now < 1e-11 && (step_size < 1e-14 || step_size >= 0.5 * last_step)) {
      located.newton.status = NewtonStatus::converged;
      located.precision = std::max(located.precision, std::abs(step[unknowns - 1]));
      return located;
    }
    last_step = step_size;
    located.u += step.head(unknowns);
    if (condition.theta_free) located.theta += step[unknowns];
    b = bordered.w.normalized();
    c = bordered.v.normalized();
    if (!zero.evaluate(located.u, residual, &jacobian)) {
      located.newton.status = NewtonStatus::evaluation_failed;
      return located;
    }
    located.newton.status = NewtonStatus::iteration_limit;
  }
  return located;
}

}  // namespace graze
