// SPDX-License-Identifier: GPL-3.0-or-later
// MonodromyMatrix and FloquetMultipliers of a periodic orbit.
//
// Convention. A forced orbit is described on the stroboscopic section (fixed forcing phase): its n x n monodromy matrix has no
// trivial multiplier. An autonomous orbit is described with full saltation at a fixed time: it has one trivial multiplier +1.
// The convention is declared with the matrix and never inferred from numbers.
//
// The multipliers are eigenvalues of a product of many factors. They are computed from the factors (orthogonal sweeps: Q R of
// factor times Q, repeated until the diagonal blocks have separated), so that a small multiplier beside a large one keeps its
// relative accuracy. A factor of deficient rank (k_r = 0, sticking) gives multipliers that are exactly zero.
#pragma once

#include <graze/floquet/orbit/kept_state.hpp>
#include <graze/lib/numerics/vector.hpp>

#include <array>
#include <complex>
#include <vector>

namespace graze {

enum class Section { stroboscopic, autonomous };

struct MonodromyMatrix {
  Section section = Section::stroboscopic;
  std::vector<Matrix> factors;    ///< M = factors.back() ... factors.front()
  Vector trivial_direction = {};  ///< autonomous: the field at the start, which M carries into itself
  /// ln|det| of each factor by Liouville's identity, NaN where this gives nothing; may be empty. Used if the determinant is
  /// lost to rounding in a factor's entries (strong damping), so that a small multiplier is not taken for zero.
  std::vector<double> log_dets = {};
  int lost = 0;  ///< multipliers that are exactly zero (Transition::lost); from the entries of M they follow up to rounding
  Matrix product() const;
};

/// Two multipliers that meet on the unit circle move by the square root of the rounding error.
inline constexpr double on_unit_circle = 1e-7;

struct FloquetMultipliers {
  Section section = Section::stroboscopic;
  int trivial = 0;  ///< trivial multipliers (+1) in `values`, at its end: along an autonomous orbit, of held places
  std::vector<std::complex<double>> values;  ///< by decreasing modulus; conjugates adjacent, positive imaginary part first
  std::vector<double> exponents;             ///< ln|mu| / duration, -infinity for a zero multiplier
  bool valid = false;                        ///< false: not computed, or not finite (grazing)

  /// Number of nontrivial multipliers outside the unit circle by more than rounding.
  int unstable() const;
  bool stable() const { return valid && unstable() == 0; }
  /// All on the unit circle.
  bool neutral() const;
};

/// From values in this order, of an orbit of the given duration (dimensionless time): with exponents, valid if they are finite.
FloquetMultipliers multipliers_of_values(std::vector<std::complex<double>> values, double duration);

/// Multipliers of an orbit of the given duration (dimensionless time).
FloquetMultipliers multipliers(const MonodromyMatrix& whole, double duration);

/// Eigenvalues of a product of square matrices, computed from its factors, by decreasing modulus; `log_dets` and `lost` as in
/// MonodromyMatrix.
std::vector<std::complex<double>> product_eigenvalues(const std::vector<Matrix>& factors,
                                                      const std::vector<double>& log_dets = {}, int lost = 0);

/// Both eigenvalues of a 2 x 2 matrix with half of this trace and this determinant, by decreasing modulus, the conjugate with
/// positive imaginary part first. The smaller one has the relative accuracy of the determinant.
std::array<std::complex<double>, 2> eigenvalue_pair(double half_trace, double det);

/// The states that keep their values while other ones are held: their row of each partial product is that of the identity. A map
/// of full rank holds nothing.
std::vector<KeptState> kept_states(const MonodromyMatrix& monodromy);

}  // namespace graze
