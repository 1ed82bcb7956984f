// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/detail/cubic_tangent.hpp>

namespace graze::detail {

namespace {

struct Avx2 {
  using Quad [[gnu::vector_size(32)]] = double;
  static Quad load(const double* from) { return *reinterpret_cast<const Quad*>(from); }
  static void store(double* to, const Quad& a) { *reinterpret_cast<Quad*>(to) = a; }
  static Quad all(double a) { return Quad{a, a, a, a}; }
  static Quad twice_both(const double* from) { return all(*from); }
  static Quad three(double a, double b, double c) { return Quad{a, b, c, 0.0}; }
  static Quad first(double a) { return Quad{a, 0.0, 0.0, 0.0}; }
  static Quad magnitude(const Quad& a) { return a < 0.0 ? -a : a; }
  static double front(const Quad& a) { return a[0]; }
  static double sum(const Quad& a) { return (a[0] + a[2]) + (a[1] + a[3]); }
};

}  // namespace

const CubicKernel cubic_avx2 = {CubicRecurrence<Avx2>::expand, CubicRecurrence<Avx2>::at};

}  // namespace graze::detail
