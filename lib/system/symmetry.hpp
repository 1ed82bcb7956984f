// SPDX-License-Identifier: GPL-3.0-or-later
// Symmetry: x -> S x, t -> t + s T, under which a forced system stays as it is:
//     S f_m(t, x) = f_m'(t + s T, S x), and the same for guards and resets.
// It takes motions to motions, so that an orbit has an image, which is another orbit or the same. Two equal barriers opposite
// each other have S = -1, s = 1/2; two equal masses under the same force have a permutation, s = 0.
#pragma once

#include <graze/lib/system/hybrid_system.hpp>

#include <string>
#include <vector>

namespace graze {

struct Symmetry {
  Matrix matrix;       ///< S: n x n, orthogonal
  double shift = 0.0;  ///< s, in forcing periods
};

/// The symmetries of a forced system at p whose matrix is a signed permutation and whose shift is 0 or 1/2, without the identity.
/// They are found from the functions, which are compared at many points, to rounding. Of a system with positions and then
/// velocities (as mechanics has) both are permuted alike; other systems are searched up to 5 states, beyond that for S = -1 only.
/// Empty for an autonomous system.
std::vector<Symmetry> symmetries(const HybridSystem& system, const Vector& p);

/// The same of some mode's field alone: the symmetries that motions which meet no guard may have, before one barrier too.
std::vector<Symmetry> flight_symmetries(const HybridSystem& system, const Vector& p);

/// "(x, v)(t) -> (-x, -v)(t + T/2)".
std::string symmetry_text(const HybridSystem& system, const Symmetry& symmetry);

}  // namespace graze
