// SPDX-License-Identifier: GPL-3.0-or-later
// ContactSeries: the Taylor series of a Hertz contact and its 2x2 tangent in lanes. The equations are those of
// flow/hertz_recurrence.hpp, two orders at once (two_orders.hpp), which suits registers that hold the same number of many
// contacts.
//
// The tangent is carried in Hill's form, which takes two products a column instead of three. With the damping of the contact
// c = 2 b + k_H b_H y^3, the divergence so far D = -integral of c dt, and a column (dx, dv) at fixed time,
//     z = e^(-D/2) dx,   p = e^(-D/2) (dv + (c/2) dx):   dz/ds = y p,   dp/ds = -f z,
//     f = y + 3 beta y x^2 + (3/2) k_H y^2 + (k_H b_H/2) d(y^3)/ds - y c^2/4.
// The determinant of (z, p) is 1.
#pragma once

#include <graze/lib/flow/hertz_step.hpp>
#include <graze/lib/lanes/contact_law.hpp>
#include <graze/lib/lanes/power_series.hpp>
#include <graze/lib/lanes/quads.hpp>
#include <graze/lib/lanes/two_orders.hpp>

#include <array>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

/// Cubic: with beta x^3; else ContactLaw::beta is ignored.
template <class Real, bool Tangent, bool Cubic, std::size_t Order> class ContactSeries {
 public:
  static constexpr std::size_t order = Order;

  ContactSeries(const ContactLaw<Real>& law, const ContactState<Real>& z) : b2_(law.b2), loss_(law.loss), start_(z) {
    const Real y0 = z.y, u0 = y0 * y0, w0 = u0 * u0;
    y_[0] = y0;
    v_[0] = z.v;
    c_[0] = z.c;
    s_[0] = z.s;
    u_[0] = u0;
    y3_[0] = y0 * u0;
    y4_[0] = w0;
    y5_[0] = y0 * w0;
    if constexpr (with_y7) y7_[0] = y3_[0] * w0;
    if constexpr (Tangent) {
      z_0_[0] = z.z_0;
      z_1_[0] = z.z_1;
      p_0_[0] = z.p_0;
      p_1_[0] = z.p_1;
      if constexpr (in_quads<Real>) quads_.columns[0] = {z.p_0, z.p_1, z.z_0, z.z_1};
    }
    const Terms q(law, Cubic);
    next_two<Known::none>(q, 0);
#pragma GCC unroll 1
    for (std::size_t k = 2; k < order; k += 2) next_two<Known::even>(q, k);
  }
  Real depth(const Real& h) const { return sum(y_, h); }
  Real speed(const Real& h) const { return sum(v_, h); }
  Real time(const Real& h) const { return madd(h, without_first(time_, h), start_.time); }
  ContactState<Real> at(const Real& h) const {
    const Real dt = h * without_first(time_, h), pressed = h * without_first(integral_, h);
    ContactState<Real> z{
        sum(y_, h), sum(v_, h), sum(c_, h), sum(s_, h), start_.time + dt, start_.divergence - dot(b2_, dt, loss_, pressed),
        Real(0.0),  Real(0.0),  Real(0.0),  Real(0.0)};
    if constexpr (Tangent) {
      z.z_0 = sum(z_0_, h);
      z.z_1 = sum(z_1_, h);
      z.p_0 = sum(p_0_, h);
      z.p_1 = sum(p_1_, h);
    }
    return z;
  }

  /// Largest coefficients of the last order and of the one before, each relative to 1 + |its quantity|; of the tangent,
  /// relative to 1 + the larger z or p.
  void size(Real& last, Real& before) const {
    const Real of_y = 1.0 / (1.0 + abs(y_[0])), of_v = 1.0 / (1.0 + abs(v_[0]));
    const auto state = [&](std::size_t k) {
      return Real(largest(Real(of_y * abs(y_[k])), Real(of_v * abs(v_[k]))) + largest(abs(c_[k]), abs(s_[k])) + abs(time_[k]));
    };
    last = state(order);
    before = state(order - 1);
    if constexpr (Tangent) {
      const Real of_z = 1.0 / (1.0 + largest(abs(z_0_[0]), abs(z_1_[0]))),
                 of_p = 1.0 / (1.0 + largest(abs(p_0_[0]), abs(p_1_[0])));
      const auto tangent = [&](std::size_t k) {
        return largest(Real(of_z * largest(abs(z_0_[k]), abs(z_1_[k]))), Real(of_p * largest(abs(p_0_[k]), abs(p_1_[k]))));
      };
      last = largest(last, tangent(order));
      before = largest(before, tangent(order - 1));
    }
  }

 private:
  static constexpr bool with_y7 = Tangent || Cubic;
  template <Known Number> static constexpr Known of_seventh = with_y7 ? Number : Known::none;
  static constexpr Known of_tangent = Tangent ? Known::odd : Known::none;  // one more coefficient is known than of the others
  using Terms = ContactTerms<Real>;

  /// Sums of products: of order k with c and s; of order k + 1, without the first and last terms, the others. Of yy and uu one
  /// half.
  struct Products {
    Real yc, ys, yy, yu, uu, yw, y3w;
  };
  /// Of order k.
  struct TangentProducts {
    Real yp_0, yp_1, fz_0, fz_1;
  };

  template <Known Number> [[gnu::always_inline]] void next_two_in_quads(const Terms& q, std::size_t k) {
    const TwoOrders<Quad, Number, 1, false> powers(k, quads_.left, quads_.right);
    const TwoOrders<Pair, Number, 0, true> squares(k, quads_.roots);
    const TwoOrders<Real, of_seventh<Number>, 1, false> seventh(k, y4_.data() + 1, y3_.data() + 1);
    const auto products = [](const auto& of_powers, const auto& of_squares, double y3w) __attribute__((always_inline)) {
      const auto [yc, ys, yw, yu] = numbers(of_powers);
      const auto [yy, uu] = numbers(of_squares);
      return Products{yc, ys, yy, yu, uu, yw, y3w};
    };
    close(k, q, products(powers.first(), squares.first_square(), seventh.first()));
    put_in_quads(k);
    const TwoOrders<Quad, of_tangent, 1, false> tangent(k + 1, quads_.factors, quads_.columns);
    if constexpr (Tangent) close_tangent_in_quads(k, tangent.first());
    close(k + 1, q, products(powers.second(), squares.second_square(), seventh.second()));
    put_in_quads(k + 1);
    if constexpr (Tangent) close_tangent_in_quads(k + 1, tangent.second());
  }
  [[gnu::always_inline]] void close_tangent_in_quads(std::size_t k, const Quad& sums) {
    const auto [yp_0, yp_1, fz_0, fz_1] = numbers(sums);
    close_tangent(k, {yp_0, yp_1, fz_0, fz_1});
    quads_.columns[k + 1] = {p_0_[k + 1], p_1_[k + 1], z_0_[k + 1], z_1_[k + 1]};
  }
  [[gnu::always_inline]] void put_in_quads(std::size_t k) {
    quads_.left[k] = {y_[k + 1], y_[k + 1], y_[k + 1], u_[k + 1]};
    quads_.right[k] = {c_[k], s_[k], y4_[k + 1], y_[k + 1]};
    quads_.roots[k] = {y_[k + 1], u_[k + 1]};
    if constexpr (Tangent) quads_.factors[k] = {y_[k], y_[k], f_[k], f_[k]};
  }

  /// Coefficients k + 1 and k + 2 of everything from those up to k.
  template <Known Number> [[gnu::always_inline]] void next_two(const Terms& q, std::size_t k) {
    if constexpr (in_quads<Real>) return next_two_in_quads<Number>(q, k);
    const Real *const y = y_.data() + 1, *const u = u_.data() + 1, *const w = y4_.data() + 1;
    const TwoOrders<Real, Number, 2, false> forced(k, y, c_.data(), s_.data());
    const TwoOrders<Real, Number, 1, true> fifth(k, y, w), third(k, u, y);
    const TwoOrders<Real, of_seventh<Number>, 1, false> seventh(k, w, y3_.data() + 1);
    close(k, q,
          {forced.first(0), forced.first(1), fifth.first_square(), third.first(), third.first_square(), fifth.first(),
           seventh.first()});
    const TwoOrders<Real, of_tangent, 2, false> yp(k + 1, y_.data(), p_0_.data(), p_1_.data()),
        fz(k + 1, f_.data(), z_0_.data(), z_1_.data());
    if constexpr (Tangent) close_tangent(k, {yp.first(0), yp.first(1), fz.first(0), fz.first(1)});
    close(k + 1, q,
          {forced.second(0), forced.second(1), fifth.second_square(), third.second(), third.second_square(), fifth.second(),
           seventh.second()});
    if constexpr (Tangent) close_tangent(k + 1, {yp.second(0), yp.second(1), fz.second(0), fz.second(1)});
  }

  /// Coefficients k + 1 of all but the tangent, and k of f, from sums of products of order k and of order k + 1 without their
  /// first and last terms.
  [[gnu::always_inline]] void close(std::size_t k, const Terms& q, const Products& sums) {
    const double inverse = inverses[k];
    const Real y0 = y_[0], u0 = u_[0], w0 = y4_[0];
    const Real turn = inverse * q.w, c = -turn * madd(y0, s_[k], sums.ys), s = turn * madd(y0, c_[k], sums.yc);
    const Real y = (0.5 * inverse) * v_[k], u = 2.0 * madd(y0, y, sums.yy), w = 2.0 * madd(u0, u, sums.uu),
               y3 = madd(y0, u, madd(u0, y, sums.yu)), y5 = madd(y0, w, madd(w0, y, sums.yw));
    Real pull = madd(q.pull_y, y_[k], madd(q.pull_y3, y3_[k], q.pull_y4 * y4_[k]));
    if constexpr (Cubic) pull = madd(q.pull_y5, y5_[k], madd(q.pull_y7, y7_[k], pull));
    const Real v = madd(q.drag_y5, y5, madd(q.drag_u, u, madd(q.drive, s, inverse * pull)));
    if constexpr (Tangent) {
      Real f = madd(q.f_y, y_[k], q.f_u * u_[k]), g = madd(q.f_y4, y4_[k], q.f_y7 * y7_[k]);
      if constexpr (Cubic) {
        f = madd(q.f_y3, y3_[k], f);
        g = madd(q.f_y5, y5_[k], g);
      }
      f_[k] = madd(static_cast<double>(k + 1) * q.f_slope, y3, f + g);
    }
    time_[k + 1] = inverse * y_[k];
    integral_[k + 1] = inverse * y4_[k];
    y_[k + 1] = y;
    v_[k + 1] = v;
    c_[k + 1] = c;
    s_[k + 1] = s;
    u_[k + 1] = u;
    y3_[k + 1] = y3;
    y4_[k + 1] = w;
    y5_[k + 1] = y5;
    if constexpr (with_y7) y7_[k + 1] = madd(y3_[0], w, madd(w0, y3, sums.y3w));
  }
  [[gnu::always_inline]] void close_tangent(std::size_t k, const TangentProducts& sums) {
    const double inverse = inverses[k];
    z_0_[k + 1] = inverse * sums.yp_0;
    z_1_[k + 1] = inverse * sums.yp_1;
    p_0_[k + 1] = -inverse * sums.fz_0;
    p_1_[k + 1] = -inverse * sums.fz_1;
  }

  using Coefficients = std::array<Real, order + 1>;
  [[no_unique_address]] ContactQuads<in_quads<Real>, Order> quads_;
  Real b2_, loss_;
  ContactState<Real> start_;
  // Powers of y, the square root of the depth: u = y^2, y3, y4, y5, y7. The time and the integral of y^4 lack their first
  // coefficients.
  Coefficients y_, v_, c_, s_, time_, integral_, u_, y3_, y4_, y5_, y7_, f_, z_0_, z_1_, p_0_, p_1_;
};

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
