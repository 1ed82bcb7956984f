// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/orbit/multipliers.hpp>

#include <graze/floquet/orbit/kept_state.hpp>
#include <graze/lib/numerics/decompositions.hpp>
#include <graze/lib/numerics/rank.hpp>

#include <Eigen/Jacobi>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <utility>

namespace graze {

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
/// If two multipliers differ by a factor of 20 or more, 12 sweeps leave a coupling below 1e-15. If they have not separated, a 2
/// x 2 block loses nothing (its determinant is known factor by factor); larger blocks get further sweeps, enough for a factor
/// of 2.
constexpr int sweeps = 12, sweeps_of_large_blocks = 60;

/// Determinants of the factors, and the largest deficiency of their ranks: at least as many multipliers are zero.
struct Determinants {
  std::vector<double> list = {};
  Eigen::Index deficiency = 0;
};

Determinants determinants(const std::vector<Matrix>& factors, const std::vector<double>& log_dets) {
  Determinants out;
  for (std::size_t k = 0; k < factors.size(); ++k) {
    auto [det, deficiency] = ranked_determinant(factors[k]);
    if (deficiency > 0 && k < log_dets.size() && std::isfinite(log_dets[k]))  // only lost to rounding
      det = std::exp(log_dets[k]);
    else
      out.deficiency = std::max(out.deficiency, deficiency);
    out.list.push_back(det);
  }
  return out;
}

/// Matrix with at most the rows and columns of a square matrix.
template <class Square>
using Part = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, Square::MaxRowsAtCompileTime,
                           Square::MaxColsAtCompileTime>;

/// +1 or -1 for an orthogonal matrix.
template <class Square> double orientation(const Square& Q) {
  const double det = Q.rows() == 2 ? Q(0, 0) * Q(1, 1) - Q(0, 1) * Q(1, 0) : Q.determinant();
  return std::copysign(1.0, det);
}

/// Factors in triangular form: A_k Q_{k-1} = Q_k R_k and E = Q_0^T Q_N, so that Q_0^T M Q_0 = E R_N ... R_1. (Square: Matrix2d or
/// Matrix.)
template <class Square> struct TriangularForm {
  std::vector<Square> R;
  Square E;
};

/// Restores the part of R that is lost to cancellation: its smallest pivot is a difference of large entries, but follows from
/// the determinant with relative accuracy. A factor of deficient rank gets exact zeros.
template <class Square> void sharpen(Square& R, double det, double size) {
  const Eigen::Index n = R.rows();
  const double blur = 8.0 * epsilon * static_cast<double>(n) * size;
  Eigen::Index smallest = 0;
  R.diagonal().cwiseAbs().minCoeff(&smallest);
  if (det != 0.0) {
    R(smallest, smallest) = 1.0;
    R(smallest, smallest) = det / R.diagonal().prod();
    return;
  }
  R(smallest, smallest) = 0.0;
  for (Eigen::Index i = 0; i < n; ++i)
    if (R.row(i).template lpNorm<Eigen::Infinity>() <= blur) R.row(i).setZero();
}

/// A = Q R; for 2 x 2 matrices by a rotation.
template <class Square> void triangularise(const Square& A, Square& Q, Square& R) {
  if constexpr (Square::RowsAtCompileTime == 2) {
    Eigen::JacobiRotation<double> rotation;
    rotation.makeGivens(A(0, 0), A(1, 0));
    R = A;
    R.applyOnTheLeft(0, 1, rotation.adjoint());
    R(1, 0) = 0.0;
    Q.setIdentity();
    Q.applyOnTheLeft(0, 1, rotation);
  } else {
    const Eigen::HouseholderQR<Square> qr(A);
    Q = qr.householderQ();
    R = qr.matrixQR().template triangularView<Eigen::Upper>();
  }
}

/// Q: Q_0 before, Q_N after.
template <class Square>
void sweep(const std::vector<Matrix>& factors, const std::vector<double>& dets, Square& Q, TriangularForm<Square>& form) {
  const Square start = Q;
  double side = orientation(Q);
  form.R.resize(factors.size());
  for (std::size_t k = 0; k < factors.size(); ++k) {
    const Square& factor = factors[k];
    const Square turned = factor * Q;
    Square& R = form.R[k];
    triangularise(turned, Q, R);
    const double before = side;
    side = orientation(Q);
    sharpen(R, before * side * dets[k], factor.cwiseAbs().maxCoeff());
  }
  form.E = start.transpose() * Q;
}

/// Rows first ... first + size - 1 of the product, and its determinant, factor by factor.
template <class Square> struct DiagonalBlock {
  Part<Square> product;
  double det = 1.0;

  DiagonalBlock(const TriangularForm<Square>& form, Eigen::Index first, Eigen::Index size) {
    product = Part<Square>::Identity(size, size);
    for (const Square& R : form.R) {
      product = Part<Square>(R.block(first, first, size, size) * product);
      det *= R.diagonal().segment(first, size).prod();
    }
    const Part<Square> E = form.E.block(first, first, size, size);
    product = Part<Square>(E * product);
    if (E.determinant() < 0.0) det = -det;
  }

  /// For two rows: the square of half the difference of the eigenvalues.
  double discriminant() const { return 0.25 * product.trace() * product.trace() - det; }
};

/// Whether a 2 x 2 product surely has conjugate eigenvalues, which no sweep separates.
template <class Square> bool conjugate(const TriangularForm<Square>& form) {
  constexpr double beyond_rounding = 1e-10;
  const DiagonalBlock whole(form, 0, 2);
  return whole.discriminant() < -beyond_rounding * whole.product.squaredNorm();
}

/// Eigenvalues of one diagonal block, rows first ... first + size - 1.
template <class Square>
void block_eigenvalues(const TriangularForm<Square>& form, Eigen::Index first, Eigen::Index size,
                       std::vector<std::complex<double>>& out) {
  const DiagonalBlock block(form, first, size);
  if (size == 1) {
    out.emplace_back(block.det);
  } else if (size == 2) {
    for (const std::complex<double>& one : eigenvalue_pair(0.5 * block.product.trace(), block.det)) out.push_back(one);
  } else {
    const Eigen::VectorXcd values = graze::eigenvalues(block.product);
    out.insert(out.end(), values.begin(), values.end());
  }
}

/// By decreasing modulus; conjugates stay together, positive imaginary part first.
void sort_by_modulus(std::vector<std::complex<double>>& values) {
  std::vector<std::complex<double>> upper;
  std::copy_if(values.begin(), values.end(), std::back_inserter(upper), [](const auto& z) { return z.imag() >= 0.0; });
  std::stable_sort(upper.begin(), upper.end(), [](const auto& a, const auto& b) { return std::abs(a) > std::abs(b); });
  values.clear();
  for (const auto& z : upper) {
    values.push_back(z);
    if (z.imag() > 0.0) values.push_back(std::conj(z));
  }
}

template <class Square>
std::vector<std::complex<double>> eigenvalues(const std::vector<Matrix>& factors, const Determinants& determinants) {
  const std::vector<double>& dets = determinants.list;
  const Eigen::Index n = factors.front().rows();
  Square Q = Square::Identity(n, n);
  TriangularForm<Square> form;
  sweep(factors, dets, Q, form);
  const auto parted = [&] {
    return n < 2 || (n == 2 && conjugate(form)) ||
           Square(form.E.template triangularView<Eigen::StrictlyLower>()).cwiseAbs().maxCoeff() < epsilon;
  };
  for (int i = 0; i < (n > 2 ? sweeps_of_large_blocks : sweeps) && !parted(); ++i) sweep(factors, dets, Q, form);
  std::vector<std::complex<double>> values;
  for (Eigen::Index first = 0; first < n;) {
    Eigen::Index size = 1;
    // A block ends where no entry below its rows couples back into its columns.
    while (first + size < n && form.E.block(first + size, first, n - first - size, size).cwiseAbs().maxCoeff() >
                                   8.0 * epsilon * static_cast<double>(n))
      ++size;
    block_eigenvalues(form, first, size, values);
    first += size;
  }
  sort_by_modulus(values);
  std::fill(values.end() - determinants.deficiency, values.end(), 0.0);
  return values;
}

/// The same map of the other states alone, with these ones as they are. The determinants of the factors stay: a kept state
/// depends on itself and on the held bodies.
MonodromyMatrix without(const MonodromyMatrix& monodromy, const std::vector<KeptState>& kept) {
  std::vector<Eigen::Index> others;
  for (Eigen::Index i = 0; i < monodromy.factors.front().rows(); ++i)
    if (std::none_of(kept.begin(), kept.end(), [i](const KeptState& one) { return one.index == i; })) others.push_back(i);
  MonodromyMatrix out = monodromy;
  for (Matrix& factor : out.factors) {
    // Where a distance is kept, the other state moves both.
    for (const KeptState& one : kept)
      if (one.less) factor.col(*one.less) += factor.col(one.index);
    factor = Matrix(factor(others, others));
  }
  if (out.trivial_direction.size() > 0) out.trivial_direction = Vector(out.trivial_direction(others));
  return out;
}

}  // namespace

Matrix MonodromyMatrix::product() const {
  if (factors.empty()) return {};
  Matrix M = factors.front();
  for (std::size_t k = 1; k < factors.size(); ++k) M = factors[k] * M;
  return M;
}

std::vector<std::complex<double>> product_eigenvalues(const std::vector<Matrix>& factors, const std::vector<double>& log_dets,
                                                      int lost) {
  if (factors.empty()) return {};
  Determinants dets = determinants(factors, log_dets);
  dets.deficiency = std::min(std::max<Eigen::Index>(dets.deficiency, lost), factors.front().rows());
  return factors.front().rows() == 2 ? eigenvalues<Eigen::Matrix2d>(factors, dets) : eigenvalues<Matrix>(factors, dets);
}

std::array<std::complex<double>, 2> eigenvalue_pair(double half_trace, double det) {
  const double discriminant = half_trace * half_trace - det;
  if (discriminant < 0.0) {
    const double imaginary = std::sqrt(-discriminant);
    return {std::complex<double>(half_trace, imaginary), std::complex<double>(half_trace, -imaginary)};
  }
  const double larger = half_trace + std::copysign(std::sqrt(discriminant), half_trace);
  return {larger, larger == 0.0 ? 0.0 : det / larger};
}

int FloquetMultipliers::unstable() const {
  const auto end = values.end() - std::min<std::ptrdiff_t>(trivial, std::ssize(values));
  constexpr double rounding = 1e-12;
  return static_cast<int>(std::count_if(values.begin(), end, [](const auto& mu) { return std::abs(mu) > 1.0 + rounding; }));
}

bool FloquetMultipliers::neutral() const {
  return valid &&
         std::all_of(values.begin(), values.end(), [](const auto& mu) { return std::abs(std::abs(mu) - 1.0) < on_unit_circle; });
}

FloquetMultipliers multipliers_of_values(std::vector<std::complex<double>> values, double duration) {
  FloquetMultipliers out;
  out.values = std::move(values);
  out.valid = true;
  for (const auto& mu : out.values) {
    const double modulus = std::abs(mu);
    out.valid = out.valid && std::isfinite(modulus);
    out.exponents.push_back(modulus > 0.0 ? std::log(modulus) / duration : -std::numeric_limits<double>::infinity());
  }
  return out;
}

FloquetMultipliers multipliers(const MonodromyMatrix& whole, double duration) {
  FloquetMultipliers result;
  result.section = whole.section;
  if (whole.factors.empty()) return result;
  for (const Matrix& factor : whole.factors)
    if (!factor.allFinite()) return result;
  const std::vector<KeptState> kept = kept_states(whole);
  const MonodromyMatrix others = kept.empty() ? MonodromyMatrix{} : without(whole, kept);
  const MonodromyMatrix& monodromy = kept.empty() ? whole : others;
  std::vector<std::complex<double>> values;
  int trivial = 0;
  if (monodromy.section == Section::stroboscopic) {
    values = product_eigenvalues(monodromy.factors, monodromy.log_dets, monodromy.lost);
  } else {
    // M carries the direction of the field into itself. As first basis vector it splits off the trivial multiplier; the lower
    // right blocks of the factors remain.
    const Eigen::Index n = monodromy.trivial_direction.size();
    Matrix Q = Eigen::HouseholderQR<Matrix>(monodromy.trivial_direction).householderQ() * Matrix::Identity(n, n);
    TriangularForm<Matrix> form;
    sweep(monodromy.factors, determinants(monodromy.factors, monodromy.log_dets).list, Q, form);
    std::vector<Matrix> rest;
    double along = form.E(0, 0);
    for (const Matrix& R : form.R) {
      along *= R(0, 0);
      rest.push_back(R.bottomRightCorner(n - 1, n - 1));
    }
    if (n > 1) {
      rest.push_back(form.E.bottomRightCorner(n - 1, n - 1));
      values = product_eigenvalues(rest, {}, monodromy.lost);
    }
    values.emplace_back(along);
    trivial = 1;
  }
  values.insert(values.end(), kept.size(), 1.0);
  result = multipliers_of_values(std::move(values), duration);
  result.section = whole.section;
  result.trivial = trivial + static_cast<int>(kept.size());
  return result;
}

std::vector<KeptState> kept_states(const MonodromyMatrix& monodromy) {
  const std::vector<double> dets = determinants(monodromy.factors, monodromy.log_dets).list;
  if (std::find(dets.begin(), dets.end(), 0.0) == dets.end()) return {};
  std::vector<Matrix> products;
  for (const Matrix& factor : monodromy.factors) products.push_back(products.empty() ? factor : Matrix(factor * products.back()));
  return find_kept_states(monodromy.factors.front().rows(), [&](const KeptState& one) {
    return std::all_of(products.begin(), products.end(), [&](const Matrix& product) { return one.kept_by(product); });
  });
}

}  // namespace graze
