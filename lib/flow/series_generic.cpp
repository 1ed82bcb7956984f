// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/flow/series_kernels.hpp>
#include <graze/lib/numerics/processor.hpp>

namespace graze::detail {

namespace {

/// Four numbers in two registers of two.
struct Generic {
  using Pair [[gnu::vector_size(16)]] = double;
  struct Quad {
    Pair low, high;
    friend Quad operator+(const Quad& a, const Quad& b) { return {a.low + b.low, a.high + b.high}; }
    friend Quad operator-(const Quad& a, const Quad& b) { return {a.low - b.low, a.high - b.high}; }
    friend Quad operator*(const Quad& a, const Quad& b) { return {a.low * b.low, a.high * b.high}; }
    friend Quad operator/(const Quad& a, const Quad& b) { return {a.low / b.low, a.high / b.high}; }
  };
  static Quad load(const double* from) {
    return {*reinterpret_cast<const Pair*>(from), *reinterpret_cast<const Pair*>(from + 2)};
  }
  static void store(double* to, const Quad& a) {
    *reinterpret_cast<Pair*>(to) = a.low;
    *reinterpret_cast<Pair*>(to + 2) = a.high;
  }
  static Quad all(double a) { return {Pair{a, a}, Pair{a, a}}; }
  static Quad set(double a, double b, double c, double d) { return {Pair{a, b}, Pair{c, d}}; }
  static Quad first(double a) { return {Pair{a, 0.0}, Pair{}}; }
  static Quad fma(const Quad& a, const Quad& b, const Quad& c) { return a * b + c; }
  static double fma(double a, double b, double c) { return a * b + c; }
  static Quad magnitude(const Quad& a) { return {a.low < 0.0 ? -a.low : a.low, a.high < 0.0 ? -a.high : a.high}; }
  static double sum(const Quad& a) { return (a.low[0] + a.high[0]) + (a.low[1] + a.high[1]); }
  static double largest(const Quad& a) {
    const Pair most = a.low > a.high ? a.low : a.high;
    return most[0] > most[1] ? most[0] : most[1];
  }
  static Quad swapped(const Quad& a, const Quad& b) { return {Pair{a.low[1], a.low[0]}, b.high}; }
  static Quad high_less_low(const Quad& a, const Quad& b) { return {a.high - b.low, a.high - b.low}; }
};

}  // namespace

constinit const SeriesKernels series_generic = kernels_for<Generic>();

const SeriesKernels& series_kernels() {
#ifdef GRAZE_X86_LANES
  static const bool fused = processor_has_avx2_fma();
  if (fused) return series_fused;
#endif
  return series_generic;
}

}  // namespace graze::detail
