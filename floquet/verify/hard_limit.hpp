// SPDX-License-Identifier: GPL-3.0-or-later
// HardLimit: the limit of a Hertz contact F = k_H (x - r)^(3/2) (1 + b_H x') as k_H goes to infinity. Dimensionless.
//
// The duration and the depth of a contact entered with speed v scale as k_H^(-2/5). All other forces are of that order relative
// to the contact force, so every quantity of an orbit has an expansion in powers of epsilon = k_H^(-2/5), and differences from
// the limit fall with the order 2/5 in 1/k_H. In the limit only the contact force acts,
//     v dv = -k_H y^(3/2) (1 + b_H v) dy   ->   w - ln(1 + w) = -u - ln(1 - u),   w = b_H v,  u = e w
// (after Hunt & Crossley, J. Appl. Mech. 42 (1975) 440; exact for every w). The stop is rigid, with a coefficient of
// restitution e that depends only on the impact speed, e = 1 - 2/3 w + ...; for b_H = 0 it is Newton's law with k_r = 1.
//
// The limit is compared in two ways: by the order of the differences, and by Richardson extrapolation in epsilon of the orbits
// at k_H = 1e3, 1e4, ..., whose own error is estimated from its last two columns.
#pragma once

#include <graze/floquet/verify/orbit_verification.hpp>
#include <graze/lib/models/oscillator.hpp>

namespace graze {

/// e(w) of the contact force alone, w = b_H v. @throws std::invalid_argument for w < 0 or not finite.
double limit_restitution(double w);
/// d(u)/d(w) of u = e(w) w: factor by which a difference of impact speeds is multiplied.
double limit_restitution_slope(double w);

/// The oscillator with a rigid stop of restitution e(b_H v); its parameters are the oscillator's own and b_H.
HybridSystem make_hard_limit(const OscillatorKind& kind);

/// Ratio of exit to entry speed for a contact with a soft stop, entered at time t with the given speed; NaN if it does not end
/// within a forcing period.
double contact_restitution(const HybridSystem& system, const Vector& p, double t, double speed, const FlowOptions& options = {});

/// Richardson's extrapolation to epsilon = 0 of values at epsilon = first ratio^j, j = 0, 1, ...
struct Extrapolated {
  Vector value;
  double error = 0.0;  ///< estimate: the larger of the last corrections, by column and by row, of a component
};
Extrapolated extrapolate(const std::vector<Vector>& values, double ratio);

struct HardLimitOptions {
  double softest = 1e3, stiffest = 1e9;  ///< k_H, by decades
  int speeds = 48;                       ///< number of entry speeds at which restitution is computed
  double largest_speed = 0.0;            ///< largest entry speed; 0: twice the orbit's largest, at least 2
  std::function<bool()> cancelled = {};
};

struct StiffnessStep {
  double k_H = 0.0;
  PeriodicOrbit orbit = {};
  double state_difference = 0.0;       ///< |x - x_limit| / (1 + |x_limit|)
  double multiplier_difference = 0.0;  ///< max|mu - mu_limit| / (1 + |mu_1|), pairwise by modulus
  /// log10 of the ratio of the previous (one decade softer) state difference to this one: 2/5 in the limit; NaN for the first.
  double order = 0.0;
};

struct RestitutionPoint {
  double speed = 0.0;
  double computed = 0.0;      ///< at the problem's own k_H; NaN if the contact does not end
  double stiff = 0.0;         ///< at HardLimitOptions::stiffest
  double closed_form = 0.0;   ///< limit_restitution(b_H speed)
  double extrapolated = 0.0;  ///< from all k_H
  double error = 0.0;         ///< of the extrapolation
};

enum class HardLimitStop {
  failed,      ///< not run
  done,        ///< orbit and restitution were computed
  lost_stiff,  ///< the orbit could not be followed to the stiffest contact
  lost_limit,  ///< the limit has no such orbit
  lost_soft,   ///< the orbit exists for fewer than four decades down from the stiffest contact
  interrupted
};
std::string_view hard_limit_stop_text(HardLimitStop reason);

struct HardLimit {
  HardLimitStop stop = HardLimitStop::failed;
  PeriodicOrbit limit = {};                        ///< orbit of make_hard_limit
  double newton_restitution = 0.0;                 ///< e of its impacts; NaN if they differ
  std::vector<StiffnessStep> steps = {};           ///< softest first
  double entry_time = 0.0;                         ///< start of the contacts of `restitution`: the orbit's first impact
  std::vector<RestitutionPoint> restitution = {};  ///< empty if b_H = 0
  std::vector<OrbitCheck> checks = {};             ///< "hard limit: ..."
};

/// The hard limit of an `orbit` with Hertz contact at parameters p (of make_oscillator(kind, "hertz")). The orbit may also be
/// one of Newton's law with k_r = 1 at the same parameters; it is then taken as the limit itself.
/// @throws std::invalid_argument for options out of range.
HardLimit hard_limit(const OscillatorKind& kind, const Vector& p, const PeriodicOrbit& orbit,
                     const HardLimitOptions& options = {});

}  // namespace graze
