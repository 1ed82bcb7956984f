// SPDX-License-Identifier: GPL-3.0-or-later
// SaltationMatrix: the first-order map of a perturbation across one event (Aizerman & Gantmakher 1958; Mueller, Chaos Solitons
// Fractals 5 (1995) 1671; DESIGN section 2).
//
// With guard h(t, x, p) = 0, reset x+ = g(t, x-, p), field f- before and f+ after:
//     S   = D_x g + (f+ - D_x g f- - D_t g) D_x h / c,        c = D_t h + D_x h f-   (the transversality),
//     S_p = D_p g + (f+ - D_x g f- - D_t g) D_p h / c.
// At grazing c -> 0 and S does not exist: `regular` is then false, and S and S_p are NaN.
#pragma once

#include <graze/lib/system/hybrid_system.hpp>

#include <span>

namespace graze {

struct SaltationMatrix {
  bool regular = false;
  double transversality = 0.0;  ///< c, the normal speed of the guard at the event
  Matrix S;                     ///< n x n
  Matrix Sp;                    ///< n x active parameters
};

/// Time, states and fields at an event: the two fields belong to the modes before and after.
struct Crossing {
  double t = 0.0;
  const Vector& x_minus;
  const Vector& x_plus;
  const Vector& f_minus;
  const Vector& f_plus;
};

/// Smallest |transversality| relative to 1 + |f-| at which S is still formed.
inline constexpr double grazing_transversality = 1e-13;

/// The saltation matrix of `event` at a crossing; `active` are the parameters of the columns of S_p (may be empty).
SaltationMatrix saltation(const Event& event, const Crossing& crossing, const Vector& p, std::span<const std::size_t> active);

/// The same, written into `result` (its storage is reused).
void saltation(const Event& event, const Crossing& crossing, const Vector& p, std::span<const std::size_t> active,
               SaltationMatrix& result);

/// The transversality c = D_t h + D_x h f- alone.
double transversality(const Guard& guard, double t, const Vector& x, const Vector& f, const Vector& p);

/// Derivative of the transversality in the direction (dt, dx, dp) with f held fixed: the contribution of the guard's own
/// curvature or motion to the derivatives of dh/dt. Exactly zero for a level guard. Fourth-order differences, accurate to about
/// 1e-11 of the guard's scale; empty dx or dp: zero.
double transversality_change(const Guard& guard, double t, const Vector& x, const Vector& f, const Vector& p, double dt,
                             const Vector& dx = {}, const Vector& dp = {});

/// h and dh/dt of a guard along a mode's field, with their gradients in x and their derivatives in t and one parameter.
struct GuardAndRate {
  double h = 0.0, rate = 0.0;
  Vector h_dx, rate_dx;
  double rate_dt = 0.0, h_dp = 0.0, rate_dp = 0.0;
};
GuardAndRate guard_and_rate(const Guard& guard, const Mode& mode, double t, const Vector& x, const Vector& p,
                            std::size_t parameter);

}  // namespace graze
