// SPDX-License-Identifier: GPL-3.0-or-later
// Eigenvalues of products of matrices with known eigenvalues: A_k = Q_k D_k Q_{k-1}^{-1} with Q_N = Q_0, so that the product
// is Q_0 (D_N ... D_1) Q_0^{-1}. The Q are random, well conditioned and not orthogonal. All matrices are formed in long double
// and then rounded.
#include <graze/floquet/orbit/multipliers.hpp>

#include "support/checks.hpp"

#include <catch2/catch.hpp>

#include <algorithm>

using namespace graze;
using namespace graze::support;

namespace {

using LongMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using Complex = std::complex<double>;

LongMatrix random_basis(Eigen::Index n, Random& random) {
  LongMatrix Q = LongMatrix::Identity(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      Q(i, j) += 0.6L / static_cast<long double>(n) * static_cast<long double>(random(-1.0, 1.0));
  return Q;
}

/// Block diagonal matrices whose product has known eigenvalues.
struct Chain {
  std::vector<Matrix> factors;
  std::vector<Complex> eigenvalues;
};

/// `real`: sizes per factor of the real eigenvalues; `pairs`: (modulus, angle) per factor of the complex ones.
Chain make_chain(int length, const std::vector<double>& real, const std::vector<std::pair<double, double>>& pairs,
                 Random& random) {
  const auto n = static_cast<Eigen::Index>(real.size() + 2 * pairs.size());
  std::vector<long double> product(real.size(), 1.0L), modulus(pairs.size(), 1.0L), angle(pairs.size(), 0.0L);
  Chain chain;
  const LongMatrix first = random_basis(n, random);
  LongMatrix before = first;
  for (int k = 0; k < length; ++k) {
    LongMatrix D = LongMatrix::Zero(n, n);
    for (std::size_t i = 0; i < real.size(); ++i) {
      const long double d = static_cast<long double>(real[i] * random(0.7, 1.4)) * (random(0.0, 1.0) < 0.3 ? -1.0L : 1.0L);
      product[i] *= d;
      D(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)) = d;
    }
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const long double size = static_cast<long double>(pairs[i].first * random(0.7, 1.4));
      const long double turn = static_cast<long double>(pairs[i].second * random(0.5, 1.5));
      modulus[i] *= size;
      angle[i] += turn;
      const auto at = static_cast<Eigen::Index>(real.size() + 2 * i);
      D.block(at, at, 2, 2) << size * std::cos(turn), -size * std::sin(turn), size * std::sin(turn), size * std::cos(turn);
    }
    const LongMatrix after = k + 1 < length ? random_basis(n, random) : first;
    chain.factors.push_back((after * D * before.inverse()).cast<double>());
    before = after;
  }
  for (const long double d : product) chain.eigenvalues.emplace_back(static_cast<double>(d));
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto value = std::polar(modulus[i], angle[i]);
    chain.eigenvalues.emplace_back(static_cast<double>(value.real()), static_cast<double>(std::abs(value.imag())));
    chain.eigenvalues.push_back(std::conj(chain.eigenvalues.back()));
  }
  return chain;
}

/// Largest relative error; each eigenvalue is matched with the nearest computed one.
double relative_error(const Chain& chain) {
  std::vector<Complex> found = product_eigenvalues(chain.factors);
  if (found.size() != chain.eigenvalues.size()) return std::numeric_limits<double>::infinity();
  double worst = 0.0;
  for (const Complex& exact : chain.eigenvalues) {
    const auto nearest = std::min_element(found.begin(), found.end(), [&](const Complex& a, const Complex& b) {
      return std::abs(a - exact) < std::abs(b - exact);
    });
    worst = std::max(worst, std::abs(*nearest - exact) / std::abs(exact));
    found.erase(nearest);
  }
  return worst;
}

/// Rounding a factor changes each eigenvalue by 1e-16 times the condition of the factor, some 10 times the ratio of its sizes.
double tolerance(int length, double ratio) { return 1e-15 * length * 100.0 * ratio; }

}  // namespace

TEST_CASE("real eigenvalues of long products have relative accuracy down to the smallest") {
  Random random(1);
  for (const int length : {1, 2, 3, 10, 60, 200}) {
    for (const std::vector<double>& sizes :
         {std::vector<double>{1.1, 0.4}, {1.0, 0.9}, {3.0, 1.0, 0.2}, {2.0, 1.0, 0.5, 0.25}, {2.0, 1.6, 1.2, 0.9, 0.6, 0.3}}) {
      const Chain chain = make_chain(length, sizes, {}, random);
      INFO(length << " factors of size " << sizes.size());
      // Eigenvalues that are not yet separated cost each other a digit or two.
      CHECK(relative_error(chain) < 100.0 * tolerance(length, sizes.front() / sizes.back()));
    }
  }
}

TEST_CASE("a product far beyond the range of its large eigenvalue keeps the small one") {
  Random random(2);
  const Chain chain = make_chain(150, {1.6, 0.08}, {}, random);
  // 1e30 beside 1e-165: the plain product, in double or in long double, has lost the latter.
  const std::vector<Complex> found = product_eigenvalues(chain.factors);
  CHECK(std::abs(chain.eigenvalues[1]) < 1e-150);
  CHECK(std::abs(found[1] - chain.eigenvalues[1]) < tolerance(150, 20.0) * std::abs(chain.eigenvalues[1]));
  CHECK(std::abs(found[0] - chain.eigenvalues[0]) < tolerance(150, 20.0) * std::abs(chain.eigenvalues[0]));
}

TEST_CASE("complex pairs are found beside larger and smaller real eigenvalues") {
  Random random(3);
  for (const int length : {1, 2, 5, 30, 100}) {
    INFO(length << " factors");
    CHECK(relative_error(make_chain(length, {}, {{0.8, 0.4}}, random)) < 100.0 * tolerance(length, 1.0));
    CHECK(relative_error(make_chain(length, {1.5}, {{0.6, 0.7}}, random)) < 100.0 * tolerance(length, 3.0));
    CHECK(relative_error(make_chain(length, {0.2}, {{0.9, 0.3}}, random)) < 100.0 * tolerance(length, 5.0));
    CHECK(relative_error(make_chain(length, {1.4, 0.1}, {{0.5, 1.1}}, random)) < 100.0 * tolerance(length, 14.0));
    CHECK(relative_error(make_chain(length, {}, {{1.2, 0.5}, {0.3, 0.9}}, random)) < 100.0 * tolerance(length, 4.0));
    CHECK(relative_error(make_chain(length, {1.0, 0.05}, {{1.5, 0.5}, {0.3, 0.9}}, random)) < 100.0 * tolerance(length, 30.0));
  }
}

TEST_CASE("eigenvalues of random products have the trace and the determinant of the product") {
  Random random(4);
  for (const Eigen::Index n : {2, 3, 4, 6}) {
    for (const int length : {1, 4, 12}) {
      std::vector<Matrix> factors;
      LongMatrix product = LongMatrix::Identity(n, n);
      long double log_det = 0.0L;
      for (int k = 0; k < length; ++k) {
        Matrix A(n, n);
        for (double& entry : A.reshaped()) entry = random(-1.0, 1.0);
        factors.push_back(A);
        product = A.cast<long double>() * product;
        log_det += std::log(std::abs(A.cast<long double>().determinant()));
      }
      const std::vector<Complex> values = product_eigenvalues(factors);
      REQUIRE(values.size() == static_cast<std::size_t>(n));
      Complex sum = 0.0;
      double logs = 0.0;
      for (const Complex& value : values) {
        sum += value;
        logs += std::log(std::abs(value));
      }
      INFO(n << " x " << n << ", " << length << " factors");
      const double scale = static_cast<double>(product.cwiseAbs().maxCoeff());
      CHECK(std::abs(sum - static_cast<double>(product.trace())) < 1e-13 * scale * length);
      // A random matrix may have a condition of 1e3, which affects the smallest eigenvalue.
      CHECK(std::abs(logs - static_cast<double>(log_det)) < 1e-11 * length);
    }
  }
}

TEST_CASE("a factor of deficient rank gives multipliers that are exactly zero") {
  Random random(5);
  const auto zeros = [](const std::vector<Complex>& values) { return std::count(values.begin(), values.end(), Complex(0.0)); };
  for (const Eigen::Index n : {2, 3, 4, 6}) {
    for (Eigen::Index rank = n - 1; rank >= 0 && rank >= n - 2; --rank) {
      std::vector<Matrix> factors;
      for (int k = 0; k < 7; ++k) {
        LongMatrix D = LongMatrix::Identity(n, n);
        // A singular factor in a random basis, as from a plastic collision of two masses: its zeros are subject to rounding.
        for (Eigen::Index i = rank; i < n && k == 3; ++i) D(i, i) = 0.0L;
        factors.push_back((random_basis(n, random) * D * random_basis(n, random)).cast<double>());
      }
      const std::vector<Complex> values = product_eigenvalues(factors);
      INFO(n << " x " << n << ", rank " << rank);
      CHECK(zeros(values) == n - rank);
      // The zeros are last.
      for (Eigen::Index i = rank; i < n; ++i) CHECK(values[static_cast<std::size_t>(i)] == 0.0);
    }
  }
}

TEST_CASE("a saltation matrix near grazing is not treated as singular") {
  // S of an impact with speed v: an entry of 2 a / v beside k_r.
  Matrix flight(2, 2), impact(2, 2);
  flight << 0.3, 0.8, -0.7, 0.5;
  for (const double speed : {1e-3, 1e-6, 1e-9, 1e-12}) {
    impact << -0.8, 0.0, 2.0 / speed, -0.8;
    const std::vector<Complex> values = product_eigenvalues({flight, impact});
    const double trace = (impact * flight).trace();
    INFO("speed " << speed);
    CHECK(values[0].real() == Approx(trace).epsilon(1e-6));
    CHECK(values[0].real() * values[1].real() == Approx(0.64 * flight.determinant()).epsilon(1e-13));
  }
  // The same impact in one of two uncoupled oscillators.
  Matrix both = Matrix::Zero(4, 4), jump = Matrix::Identity(4, 4);
  both.topLeftCorner(2, 2) = flight;
  both.bottomRightCorner(2, 2) << 0.4, -0.6, 0.5, 0.45;
  jump.topLeftCorner(2, 2) << -0.8, 0.0, 2e9, -0.8;
  double logs = 0.0;
  for (const Complex& value : product_eigenvalues({both, jump})) logs += std::log(std::abs(value));
  CHECK(logs == Approx(std::log(std::abs(both.determinant()) * 0.64)).epsilon(1e-10));
}

TEST_CASE("eigenvalues are sorted by decreasing modulus with conjugates together for equal moduli too") {
  // Two uncoupled oscillators of equal damping: all four moduli are the same.
  Random random(6);
  for (int trial = 0; trial < 50; ++trial) {
    Matrix A = Matrix::Zero(6, 6);
    std::vector<double> angles{random(0.1, 3.0), random(0.1, 3.0)};
    for (Eigen::Index i = 0; i < 2; ++i) {
      const double c = 0.7 * std::cos(angles[static_cast<std::size_t>(i)]),
                   s = 0.7 * std::sin(angles[static_cast<std::size_t>(i)]);
      A.block(2 * i, 2 * i, 2, 2) << c, -s, s, c;
    }
    A(4, 4) = 0.9;
    A(5, 5) = -0.7;
    const std::vector<Complex> values = product_eigenvalues({A});
    REQUIRE(values.size() == 6);
    CHECK(values[0].real() == Approx(0.9));
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (i > 0) CHECK(std::abs(values[i]) < std::abs(values[i - 1]) * (1.0 + 1e-12));
      if (values[i].imag() > 0.0) {
        REQUIRE(i + 1 < values.size());
        CHECK(values[i + 1] == std::conj(values[i]));
      }
    }
  }
}

TEST_CASE("the exponents are ln|mu| over the duration") {
  Matrix A(2, 2);
  A << 0.5, 0.0, 0.0, -2.0;
  const FloquetMultipliers result = multipliers({Section::stroboscopic, {A, A}, {}}, 4.0);
  REQUIRE(result.valid);
  CHECK(result.values[0] == 4.0);
  CHECK(result.values[1] == 0.25);
  CHECK(result.exponents[0] == Approx(std::log(4.0) / 4.0).epsilon(1e-15));
  CHECK(result.exponents[1] == Approx(std::log(0.25) / 4.0).epsilon(1e-15));
  CHECK(result.unstable() == 1);
  CHECK_FALSE(result.stable());
}

TEST_CASE("multipliers of no factors or of a factor that is not finite are not valid") {
  CHECK_FALSE(multipliers({}, 1.0).valid);
  const Matrix broken = Matrix::Constant(2, 2, std::numeric_limits<double>::quiet_NaN());
  const FloquetMultipliers result = multipliers({Section::stroboscopic, {Matrix::Identity(2, 2), broken}, {}}, 1.0);
  CHECK_FALSE(result.valid);
  CHECK_FALSE(result.stable());
}

TEST_CASE("an autonomous section declares its trivial multiplier and puts it last") {
  // The matrix maps the field direction d to itself; the other multipliers are 0.5 and 3.
  Random random(7);
  const Matrix Q = random_basis(3, random).cast<double>();
  const Matrix M = Q * vector({1.0, 0.5, 3.0}).asDiagonal() * Q.inverse();
  const FloquetMultipliers result = multipliers({Section::autonomous, {M}, Q.col(0)}, 1.0);
  REQUIRE(result.valid);
  CHECK(result.trivial == 1);
  REQUIRE(result.values.size() == 3);
  CHECK(std::abs(result.values[0] - 3.0) < 1e-13);
  CHECK(std::abs(result.values[1] - 0.5) < 1e-13);
  CHECK(std::abs(result.values[2] - 1.0) < 1e-13);
  CHECK(result.unstable() == 1);
}
