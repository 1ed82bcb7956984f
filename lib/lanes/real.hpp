// SPDX-License-Identifier: GPL-3.0-or-later
// Real: a number of one motion (double), or the same number of as many motions as a SIMD register holds (xsimd::batch). What the
// lanes do is written once for both, without fused multiply-add: the result is the same to the last bit on any machine.
#pragma once

#include <xsimd/xsimd.hpp>

#include <cmath>
#include <cstddef>

namespace graze::lanes {

template <class Real> inline constexpr std::size_t width = Real::size;
template <> inline constexpr std::size_t width<double> = 1;

template <class Real> struct MaskType { using type = typename Real::batch_bool_type; };
template <> struct MaskType<double> { using type = bool; };
template <class Real> using Mask = typename MaskType<Real>::type;

// Always inlined: a copy of them compiled for one processor must not serve another.
[[gnu::always_inline]] inline double select(bool mask, double a, double b) { return mask ? a : b; }
[[gnu::always_inline]] inline bool any(bool mask) { return mask; }
[[gnu::always_inline]] inline int count(bool mask) { return mask ? 1 : 0; }
template <class T, class A> int count(const xsimd::batch_bool<T, A>& mask) {
  using Batch = xsimd::batch<T, A>;
  return static_cast<int>(xsimd::hadd(xsimd::select(mask, Batch(1.0), Batch(0.0))));
}
using std::abs, std::sqrt, xsimd::abs, xsimd::sqrt;
using xsimd::any;
using xsimd::select;
[[gnu::always_inline]] inline double least(double a, double b) { return a < b ? a : b; }
[[gnu::always_inline]] inline double largest(double a, double b) { return a > b ? a : b; }
template <class Real> Real least(const Real& a, const Real& b) { return xsimd::min(a, b); }
template <class Real> Real largest(const Real& a, const Real& b) { return xsimd::max(a, b); }

/// From and to an array of width<Real> numbers, aligned for it.
template <class Real> Real take(const double* from) {
  if constexpr (width<Real> == 1)
    return *from;
  else
    return Real::load_aligned(from);
}
[[gnu::always_inline]] inline void put(double* to, double value) { *to = value; }
template <class Real> void put(double* to, const Real& value) { value.store_aligned(to); }

/// cos and sin for 0 <= angle <= 3 to a few units in the last place: Taylor polynomials at a quarter of it (left out:
/// 0.75^17/17! = 2e-17), squared twice as a complex number.
template <class Real> void circle(const Real& angle, Real& c, Real& s) {
  const Real x = 0.25 * angle, square = x * x;
  c = Real(1.0 / 20922789888000.0);
  s = Real(-1.0 / 1307674368000.0);
  constexpr double even[] = {
      -1.0 / 87178291200.0, 1.0 / 479001600.0, -1.0 / 3628800.0, 1.0 / 40320.0, -1.0 / 720.0, 1.0 / 24.0, -0.5, 1.0};
  constexpr double odd[] = {1.0 / 6227020800.0, -1.0 / 39916800.0, 1.0 / 362880.0, -1.0 / 5040.0, 1.0 / 120.0, -1.0 / 6.0, 1.0};
  for (const double term : even) c = term + square * c;
  for (const double term : odd) s = term + square * s;
  s = x * s;
  for (int twice = 0; twice < 2; ++twice) {
    const Real both = c * s;
    c = (c - s) * (c + s);
    s = both + both;
  }
}

/// e^-x for 0 <= x <= 3, in the same way.
template <class Real> Real decay(const Real& x) {
  const Real part = -0.25 * x;
  Real sum = Real(1.0);
  for (int k = 16; k > 0; --k) sum = 1.0 + ((1.0 / k) * part) * sum;
  const Real square = sum * sum;
  return square * square;
}

}  // namespace graze::lanes
