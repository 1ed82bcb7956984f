// SPDX-License-Identifier: GPL-3.0-or-later
// Symmetry: x -> S x, t -> t + s T, under which a system is invariant:
//     S f_m(t, x) = f_m'(t + s T, S x), and the same for guards and resets.
// It maps motions to motions: the image of an orbit is another orbit or the same one. Two equal barriers opposite each other
// have S = -1, s = 1/2; two equal masses under the same force have a permutation, s = 0. Without forcing s is 0.
#pragma once

#include <graze/lib/system/hybrid_system.hpp>

#include <string>
#include <vector>

namespace graze {

struct Symmetry {
  Matrix matrix;       ///< S: n x n, orthogonal
  double shift = 0.0;  ///< s, in forcing periods
};

/// The symmetries of a system at p whose matrix is a signed permutation and whose shift is 0 or 1/2, without the identity.
/// Sections that are only counted need not be symmetric. The symmetries are found by comparing the functions at many points, to
/// rounding. In a system whose second half of the states are the rates of the first (mechanics), both halves are permuted alike,
/// up to 4 coordinates. Other systems are searched up to 5 states; larger ones only for S = -1.
std::vector<Symmetry> symmetries(const HybridSystem& system, const Vector& p);

/// The same for the field of some mode alone: the possible symmetries of motions that meet no guard, also before a single
/// barrier.
std::vector<Symmetry> flight_symmetries(const HybridSystem& system, const Vector& p);

/// "(x, v)(t) -> (-x, -v)(t + T/2)".
std::string symmetry_text(const HybridSystem& system, const Symmetry& symmetry);

}  // namespace graze
