// SPDX-License-Identifier: GPL-3.0-or-later
// Real: a number of one motion (double), or the same number of as many motions as a SIMD register holds (xsimd::batch). The
// code of the lanes is written once for both. It is compiled twice, with and without fused multiply-add (GRAZE_FUSED), each in
// a namespace of its own. Only madd() and msub() are fused: the result is the same to the last bit in any number of lanes, and
// on all machines that fuse.
#pragma once

#include <xsimd/xsimd.hpp>

#include <bit>
#include <cmath>
#include <type_traits>

#ifdef GRAZE_FUSED
#define GRAZE_ARITHMETIC with_fma
#else
#define GRAZE_ARITHMETIC without_fma
#endif

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

template <class Real> inline constexpr std::size_t width = Real::size;
template <> inline constexpr std::size_t width<double> = 1;

template <class Real> struct MaskType { using type = typename Real::batch_bool_type; };
template <> struct MaskType<double> { using type = bool; };
template <class Real> using Mask = typename MaskType<Real>::type;

// Always inlined, so that a copy compiled for one processor cannot serve another.
[[gnu::always_inline]] inline double select(bool mask, double a, double b) { return mask ? a : b; }
[[gnu::always_inline]] inline bool any(bool mask) { return mask; }
[[gnu::always_inline]] inline unsigned bits(bool mask) { return mask ? 1U : 0U; }
/// Where a is true and b is not.
[[gnu::always_inline]] inline bool and_not(bool a, bool b) { return a && !b; }
template <class T, class A> xsimd::batch_bool<T, A> and_not(const xsimd::batch_bool<T, A>& a, const xsimd::batch_bool<T, A>& b) {
#if XSIMD_WITH_AVX512F
  if constexpr (std::is_same_v<A, xsimd::avx512f>) return static_cast<__mmask8>(a.data & ~b.data);
#endif
#if XSIMD_WITH_AVX2
  if constexpr (std::is_same_v<A, xsimd::avx2>) return _mm256_andnot_pd(b.data, a.data);
#endif
  return a & !b;
}
/// The mask as bits: bit i is that of lane i.
template <class T, class A> unsigned bits(const xsimd::batch_bool<T, A>& mask) {
#if XSIMD_WITH_AVX512F
  if constexpr (std::is_same_v<A, xsimd::avx512f>) return mask.data;
#endif
#if XSIMD_WITH_AVX2
  if constexpr (std::is_same_v<A, xsimd::avx2>) return static_cast<unsigned>(_mm256_movemask_pd(mask.data));
#endif
  using Batch = xsimd::batch<T, A>;
  alignas(64) double one[Batch::size];
  xsimd::select(mask, Batch(1.0), Batch(0.0)).store_aligned(one);
  unsigned all = 0;
  for (std::size_t i = 0; i < Batch::size; ++i) all |= one[i] > 0.5 ? 1U << i : 0U;
  return all;
}
/// The mask with these bits.
template <class Real> Mask<Real> mask_of(unsigned bits) {
  if constexpr (width<Real> == 1) return bits != 0;
#if XSIMD_WITH_AVX512F
  else if constexpr (width<Real> == 8)
    return Mask<Real>(static_cast<__mmask8>(bits));
#endif
#if XSIMD_WITH_AVX2
  else if constexpr (width<Real> == 4) {
    const __m256i each = _mm256_setr_epi64x(1, 2, 4, 8);
    return Mask<Real>(_mm256_castsi256_pd(_mm256_cmpeq_epi64(_mm256_and_si256(_mm256_set1_epi64x(bits), each), each)));
  }
#endif
  else {
    alignas(64) double one[width<Real>];
    for (std::size_t i = 0; i < width<Real>; ++i) one[i] = static_cast<double>(bits >> i & 1U);
    return Real::load_aligned(one) > Real(0.5);
  }
}
template <class Mask, class Function> void for_each(const Mask& mask, const Function& function) {
  for (unsigned lanes = bits(mask); lanes != 0; lanes &= lanes - 1) function(static_cast<std::size_t>(std::countr_zero(lanes)));
}
using std::abs, std::floor, std::sqrt, xsimd::abs, xsimd::floor, xsimd::sqrt;
using xsimd::any;
using xsimd::select;
[[gnu::always_inline]] inline double least(double a, double b) { return a < b ? a : b; }
[[gnu::always_inline]] inline double largest(double a, double b) { return a > b ? a : b; }
template <class Real> Real least(const Real& a, const Real& b) { return xsimd::min(a, b); }
template <class Real> Real largest(const Real& a, const Real& b) { return xsimd::max(a, b); }

/// Loads from and stores to an aligned array of width<Real> numbers.
template <class Real> Real take(const double* from) {
  if constexpr (width<Real> == 1)
    return *from;
  else
    return Real::load_aligned(from);
}
[[gnu::always_inline]] inline void put(double* to, double value) { *to = value; }
template <class Real> void put(double* to, const Real& value) { value.store_aligned(to); }

/// a b + c.
[[gnu::always_inline]] inline double madd(double a, double b, double c) {
#ifdef GRAZE_FUSED
  return __builtin_fma(a, b, c);
#else
  return a * b + c;
#endif
}
template <class Real> [[gnu::always_inline]] inline Real madd(const Real& a, const Real& b, const Real& c) {
#ifdef GRAZE_FUSED
#if XSIMD_WITH_AVX512F
  if constexpr (width<Real> == 8) return _mm512_fmadd_pd(a, b, c);
#endif
  if constexpr (width<Real> == 4) return _mm256_fmadd_pd(a, b, c);
  if constexpr (width<Real> == 2) return _mm_fmadd_pd(a, b, c);
#else
  return a * b + c;
#endif
}
/// a b - c. (Not madd(a, b, -c): in eight lanes xsimd forms -c as 0 - c, which is 0 where the others have -0.)
[[gnu::always_inline]] inline double msub(double a, double b, double c) {
#ifdef GRAZE_FUSED
  return __builtin_fma(a, b, -c);
#else
  return a * b - c;
#endif
}
template <class Real> [[gnu::always_inline]] inline Real msub(const Real& a, const Real& b, const Real& c) {
#ifdef GRAZE_FUSED
#if XSIMD_WITH_AVX512F
  if constexpr (width<Real> == 8) return _mm512_fmsub_pd(a, b, c);
#endif
  if constexpr (width<Real> == 4) return _mm256_fmsub_pd(a, b, c);
  if constexpr (width<Real> == 2) return _mm_fmsub_pd(a, b, c);
#else
  return a * b - c;
#endif
}
/// a b + c d and a b - c d.
template <class Real> [[gnu::always_inline]] inline Real dot(const Real& a, const Real& b, const Real& c, const Real& d) {
  return madd(a, b, Real(c * d));
}
template <class Real> [[gnu::always_inline]] inline Real wedge(const Real& a, const Real& b, const Real& c, const Real& d) {
  return msub(a, b, Real(c * d));
}

/// a[0] + a[1] x + ...: even and odd powers side by side.
template <class Real, std::size_t N> [[gnu::always_inline]] inline Real polynomial(const double (&a)[N], const Real& x) {
  constexpr std::size_t even_top = (N - 1) / 2 * 2, odd_top = N / 2 * 2 - 1;
  const Real square = x * x;
  Real even = Real(a[even_top]), odd = Real(a[odd_top]);
#pragma GCC unroll 16
  for (std::size_t k = even_top; k > 0; k -= 2) even = madd(square, even, Real(a[k - 2]));
#pragma GCC unroll 16
  for (std::size_t k = odd_top; k > 1; k -= 2) odd = madd(square, odd, Real(a[k - 2]));
  return madd(x, odd, even);
}

/// 1/(2 k)! and 1/(2 k + 1)! with alternating signs, 1/k!.
inline constexpr double inverse_even[] = {
    1.0, -0.5, 1.0 / 24.0, -1.0 / 720.0, 1.0 / 40320.0, -1.0 / 3628800.0, 1.0 / 479001600.0, -1.0 / 87178291200.0};
inline constexpr double inverse_odd[] = {
    1.0, -1.0 / 6.0, 1.0 / 120.0, -1.0 / 5040.0, 1.0 / 362880.0, -1.0 / 39916800.0, 1.0 / 6227020800.0};
inline constexpr double inverse_factorial[] = {1.0,
                                               1.0,
                                               0.5,
                                               1.0 / 6.0,
                                               1.0 / 24.0,
                                               1.0 / 120.0,
                                               1.0 / 720.0,
                                               1.0 / 5040.0,
                                               1.0 / 40320.0,
                                               1.0 / 362880.0,
                                               1.0 / 3628800.0,
                                               1.0 / 39916800.0,
                                               1.0 / 479001600.0,
                                               1.0 / 6227020800.0,
                                               1.0 / 87178291200.0};

/// cos and sin for 0 <= angle <= 0.45 to a few units in the last place, by Taylor polynomials (truncation error: 0.45^15/15! =
/// 5e-18).
template <class Real> [[gnu::always_inline]] inline void small_circle(const Real& angle, Real& c, Real& s) {
  const Real square = angle * angle;
  c = polynomial(inverse_even, square);
  s = angle * polynomial(inverse_odd, square);
}

/// The same for 0 <= angle <= 3: at an eighth of the angle, then squared three times as a complex number.
template <class Real> void circle(const Real& angle, Real& c, Real& s) {
  small_circle(Real(0.125 * angle), c, s);
  for (int times = 0; times < 3; ++times) {
    const Real both = c * s;
    c = (c - s) * (c + s);
    s = both + both;
  }
}

/// e^-x for 0 <= x <= 0.45 (truncation error: 0.45^15/15!).
template <class Real> [[gnu::always_inline]] inline Real decay(const Real& x) { return polynomial(inverse_factorial, Real(-x)); }

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
