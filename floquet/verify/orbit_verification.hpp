// SPDX-License-Identifier: GPL-3.0-or-later
// VerifiedOrbit: the multipliers and exponents of an orbit computed in independent ways, and their disagreement. All numbers
// are dimensionless.
//
//     residual                mismatch of the shooting stretches / (1 + |x|)
//     Liouville               |ln|det M| - Liouville's identity|
//     finite differences      max|M - M_fd| / (1 + max|M|), stretch by stretch
//     GSL: motion             the orbit's nodes carried by the general integrator: mismatch / (1 + |x|)
//     GSL: matrix             max|M - M_gsl| / (1 + max|M|)
//     GSL: Liouville          as above, of M_gsl
//     multipliers: differences, multipliers: GSL      max|mu - mu'| / (1 + |mu_1|), pairwise by modulus
//     exponents               max|lambda_i - ln|mu_i| / (n T)|, lambda by time average along the motion
//
// Multipliers: factors with relative error b give M to E with |E| <= b S, S = sum over k of |F_N ... F_(k+1)| (1 + |F_k|)
// |F_(k-1) ... F_1|. The eigenvalues then move by at most kappa |E| (Bauer & Fike, Numer. Math. 2 (1960) 137; kappa: condition
// number of the eigenvectors V of M) and by at most (2 |M| + |E|)^(1 - 1/n) |E|^(1/n) (Elsner, Linear Algebra Appl. 71 (1985)
// 77); the smaller bound is used.
//
// Exponents: M^k = V D^k V^-1. After k turns the length of an aligned vector is therefore within a factor kappa^2 of |mu|^k,
// and that of an i-dimensional volume within kappa^(2 i). After the time N T the averages are within
// 2 (2 n - 3) ln kappa / (N T) of the exponents (n = 2: 2 ln kappa / (N T)), plus rounding, 1e-10. The average of an autonomous
// orbit begins at a return, and kappa is that of M there. The check does not apply to unstable orbits (rounding makes the motion
// leave them), zero multipliers and a defective M.
#pragma once

#include <graze/floquet/exponents/lyapunov.hpp>
#include <graze/floquet/orbit/periodic_orbit.hpp>

#include <string>

namespace graze {

/// Bounds above which a check of an orbit counts as failed.
namespace bound {
inline constexpr double residual = 1e-12;          ///< relative to 1 + |x|
inline constexpr double liouville = 1e-10;         ///< of ln|det M|
inline constexpr double finite_difference = 1e-8;  ///< relative to 1 + |M|; or its own error estimate if that is larger
inline constexpr double flow = 1e-11;              ///< two integrators that each keep 1e-13 a step, over a forcing period
inline constexpr double exponent = 1e-10;          ///< rounding of a time average
}  // namespace bound

double finite_difference_bound(const FiniteDifferenceCheck& check);

/// One comparison and its bound.
struct OrbitCheck {
  std::string name;
  double disagreement = -1.0;  ///< negative: not applicable
  double limit = 0.0;
  std::string reason = {};  ///< why it is not applicable
  bool applicable() const { return !(disagreement < 0.0); }
  bool passes() const { return disagreement <= limit || !applicable(); }
  /// Disagreement in units of its bound; 0 if not applicable.
  double ratio() const { return applicable() ? disagreement / limit : 0.0; }
};

struct VerificationOptions {
  std::int64_t average_periods = 2000;   ///< periods or returns of the time average, rounded up to whole turns; 0: none
  std::int64_t aligning = 200;           ///< periods or returns before it, for the tangent vectors to align
  std::function<bool()> cancelled = {};  ///< called once per period or return of the average
};

struct VerifiedOrbit {
  PeriodicOrbit orbit;
  PeriodicOrbit general = {};           ///< the same nodes carried by the general integrator
  FloquetMultipliers differences = {};  ///< of the monodromy matrix by finite differences
  LyapunovSpectrum average = {};        ///< not_run if the check of the exponents does not apply
  double eigenvector_condition = 0.0;   ///< kappa, infinite for a defective M
  std::vector<OrbitCheck> checks = {};
  bool agrees() const;
};

/// Why Liouville's identity does not apply to an orbit without this check, in words.
std::string liouville_obstacle(const PeriodicOrbit& orbit);
/// Why finite differences do not apply, in words.
inline constexpr const char* difference_obstacle = "every useful step changes the sequence of events";

/// The checks that apply to `orbit`. Its multipliers and monodromy matrix are taken as given.
/// @throws std::invalid_argument for an orbit without nodes, or negative counts in the options.
VerifiedOrbit verify_orbit(const HybridSystem& system, const PeriodicOrbit& orbit, const VerificationOptions& options = {});

}  // namespace graze
