// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers of the reference: double to follow a family, Quad (113 bits, libquadmath) to locate its points. Their functions have
// separate names, because in ISO mode std:: has none for Quad.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

namespace graze::reference {

__extension__ typedef __float128 Quad;

// From libquadmath. Only g++ ships its header; other compilers (and clang-tidy) do not find it.
extern "C" {
Quad sinq(Quad x) noexcept;
Quad cosq(Quad x) noexcept;
Quad expq(Quad x) noexcept;
Quad sqrtq(Quad x) noexcept;
Quad fabsq(Quad x) noexcept;
Quad atan2q(Quad y, Quad x) noexcept;
}

inline double sine(double x) { return std::sin(x); }
inline double cosine(double x) { return std::cos(x); }
inline double exponential(double x) { return std::exp(x); }
inline double root(double x) { return std::sqrt(x); }
inline double arctangent(double y, double x) { return std::atan2(y, x); }
inline double magnitude(double x) { return std::fabs(x); }
inline Quad sine(Quad x) { return sinq(x); }
inline Quad cosine(Quad x) { return cosq(x); }
inline Quad exponential(Quad x) { return expq(x); }
inline Quad root(Quad x) { return sqrtq(x); }
inline Quad arctangent(Quad y, Quad x) { return atan2q(y, x); }
inline Quad magnitude(Quad x) { return fabsq(x); }

template <class Real> Real pi() {
  static const Real value = arctangent(Real(0), Real(-1));
  return value;
}

template <class Real> using Values = std::vector<Real>;

template <class To, class From> Values<To> converted(const Values<From>& from) {
  Values<To> out;
  for (const From& value : from) out.push_back(static_cast<To>(value));
  return out;
}

/// Square or wide matrix, by rows.
template <class Real> struct Table {
  std::size_t rows = 0, columns = 0;
  Values<Real> entries;
  Table(std::size_t r, std::size_t c) : rows(r), columns(c), entries(r * c, Real(0)) {}
  Real& operator()(std::size_t i, std::size_t j) { return entries[i * columns + j]; }
  const Real& operator()(std::size_t i, std::size_t j) const { return entries[i * columns + j]; }
};

template <class Real> Table<Real> operator*(const Table<Real>& A, const Table<Real>& B) {
  Table<Real> out(A.rows, B.columns);
  for (std::size_t i = 0; i < A.rows; ++i)
    for (std::size_t k = 0; k < A.columns; ++k)
      for (std::size_t j = 0; j < B.columns; ++j) out(i, j) += A(i, k) * B(k, j);
  return out;
}

/// Gaussian elimination with row pivoting: solves A x = y in place and returns det A. y is unchanged if A is singular.
template <class Real> Real solve(Table<Real> A, Values<Real>& y) {
  const std::size_t n = A.rows;
  Real determinant(1);
  Values<Real> x = y;
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < n; ++i)
      if (magnitude(A(i, k)) > magnitude(A(pivot, k))) pivot = i;
    if (A(pivot, k) == Real(0)) return Real(0);
    if (pivot != k) {
      for (std::size_t j = 0; j < n; ++j) std::swap(A(k, j), A(pivot, j));
      std::swap(x[k], x[pivot]);
      determinant = -determinant;
    }
    determinant *= A(k, k);
    for (std::size_t i = k + 1; i < n; ++i) {
      const Real factor = A(i, k) / A(k, k);
      for (std::size_t j = k; j < n; ++j) A(i, j) -= factor * A(k, j);
      x[i] -= factor * x[k];
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t j = k + 1; j < n; ++j) x[k] -= A(k, j) * x[j];
    x[k] /= A(k, k);
  }
  y = x;
  return determinant;
}

}  // namespace graze::reference
