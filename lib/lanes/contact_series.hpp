// SPDX-License-Identifier: GPL-3.0-or-later
// ContactSeries: the Taylor series of a Hertz contact and its 2x2 tangent in lanes: the equations of detail/hertz_series.hpp, one
// loop an order for all products, which suits registers that hold the same number of many contacts.
#pragma once

#include <graze/lib/detail/hertz_step.hpp>
#include <graze/lib/lanes/real.hpp>

#include <array>
#include <utility>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

/// A contact at an instant, as in HertzState.
template <class Real> struct ContactState { Real y, v, c, s, time, divergence, dx_0, dx_1, q_0, q_1; };

template <class Real> struct ContactLaw {
  Real b2, w, xi, r, k_H, loss;  ///< 2 b, eta, xi, r, k_H, k_H b_H
  Real beta;
};

/// Cubic: with beta x^3; without, ContactLaw::beta does not count.
template <class Real, bool Tangent, bool Cubic> class ContactSeries {
 public:
  static constexpr std::size_t order = detail::hertz_order;

  ContactSeries(const ContactLaw<Real>& law, const ContactState<Real>& z) {
    const Real y0 = z.y, u0 = y0 * y0, w0 = u0 * u0;
    y_[0] = y0;
    v_[0] = z.v;
    c_[0] = z.c;
    s_[0] = z.s;
    time_[0] = z.time;
    divergence_[0] = z.divergence;
    u_[0] = u0;
    y3_[0] = y0 * u0;
    y4_[0] = w0;
    y5_[0] = y0 * w0;
    if constexpr (Cubic) y7_[0] = y3_[0] * w0;
    if constexpr (Tangent) {
      dx_[0] = z.dx_0;
      dx_1_[0] = z.dx_1;
      q_[0] = z.q_0;
      q_1_[0] = z.q_1;
    }
    expand(law, std::make_index_sequence<order>());
  }
  Real depth(const Real& h) const { return sum(y_, h); }
  Real speed(const Real& h) const { return sum(v_, h); }
  Real time(const Real& h) const { return sum(time_, h); }
  ContactState<Real> at(const Real& h) const {
    ContactState<Real> z{sum(y_, h),          sum(v_, h), sum(c_, h), sum(s_, h), sum(time_, h),
                         sum(divergence_, h), Real(0.0),  Real(0.0),  Real(0.0),  Real(0.0)};
    if constexpr (Tangent) {
      z.dx_0 = sum(dx_, h);
      z.dx_1 = sum(dx_1_, h);
      z.q_0 = sum(q_, h);
      z.q_1 = sum(q_1_, h);
    }
    return z;
  }

  /// Largest coefficient of order k, each relative to 1 + |what it belongs to|.
  Real size(std::size_t k) const {
    Real all = largest(relative(y_, k), relative(v_, k)) + largest(relative(c_, k), relative(s_, k)) + abs(time_[k]);
    if constexpr (Tangent)
      all = largest(all, largest(largest(relative(dx_, k), relative(dx_1_, k)), largest(relative(q_, k), relative(q_1_, k))));
    return all;
  }

 private:
  template <std::size_t... k> [[gnu::always_inline]] void expand(const ContactLaw<Real>& law, std::index_sequence<k...>) {
    (next<k>(law), ...);
  }

  /// Sums of products of two series.
  struct Products {
    Real yc = Real(0.0), ys = yc, yy = yc, yu = yc, uu = yc, yw = yc, y3w = yc;
    Real yq_0 = yc, yq_1 = yc, g_0 = yc, g_1 = yc, f_0 = yc, f_1 = yc;

    /// Coefficient i with itself (of yc, ys and the tangent's with the one before).
    [[gnu::always_inline]] void add_middle(const ContactSeries& z, std::size_t i) {
      const Real y = z.y_[i], u = z.u_[i];
      yc = y * z.c_[i - 1];
      ys = y * z.s_[i - 1];
      yy = y * y;
      yu = y * u;
      uu = u * u;
      yw = y * z.y4_[i];
      if constexpr (Cubic) y3w = z.y3_[i] * z.y4_[i];
      if constexpr (Tangent) {
        yq_0 = y * z.q_[i - 1];
        yq_1 = y * z.q_1_[i - 1];
        g_0 = z.g_[i] * z.dx_[i - 1];
        g_1 = z.g_[i] * z.dx_1_[i - 1];
        f_0 = z.f_[i] * z.dx_[i - 1];
        f_1 = z.f_[i] * z.dx_1_[i - 1];
      }
    }
    /// Coefficients i and j of one series with j and i of the other (likewise).
    [[gnu::always_inline]] void add_pair(const ContactSeries& z, std::size_t i, std::size_t j) {
      const Real y = z.y_[i], y_j = z.y_[j], u = z.u_[i], u_j = z.u_[j], twice_y = y + y, twice_u = u + u;
      yc = madd(y_j, z.c_[i - 1], madd(y, z.c_[j - 1], yc));
      ys = madd(y_j, z.s_[i - 1], madd(y, z.s_[j - 1], ys));
      yy = madd(twice_y, y_j, yy);
      yu = madd(y_j, u, madd(y, u_j, yu));
      uu = madd(twice_u, u_j, uu);
      yw = madd(y_j, z.y4_[i], madd(y, z.y4_[j], yw));
      if constexpr (Cubic) y3w = madd(z.y3_[j], z.y4_[i], madd(z.y3_[i], z.y4_[j], y3w));
      if constexpr (Tangent) {
        yq_0 = madd(y_j, z.q_[i - 1], madd(y, z.q_[j - 1], yq_0));
        yq_1 = madd(y_j, z.q_1_[i - 1], madd(y, z.q_1_[j - 1], yq_1));
      }
    }
    /// The products with dx. (Apart from the others: for all of it together there are too few registers.)
    [[gnu::always_inline]] void add_pair_of_tangent(const ContactSeries& z, std::size_t i, std::size_t j) {
      const Real dx_0 = z.dx_[j - 1], dx_1 = z.dx_1_[j - 1], dx_0_j = z.dx_[i - 1], dx_1_j = z.dx_1_[i - 1];
      const Real g = z.g_[i], g_j = z.g_[j], f = z.f_[i], f_j = z.f_[j];
      g_0 = madd(g_j, dx_0_j, madd(g, dx_0, g_0));
      g_1 = madd(g_j, dx_1_j, madd(g, dx_1, g_1));
      f_0 = madd(f_j, dx_0_j, madd(f, dx_0, f_0));
      f_1 = madd(f_j, dx_1_j, madd(f, dx_1, f_1));
    }
  };

  /// Coefficients k + 1 of everything from those up to k.
  template <std::size_t k> [[gnu::always_inline]] void next(const ContactLaw<Real>& law) {
    constexpr double inverse = 1.0 / static_cast<double>(k + 1);
    const Real y0 = y_[0], u0 = u_[0], w0 = y4_[0];
    g_[k] = law.b2 * y_[k] + law.loss * y4_[k];
    if constexpr (Tangent) {
      f_[k] = y_[k] + 1.5 * law.k_H * u_[k];
      if constexpr (Cubic)
        f_[k] = f_[k] + 3.0 * law.beta * (law.r * madd(law.r, y_[k], Real(2.0 * y3_[k])) + y5_[k]);  // of y x^2, x = r + y^2
    }
    // Products of order k; and of order k + 1 without their first and last terms. From the middle on: what was computed last
    // comes last, and need not be waited for.
    Products sums;
    if constexpr (k % 2 == 1) sums.add_middle(*this, (k + 1) / 2);
#pragma GCC unroll 1
    for (std::size_t i = k / 2, j = k + 1 - i; i > 0; --i, ++j) sums.add_pair(*this, i, j);
    if constexpr (Tangent) {
#pragma GCC unroll 1
      for (std::size_t i = k / 2, j = k + 1 - i; i > 0; --i, ++j) sums.add_pair_of_tangent(*this, i, j);
    }
    sums.yc = madd(y0, c_[k], sums.yc);
    sums.ys = madd(y0, s_[k], sums.ys);
    if constexpr (Tangent) {
      sums.yq_0 = madd(y0, q_[k], sums.yq_0);
      sums.yq_1 = madd(y0, q_1_[k], sums.yq_1);
      sums.g_0 = madd(g_[0], dx_[k], sums.g_0);
      sums.g_1 = madd(g_[0], dx_1_[k], sums.g_1);
      sums.f_0 = madd(f_[0], dx_[k], sums.f_0);
      sums.f_1 = madd(f_[0], dx_1_[k], sums.f_1);
    }
    const Real y = 0.5 * inverse * v_[k], u = sums.yy + 2.0 * y0 * y, w = sums.uu + 2.0 * u0 * u,
               y5 = sums.yw + (y0 * w + w0 * y);
    y_[k + 1] = y;
    u_[k + 1] = u;
    y3_[k + 1] = sums.yu + (y0 * u + u0 * y);
    y4_[k + 1] = w;
    y5_[k + 1] = y5;
    if constexpr (Cubic) y7_[k + 1] = sums.y3w + (y3_[0] * w + w0 * y3_[k + 1]);
    Real pull = law.r * y_[k] + law.k_H * y4_[k] + y3_[k];
    if constexpr (Cubic)  // y x^3
      pull = pull + law.beta * (law.r * madd(law.r, madd(law.r, y_[k], Real(3.0 * y3_[k])), Real(3.0 * y5_[k])) + y7_[k]);
    v_[k + 1] = inverse * (law.xi * sums.yc - pull) - (law.b2 * u + (0.4 * law.loss) * y5);
    c_[k + 1] = -inverse * law.w * sums.ys;
    s_[k + 1] = inverse * law.w * sums.yc;
    time_[k + 1] = inverse * y_[k];
    divergence_[k + 1] = -inverse * g_[k];
    if constexpr (Tangent) {
      dx_[k + 1] = inverse * (sums.yq_0 - sums.g_0);
      dx_1_[k + 1] = inverse * (sums.yq_1 - sums.g_1);
      q_[k + 1] = -inverse * sums.f_0;
      q_1_[k + 1] = -inverse * sums.f_1;
    }
  }

  using Coefficients = std::array<Real, order + 1>;
  /// Even and odd powers apart: half as long a chain.
  static Real sum(const Coefficients& a, const Real& h) {
    const Real square = h * h;
    Real even = a[order], odd = a[order - 1];
    for (std::size_t k = order; k > 2; k -= 2) {
      even = madd(square, even, a[k - 2]);
      odd = madd(square, odd, a[k - 3]);
    }
    return madd(h, odd, madd(square, even, a[0]));
  }
  static Real relative(const Coefficients& a, std::size_t k) { return abs(a[k]) / (1.0 + abs(a[0])); }

  // Powers of the depth's root: u = y^2, y3, y4, y5, y7; what multiplies dx in dq/ds and in d(dx)/ds: -f, -g.
  Coefficients y_, v_, c_, s_, time_, divergence_, u_, y3_, y4_, y5_, y7_, f_, g_, dx_, dx_1_, q_, q_1_;
};

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
