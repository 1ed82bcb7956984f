// SPDX-License-Identifier: GPL-3.0-or-later
// The Taylor series of cubic_series.hpp with the two columns of Phi, four quantities at a time: with P = (x, dx_1, dx_2, 0) and
// V = (v, dv_1, dv_2, 0),
//     (n+1) P_{n+1} = V_n,   (n+1) V_{n+1} = (A cos_n + c [n = 0], 0, 0, 0) - 2 b V_n - k P_n - beta (1, 3, 3, 0) (X P)_n.
// What takes time is the wait of one coefficient for the one before, from v_n over x_{n+1} and X_{n+1} to v_{n+2}: all that does
// not need the newest is summed beforehand. It is compiled
// for processors with AVX2 and for all others (lib/cubic) and chosen when the program runs; both find the same numbers to the
// last bit. Plain numbers only: nothing else may be compiled for a processor that is not there.
#pragma once

#include <cstddef>
#include <utility>

namespace graze::detail {

/// Cost per step ~ order^2 and length of a step ~ tolerance^(1/order): -ln(tolerance)/2 is best, 15 at 1e-13.
inline constexpr std::size_t cubic_order = 16;

struct CubicTerms {
  double damping = 0.0, stiffness = 0.0, cubic = 0.0, constant = 0.0;
  double force[cubic_order + 1];                        ///< A w^n/n!
  double x0 = 0.0;                                      ///< where `moved` is 0
  double cosine = 1.0, sine = 0.0;                      ///< of the forcing's phase
  double moved = 0.0, v = 0.0, dx[2] = {}, dv[2] = {};  ///< the motion at the step's start
  double x[cubic_order + 1];                            ///< coefficients of x, and of what follows
  alignas(32) double P[cubic_order + 1][4], V[cubic_order + 1][4];
  alignas(16) double square[cubic_order + 1][2];  ///< X, twice
  double last = 0.0, before = 0.0;                ///< CubicSeries::size of the last two orders
};

/// expand: all coefficients from the motion at the step's start; at: (P, V) h later into `to` (8 numbers), for x what it has
/// moved.
struct CubicKernel {
  void (*expand)(CubicTerms& terms);
  void (*at)(const CubicTerms& terms, double h, double* to);
};
extern const CubicKernel cubic_generic, cubic_avx2;
/// The fastest that this processor has.
const CubicKernel& cubic_kernel();

/// `Machine`: four numbers in registers, with load, store, all (four times one number), three (and a zero), twice_both (of two
/// equal ones in memory), first (a number and three zeros), magnitude and sum.
template <class Machine> struct CubicRecurrence {
  using Quad = typename Machine::Quad;

  static void expand(CubicTerms& s) {
    s.x[0] = s.x0 + s.moved;
    const Quad P = Machine::three(s.x[0], s.dx[0], s.dx[1]), V = Machine::three(s.v, s.dv[0], s.dv[1]);
    Machine::store(s.P[0], P);
    Machine::store(s.V[0], V);
    s.square[0][0] = s.square[0][1] = s.x[0] * s.x[0];
    expand(s, P, V, std::make_index_sequence<cubic_order>());
    const Quad one = Machine::all(1.0);
    const Quad weight_P = one / (one + Machine::magnitude(P)), weight_V = one / (one + Machine::magnitude(V));
    const auto size = [&](std::size_t k) {
      const double sum = Machine::sum(Machine::magnitude(Machine::load(s.P[k])) * weight_P +
                                      Machine::magnitude(Machine::load(s.V[k])) * weight_V);
      return sum + (s.force[k] < 0.0 ? -s.force[k] : s.force[k]);
    };
    s.last = size(cubic_order);
    s.before = size(cubic_order - 1);
  }

  static void at(const CubicTerms& s, double h, double* to) {
    static_assert(cubic_order % 2 == 0);
    const Quad step = Machine::all(h), square = Machine::all(h * h);
    Quad even_P = Machine::load(s.P[cubic_order]), odd_P = Machine::load(s.P[cubic_order - 1]);
    Quad even_V = Machine::load(s.V[cubic_order]), odd_V = Machine::load(s.V[cubic_order - 1]);
#pragma GCC unroll 8
    for (std::size_t k = cubic_order; k > 2; k -= 2) {  // even and odd powers side by side: half as long a chain
      even_P = Machine::load(s.P[k - 2]) + square * even_P;
      odd_P = Machine::load(s.P[k - 3]) + square * odd_P;
      even_V = Machine::load(s.V[k - 2]) + square * even_V;
      odd_V = Machine::load(s.V[k - 3]) + square * odd_V;
    }
    Machine::store(to, Machine::three(s.moved, s.dx[0], s.dx[1]) + step * (odd_P + step * even_P));
    Machine::store(to + 4, Machine::load(s.V[0]) + step * (odd_V + step * even_V));
  }

 private:
  struct Newest {
    Quad P, V;
    double v, square;
  };

  template <std::size_t... n> static void expand(CubicTerms& s, Quad P, Quad V, std::index_sequence<n...>) {
    const double beta = -s.cubic;
    alignas(32) const double tangent[4] = {beta, 3.0 * beta, 3.0 * beta, 0.0};
    const Quad cubic = Machine::load(tangent);
    Newest newest{P, V, s.v, s.square[0][0]};
    (next<n>(s, newest, cubic, cubic * P), ...);
  }

  /// Coefficients n + 1 of everything from those up to n.
  template <std::size_t n> [[gnu::always_inline]] static void next(CubicTerms& s, Newest& newest, Quad cubic, Quad cubic_P0) {
    constexpr std::size_t m = n + 1;
    constexpr double inverse = 1.0 / static_cast<double>(m);
    const Quad part = Machine::all(inverse), P = newest.P, V = newest.V;
    // From the middle outwards: what was found last enters last.
    double square = m % 2 == 0 ? 0.5 * s.x[m / 2] * s.x[m / 2] : 0.0;
#pragma GCC unroll 8
    for (std::size_t i = m / 2 + 1; i < m; ++i) square += s.x[i] * s.x[m - i];
    const double x = inverse * newest.v;
    square = 2.0 * square + (2.0 * s.x[0]) * x;
    Quad one = Machine::all(0.0), two = one;
    if constexpr (n % 2 == 0 && n > 0) one = Machine::twice_both(s.square[n / 2]) * Machine::load(s.P[n / 2]);
#pragma GCC unroll 8
    for (std::size_t i = n / 2 + 1; i < n; ++i) {
      one = one + Machine::twice_both(s.square[i]) * Machine::load(s.P[n - i]);
      two = two + Machine::twice_both(s.square[n - i]) * Machine::load(s.P[i]);
    }
    if constexpr (n > 0) two = two + Machine::twice_both(s.square[0]) * P;
    double force = s.force[n] * (n % 2 == 0 ? s.cosine : s.sine);
    if constexpr ((n + 1) % 4 >= 2) force = -force;
    if constexpr (n == 0) force += s.constant;
    const Quad pull = Machine::first(force) + Machine::all(-s.stiffness) * P;
    const Quad known = (part * Machine::all(-2.0 * s.damping)) * V + (part * pull + (part * cubic) * (one + two));
    newest.P = part * V;
    newest.V = known + Machine::all(newest.square) * (part * cubic_P0);
    newest.v = Machine::front(newest.V);
    newest.square = square;
    s.x[m] = x;
    s.square[m][0] = s.square[m][1] = square;
    Machine::store(s.P[m], newest.P);
    Machine::store(s.V[m], newest.V);
  }
};

}  // namespace graze::detail
