// SPDX-License-Identifier: GPL-3.0-or-later
// ContactSeries: the Taylor series of a Hertz contact and its 2x2 tangent in lanes: the equations of detail/hertz_series.hpp, one
// loop an order for all products, which suits registers that hold the same number of many contacts.
#pragma once

#include <graze/lib/detail/hertz_step.hpp>
#include <graze/lib/lanes/real.hpp>

#include <array>
#include <utility>

namespace graze::lanes {

/// A contact at an instant, as in HertzState.
template <class Real> struct ContactState { Real y, v, c, s, time, divergence, dx_0, dx_1, q_0, q_1; };

template <class Real> struct ContactLaw {
  Real b2, w, xi, r, k_H, loss;  ///< 2 b, eta, xi, r, k_H, k_H b_H
};

template <class Real, bool Tangent> class ContactSeries {
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

  /// Coefficients k + 1 of everything from those up to k.
  template <std::size_t k> [[gnu::always_inline]] void next(const ContactLaw<Real>& law) {
    constexpr double inverse = 1.0 / static_cast<double>(k + 1);
    const Real y0 = y_[0], u0 = u_[0], w0 = y4_[0];
    g_[k] = law.b2 * y_[k] + law.loss * y4_[k];
    if constexpr (Tangent) f_[k] = y_[k] + 1.5 * law.k_H * u_[k];
    // Products of order k; and of order k + 1 without their first and last terms.
    Real yc = y0 * c_[k], ys = y0 * s_[k], yy = Real(0.0), yu = yy, uu = yy, yw = yy;
    Real yq_0 = yy, yq_1 = yy, g_0 = yy, g_1 = yy, f_0 = yy, f_1 = yy;
    if constexpr (Tangent) {
      yq_0 = y0 * q_[k];
      yq_1 = y0 * q_1_[k];
      g_0 = g_[0] * dx_[k];
      g_1 = g_[0] * dx_1_[k];
      f_0 = f_[0] * dx_[k];
      f_1 = f_[0] * dx_1_[k];
    }
#pragma GCC unroll 1
    for (std::size_t i = 1, j = k; i <= k; ++i, --j) {
      const Real y = y_[i], u = u_[i];
      yc = yc + y * c_[j - 1];
      ys = ys + y * s_[j - 1];
      yy = yy + y * y_[j];
      yu = yu + y * u_[j];
      uu = uu + u * u_[j];
      yw = yw + y * y4_[j];
      if constexpr (Tangent) {
        const Real dx_0 = dx_[j - 1], dx_1 = dx_1_[j - 1], g = g_[i], f = f_[i];
        yq_0 = yq_0 + y * q_[j - 1];
        yq_1 = yq_1 + y * q_1_[j - 1];
        g_0 = g_0 + g * dx_0;
        g_1 = g_1 + g * dx_1;
        f_0 = f_0 + f * dx_0;
        f_1 = f_1 + f * dx_1;
      }
    }
    const Real y = 0.5 * inverse * v_[k], u = yy + 2.0 * y0 * y, w = uu + 2.0 * u0 * u, y5 = yw + (y0 * w + w0 * y);
    y_[k + 1] = y;
    u_[k + 1] = u;
    y3_[k + 1] = yu + (y0 * u + u0 * y);
    y4_[k + 1] = w;
    y5_[k + 1] = y5;
    v_[k + 1] = inverse * (law.xi * yc - (law.r * y_[k] + law.k_H * y4_[k] + y3_[k])) - (law.b2 * u + (0.4 * law.loss) * y5);
    c_[k + 1] = -inverse * law.w * ys;
    s_[k + 1] = inverse * law.w * yc;
    time_[k + 1] = inverse * y_[k];
    divergence_[k + 1] = -inverse * g_[k];
    if constexpr (Tangent) {
      dx_[k + 1] = inverse * (yq_0 - g_0);
      dx_1_[k + 1] = inverse * (yq_1 - g_1);
      q_[k + 1] = -inverse * f_0;
      q_1_[k + 1] = -inverse * f_1;
    }
  }

  using Coefficients = std::array<Real, order + 1>;
  /// Even and odd powers apart: half as long a chain.
  static Real sum(const Coefficients& a, const Real& h) {
    const Real square = h * h;
    Real even = a[order], odd = a[order - 1];
    for (std::size_t k = order; k > 2; k -= 2) {
      even = a[k - 2] + square * even;
      odd = a[k - 3] + square * odd;
    }
    return (a[0] + square * even) + h * odd;
  }
  static Real relative(const Coefficients& a, std::size_t k) { return abs(a[k]) / (1.0 + abs(a[0])); }

  // Powers of the depth's root: u = y^2, y3, y4, y5; what multiplies dx in dq/ds and in d(dx)/ds: -f, -g.
  Coefficients y_, v_, c_, s_, time_, divergence_, u_, y3_, y4_, y5_, f_, g_, dx_, dx_1_, q_, q_1_;
};

}  // namespace graze::lanes
