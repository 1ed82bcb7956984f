// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/flow/series_kernels.hpp>

#include <immintrin.h>

namespace graze::detail {

namespace {

struct Fused {
  using Quad = __m256d;
  static Quad load(const double* from) { return _mm256_load_pd(from); }
  static void store(double* to, Quad a) { _mm256_store_pd(to, a); }
  static Quad all(double a) { return _mm256_set1_pd(a); }
  static Quad set(double a, double b, double c, double d) { return _mm256_set_pd(d, c, b, a); }
  static Quad first(double a) { return _mm256_zextpd128_pd256(_mm_set_sd(a)); }
  static Quad fma(Quad a, Quad b, Quad c) { return _mm256_fmadd_pd(a, b, c); }
  static double fma(double a, double b, double c) { return __builtin_fma(a, b, c); }
  static Quad magnitude(Quad a) { return _mm256_andnot_pd(_mm256_set1_pd(-0.0), a); }
  static double sum(Quad a) { return (a[0] + a[2]) + (a[1] + a[3]); }
  static double largest(Quad a) {
    const double one = a[0] > a[2] ? a[0] : a[2], two = a[1] > a[3] ? a[1] : a[3];
    return one > two ? one : two;
  }
  static Quad swapped(Quad a, Quad b) { return _mm256_blend_pd(_mm256_permute_pd(a, 0b0101), b, 0b1100); }
  static Quad high_less_low(Quad a, Quad b) { return _mm256_permute2f128_pd(a, a, 0x11) - _mm256_permute2f128_pd(b, b, 0x00); }
};

}  // namespace

constinit const SeriesKernels series_fused = kernels_for<Fused>();

}  // namespace graze::detail
