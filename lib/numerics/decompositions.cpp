// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/numerics/decompositions.hpp>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>

#include <limits>

namespace graze {

Eigen::VectorXcd eigenvalues(const Matrix& A) { return A.eigenvalues(); }

double spectral_radius(const Matrix& A) {
  if (!A.allFinite()) return std::numeric_limits<double>::quiet_NaN();
  return eigenvalues(A).cwiseAbs().maxCoeff();
}

double eigenvector_condition(const Matrix& A) {
  const Eigen::EigenSolver<Matrix> solver(A);
  if (solver.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  const Eigen::VectorXd sizes = Eigen::JacobiSVD<Eigen::MatrixXcd>(solver.eigenvectors()).singularValues();
  const double least = sizes[sizes.size() - 1];
  return least > 0.0 ? sizes[0] / least : std::numeric_limits<double>::infinity();
}

Vector shortest_solution(const Matrix& A, const Vector& b, double threshold) {
  Eigen::CompleteOrthogonalDecomposition<Matrix> decomposition;
  if (threshold > 0.0) decomposition.setThreshold(threshold);
  return decomposition.compute(A).solve(b);
}

}  // namespace graze
