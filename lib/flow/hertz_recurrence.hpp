// SPDX-License-Identifier: GPL-3.0-or-later
// Taylor series in s of a Hertz contact in regularising variables (hertz_flow.hpp), of its tangent and of its derivatives in
// the parameters. With y = sqrt(x - r), u = y^2, dt = y ds the powers of y are products of series, and the factors of the speed
// v = 2 dy/ds have integrals: y v = du/ds, y^4 v = (2/5) d(y^5)/ds. Hence
//     dv/ds = xi y cos - r y - y^3 - beta y x^3 - k_H y^4 - d/ds (2 b u + (2/5) k_H b_H y^5),
//     d(cos, sin)/ds = eta y (-sin, cos),   dt/ds = y,   d(ln det)/ds = -(2 b y + k_H b_H y^4).
// A column (dx, dv) of the tangent, at fixed time, is carried as (dx, q), q = dv + (2 b + k_H b_H y^3) dx:
//     d(dx)/ds = y q - (2 b y + k_H b_H y^4) dx,   dq/ds = -(y + 3 beta y x^2 + (3/2) k_H y^2) dx + y f_p.
// Four series at a time: y (y^2, y^4, y^6) = (y^3, y^5, y^7), the squares of (y, y^2, y^3), y (cos, sin, q_1, q_2) and the two
// factors of (dx_1, dx_2); further columns by fours.
//
// Compiled for more than one kind of processor (series_kernels.hpp): plain numbers only.
#pragma once

#include <graze/lib/flow/hertz_terms.hpp>
#include <graze/lib/flow/quad_series.hpp>

#include <utility>

namespace graze::detail {

template <class Machine, std::size_t Quads> struct HertzRecurrence {
  using Terms = HertzTerms<Quads>;
  using Quad = typename Machine::Quad;
  using Sums = QuadSums<Machine, hertz_order>;
  using C = HertzContact;
  using QuadSeries = typename Terms::QuadSeries;

  static void expand(Terms& s) {
    const auto& z = s.start;
    const double y = z.y, u = y * y, y3 = y * u;
    Machine::store(s.motion[0], Machine::set(y, z.v, z.time, z.divergence));
    Machine::store(s.odd[0], Machine::set(y3, u * y3, u * u * y3, 0.0));
    Machine::store(s.even[0], Machine::set(u, u * u, y3 * y3, 0.0));
    Machine::store(s.roots[0], Machine::set(y, u, y3, 0.0));
    Machine::store(s.forced[0], Machine::set(z.cosine, z.sine, z.q[0], z.q[1]));
    Machine::store(s.dx[0], Machine::set(z.dx[0], z.dx[1], z.dx[0], z.dx[1]));
    for (std::size_t j = 0; j < Terms::more; ++j) {
      const double *dx = z.dx + 2 + 4 * j, *q = z.q + 2 + 4 * j;
      Machine::store(s.more_dx[j][0], Machine::set(dx[0], dx[1], dx[2], dx[3]));
      Machine::store(s.more_q[j][0], Machine::set(q[0], q[1], q[2], q[3]));
    }
    const double loss = s.q[C::stiffness] * s.q[C::contact_damping], b2 = 2.0 * s.q[C::damping];
    const Constants constants{loss, 0.4 * loss, b2, b2 + 0.8 * loss * y3, 0.4 * loss * y, 2.0 * (b2 * y + loss * u * u)};
    expand(s, constants, std::make_index_sequence<hertz_order>());
    sizes(s);
  }

  /// The contact h (in s) after the step's start.
  static void at(const Terms& s, double h, typename Terms::State& to) {
    alignas(32) double z[4];
    Machine::store(z, Sums::at(s.motion, h));
    to.y = z[0];
    to.v = z[1];
    to.time = z[2];
    to.divergence = z[3];
    Machine::store(z, Sums::at(s.forced, h));
    to.cosine = z[0];
    to.sine = z[1];
    if constexpr (Quads > 0) {
      to.q[0] = z[2];
      to.q[1] = z[3];
      Machine::store(z, Sums::at(s.dx, h));
      to.dx[0] = z[0];
      to.dx[1] = z[1];
    }
    for (std::size_t j = 0; j < Terms::more; ++j) {
      alignas(32) double dx[4];
      Machine::store(z, Sums::at(s.more_q[j], h));
      Machine::store(dx, Sums::at(s.more_dx[j], h));
      for (std::size_t i = 0; i < 4; ++i) {
        to.q[2 + 4 * j + i] = z[i];
        to.dx[2 + 4 * j + i] = dx[i];
      }
    }
  }

 private:
  struct Constants {
    double loss, loss5;                       ///< k_H b_H, and 2/5 of it
    double b2, square_y, square_u, newest_y;  ///< 2 b; weights of the squares, and of the newest y, in the speed
  };

  static void sizes(Terms& s) {
    const auto weight = [](const double* first) {
      return Machine::all(1.0) / (Machine::all(1.0) + Machine::magnitude(Machine::load(first)));
    };
    // Weights of y and v. The time, of order 1, counts unweighted, and the divergence does not count.
    const Quad motion = weight(s.motion[0]) * Machine::set(1.0, 1.0, 0.0, 0.0), forced = weight(s.forced[0]),
               dx = weight(s.dx[0]);
    const auto size = [&](std::size_t k) {
      alignas(32) double a[4], b[4];
      Machine::store(a, Machine::magnitude(Machine::load(s.motion[k])) * motion);
      Machine::store(b, Machine::magnitude(Machine::load(s.forced[k])) * forced);
      const double time = s.motion[k][2] < 0.0 ? -s.motion[k][2] : s.motion[k][2];
      double all = (a[0] < a[1] ? a[1] : a[0]) + (b[0] < b[1] ? b[1] : b[0]) + time;
      if constexpr (Quads > 0) {
        const double tangent = Machine::largest(Machine::magnitude(Machine::load(s.dx[k])) * dx), q = b[2] < b[3] ? b[3] : b[2];
        all = nan_keeping_max(all, nan_keeping_max(tangent, q));
      }
      for (std::size_t j = 0; j < Terms::more; ++j)
        for (const QuadSeries* series : {&s.more_dx[j], &s.more_q[j]})
          all = nan_keeping_max(all, Machine::largest(Machine::magnitude(Machine::load((*series)[k])) * weight((*series)[0])));
      return all;
    };
    s.last = size(hertz_order);
    s.before = size(hertz_order - 1);
  }
  /// The larger of both; not a number if `b` is not.
  static double nan_keeping_max(double a, double b) { return a > b ? a : b; }

  template <std::size_t... k> static void expand(Terms& s, const Constants& c, std::index_sequence<k...>) {
    (next<k>(s, c), ...);
  }

  /// Coefficients k + 1 of everything from those up to k.
  template <std::size_t k> [[gnu::always_inline]] static void next(Terms& s, const Constants& c) {
    constexpr std::size_t m = k + 1;
    constexpr double inverse = 1.0 / static_cast<double>(m);
    const double r = s.q[C::barrier], k_H = s.q[C::stiffness], beta = s.q[C::beta], w = s.q[C::frequency];
    const double y_k = s.motion[k][0], v_k = s.motion[k][1], u_k = s.even[k][0], y3 = s.odd[k][0], y4 = s.even[k][1];
    const auto fma = [](double a, double b, double d) { return Machine::fma(a, b, d); };

    // Powers of y: first without y_{k+1}, in which they are linear.
    Quad squares = Machine::all(0.0), odds = squares, more_odds = squares;
    if constexpr (m % 2 == 0) squares = Machine::load(s.roots[m / 2]) * Machine::load(s.roots[m / 2]);
#pragma GCC unroll 8
    for (std::size_t i = (m - 1) / 2; i > 0; --i)
      squares = Machine::fma(Machine::load(s.twice_roots[i]), Machine::load(s.roots[m - i]), squares);
    if constexpr (m % 2 == 0) odds = Machine::all(s.motion[m / 2][0]) * Machine::load(s.even[m / 2]);
#pragma GCC unroll 8
    for (std::size_t i = m / 2 + 1; i < m; ++i) {
      odds = Machine::fma(Machine::all(s.motion[i][0]), Machine::load(s.even[m - i]), odds);
      more_odds = Machine::fma(Machine::all(s.motion[m - i][0]), Machine::load(s.even[i]), more_odds);
    }
    alignas(32) double square[4], odd[4];
    Machine::store(square, squares);
    Machine::store(odd, odds + more_odds);

    const Quad forcing = Sums::template product<k, 0>(s.motion, s.forced);
    alignas(32) double forced[4];
    Machine::store(forced, forcing);

    double restoring = fma(r, y_k, fma(k_H, y4, y3)), cubic = 0.0;
    if (s.with_cubic) {  // y x^2 and y x^3 in powers of y
      const double y5 = s.odd[k][1], y7 = s.odd[k][2];
      cubic = 3.0 * beta * fma(r, fma(r, y_k, 2.0 * y3), y5);
      s.yx3[k] = fma(r, fma(r, fma(r, y_k, 3.0 * y3), 3.0 * y5), y7);
      restoring = fma(beta, s.yx3[k], restoring);
    }
    const double losses = fma(c.loss5, odd[1], fma(c.square_y, square[0], c.square_u * square[1]));
    const double known = fma(inverse * s.q[C::amplitude], forced[0], -losses);

    const double y0 = s.motion[0][0], u0 = s.even[0][0];
    const double y = 0.5 * inverse * v_k, u = fma(2.0 * y0, y, square[0]);
    const double v = fma(-c.newest_y, y, fma(-inverse, restoring, known));
    const double next_y4 = fma(2.0 * u0, u, square[1]), next_y3 = fma(y0, u, fma(u0, y, odd[0]));
    const double next_y5 = fma(y0, next_y4, fma(s.even[0][1], y, odd[1]));
    const double next_y6 = fma(2.0 * s.odd[0][0], next_y3, square[2]);
    const double next_y7 = fma(y0, next_y6, fma(s.even[0][2], y, odd[2]));
    const double g = fma(c.b2, y_k, c.loss * y4), f = fma(1.5 * k_H, u_k, y_k) + cubic;
    Machine::store(s.motion[m], Machine::set(y, v, inverse * y_k, -inverse * g));
    Machine::store(s.even[m], Machine::set(u, next_y4, next_y6, 0.0));
    Machine::store(s.odd[m], Machine::set(next_y3, next_y5, next_y7, 0.0));
    const Quad roots = Machine::set(y, u, next_y3, 0.0);
    Machine::store(s.roots[m], roots);
    Machine::store(s.twice_roots[m], roots + roots);

    const Quad turn = Machine::set(-inverse * w, inverse * w, -inverse, -inverse);
    if constexpr (Quads == 0) {
      Machine::store(s.forced[m], turn * Machine::swapped(forcing, Machine::all(0.0)));
    } else {
      Machine::store(s.factors[k], Machine::set(g, g, f, f));
      const Quad held = Sums::template product<k>(s.factors, s.dx);
      Machine::store(s.forced[m], turn * Machine::swapped(forcing, held));
      Machine::store(s.dx[m], Machine::all(inverse) * Machine::high_less_low(forcing, held));
    }
    if constexpr (Quads > 1) {
      s.y_cos[k] = forced[0];
      s.y_sin[k] = forced[1];
      for (std::size_t j = 0; j < Terms::more; ++j) {
        const Quad moved =
            Sums::template product<k, 0>(s.motion, s.more_q[j]) - Sums::template product<k, 0>(s.factors, s.more_dx[j]);
        alignas(32) double source[4] = {};
        for (std::size_t i = 4 * j; i < 4 * j + 4 && i < s.source_count; ++i)
          source[i % 4] = source_coefficient<k>(s, s.sources[i]);
        Machine::store(s.more_dx[j][m], Machine::all(inverse) * moved);
        Machine::store(s.more_q[j][m],
                       Machine::all(inverse) * (Machine::load(source) - Sums::template product<k, 2>(s.factors, s.more_dx[j])));
      }
    }
  }
};

}  // namespace graze::detail
