// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/detail/cubic_tangent.hpp>
#include <graze/lib/detail/pair.hpp>
#include <graze/lib/lane_width.hpp>

namespace graze::detail {

namespace {

/// Two pairs.
struct TwoPairs {
  Pair low, high;
  friend TwoPairs operator+(const TwoPairs& a, const TwoPairs& b) { return {a.low + b.low, a.high + b.high}; }
  friend TwoPairs operator*(const TwoPairs& a, const TwoPairs& b) { return {a.low * b.low, a.high * b.high}; }
  friend TwoPairs operator/(const TwoPairs& a, const TwoPairs& b) { return {a.low / b.low, a.high / b.high}; }
};

struct Generic {
  using Quad = TwoPairs;
  static Quad load(const double* from) {
    return {*reinterpret_cast<const Pair*>(from), *reinterpret_cast<const Pair*>(from + 2)};
  }
  static void store(double* to, const Quad& a) {
    *reinterpret_cast<Pair*>(to) = a.low;
    *reinterpret_cast<Pair*>(to + 2) = a.high;
  }
  static Quad all(double a) { return {Pair{a, a}, Pair{a, a}}; }
  static Quad twice_both(const double* from) {
    const Pair both = *reinterpret_cast<const Pair*>(from);
    return {both, both};
  }
  static Quad three(double a, double b, double c) { return {Pair{a, b}, Pair{c, 0.0}}; }
  static Quad first(double a) { return {Pair{a, 0.0}, Pair{}}; }
  static Quad magnitude(const Quad& a) { return {a.low < 0.0 ? -a.low : a.low, a.high < 0.0 ? -a.high : a.high}; }
  static double front(const Quad& a) { return a.low[0]; }
  static double sum(const Quad& a) { return (a.low[0] + a.high[0]) + (a.low[1] + a.high[1]); }
};

}  // namespace

const CubicKernel cubic_generic = {CubicRecurrence<Generic>::expand, CubicRecurrence<Generic>::at};

const CubicKernel& cubic_kernel() {
#ifdef GRAZE_X86_LANES
  static const bool has_avx2 = available(LaneWidth::avx2);
  if (has_avx2) return cubic_avx2;
#endif
  return cubic_generic;
}

}  // namespace graze::detail
