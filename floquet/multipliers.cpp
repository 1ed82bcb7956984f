// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/multipliers.hpp>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>

namespace graze {

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
/// Blocks whose moduli differ by more than about 0.05 have parted (to 1e-15) after this many sweeps; within a block the plain
/// product loses no more than a digit or two.
constexpr int sweeps = 12;

/// Factors in triangular form: A_k Q_{k-1} = Q_k R_k and E = Q_0^T Q_N, so that Q_0^T M Q_0 = E R_N ... R_1.
struct TriangularForm {
  std::vector<Matrix> R;
  Matrix E;
};

TriangularForm sweep(const std::vector<Matrix>& factors, const Matrix& start, Matrix& Q) {
  TriangularForm form;
  const Eigen::Index n = start.rows();
  Q = start;
  for (const Matrix& factor : factors) {
    const Matrix image = factor * Q;
    const Eigen::HouseholderQR<Matrix> qr(image);
    Q = qr.householderQ();
    Matrix R = qr.matrixQR().triangularView<Eigen::Upper>();
    // A factor of deficient rank (k_r = 0, sticking) has exact zeros, which rounding would blur.
    const double size = factor.cwiseAbs().maxCoeff();
    for (Eigen::Index i = 0; i < n; ++i)
      if (std::abs(R(i, i)) <= 8.0 * epsilon * static_cast<double>(n) * size) R(i, i) = 0.0;
    form.R.push_back(std::move(R));
  }
  form.E = start.transpose() * Q;
  return form;
}

/// Eigenvalues of one diagonal block, rows first ... first + size - 1.
void block_eigenvalues(const TriangularForm& form, Eigen::Index first, Eigen::Index size,
                       std::vector<std::complex<double>>& out) {
  Matrix product = Matrix::Identity(size, size);
  Vector diagonal = Vector::Ones(size);
  for (const Matrix& R : form.R) {
    const Matrix block = R.block(first, first, size, size);
    product = block * product;
    diagonal = diagonal.cwiseProduct(block.diagonal());
  }
  const Matrix E = form.E.block(first, first, size, size);
  product = E * product;
  if (size == 1) {
    out.emplace_back(E(0, 0) < 0.0 ? -diagonal[0] : diagonal[0]);
  } else if (size == 2) {
    const double det = diagonal.prod() * (E.determinant() < 0.0 ? -1.0 : 1.0), half_trace = 0.5 * product.trace();
    const double discriminant = half_trace * half_trace - det;
    if (discriminant < 0.0) {
      const double imaginary = std::sqrt(-discriminant);
      out.emplace_back(half_trace, imaginary);
      out.emplace_back(half_trace, -imaginary);
    } else {
      const double larger = half_trace + std::copysign(std::sqrt(discriminant), half_trace);
      out.emplace_back(larger);
      out.emplace_back(larger == 0.0 ? 0.0 : det / larger);
    }
  } else {
    const Eigen::VectorXcd values = product.eigenvalues();
    out.insert(out.end(), values.begin(), values.end());
  }
}

void sort_by_modulus(std::vector<std::complex<double>>& values) {
  std::stable_sort(values.begin(), values.end(), [](const auto& a, const auto& b) {
    const double ma = std::abs(a), mb = std::abs(b);
    if (std::abs(ma - mb) > 1e-14 * (ma + mb)) return ma > mb;
    return a.imag() > b.imag();
  });
}

}  // namespace

Matrix MonodromyMatrix::product() const {
  if (factors.empty()) return {};
  Matrix M = factors.front();
  for (std::size_t k = 1; k < factors.size(); ++k) M = factors[k] * M;
  return M;
}

std::vector<std::complex<double>> product_eigenvalues(const std::vector<Matrix>& factors) {
  std::vector<std::complex<double>> values;
  if (factors.empty()) return values;
  const Eigen::Index n = factors.front().rows();
  Matrix start = Matrix::Identity(n, n), end;
  TriangularForm form = sweep(factors, start, end);
  const auto parted = [&] {
    return n < 2 || form.E.triangularView<Eigen::StrictlyLower>().toDenseMatrix().cwiseAbs().maxCoeff() < epsilon;
  };
  for (int i = 0; i < sweeps && !parted(); ++i) {
    start = end;
    form = sweep(factors, start, end);
  }
  for (Eigen::Index first = 0; first < n;) {
    Eigen::Index size = 1;
    // A block ends where nothing below its rows couples back into its columns.
    while (first + size < n && form.E.block(first + size, first, n - first - size, size).cwiseAbs().maxCoeff() >
                                   8.0 * epsilon * static_cast<double>(n))
      ++size;
    block_eigenvalues(form, first, size, values);
    first += size;
  }
  sort_by_modulus(values);
  return values;
}

int FloquetMultipliers::unstable() const {
  const auto end = values.end() - std::min<std::ptrdiff_t>(trivial, std::ssize(values));
  return static_cast<int>(std::count_if(values.begin(), end, [](const auto& mu) { return std::abs(mu) > 1.0; }));
}

FloquetMultipliers multipliers(const MonodromyMatrix& monodromy, double duration) {
  FloquetMultipliers result;
  result.section = monodromy.section;
  if (monodromy.factors.empty()) return result;
  for (const Matrix& factor : monodromy.factors)
    if (!factor.allFinite()) return result;
  if (monodromy.section == Section::stroboscopic) {
    result.values = product_eigenvalues(monodromy.factors);
  } else {
    // The direction of the field is carried into itself: taken as first basis vector it splits off the trivial multiplier, and
    // what is left of the factors is their lower right block.
    const Eigen::Index n = monodromy.trivial_direction.size();
    Matrix start = Eigen::HouseholderQR<Matrix>(monodromy.trivial_direction).householderQ() * Matrix::Identity(n, n), end;
    const TriangularForm form = sweep(monodromy.factors, start, end);
    std::vector<Matrix> rest;
    double along = form.E(0, 0);
    for (const Matrix& R : form.R) {
      along *= R(0, 0);
      rest.push_back(R.bottomRightCorner(n - 1, n - 1));
    }
    if (n > 1) {
      rest.push_back(form.E.bottomRightCorner(n - 1, n - 1));
      result.values = product_eigenvalues(rest);
    }
    result.values.emplace_back(along);
    result.trivial = 1;
  }
  result.valid = true;
  for (const auto& mu : result.values) {
    const double modulus = std::abs(mu);
    result.valid = result.valid && std::isfinite(modulus);
    result.exponents.push_back(modulus > 0.0 ? std::log(modulus) / duration : -std::numeric_limits<double>::infinity());
  }
  return result;
}

}  // namespace graze
