// SPDX-License-Identifier: GPL-3.0-or-later
// ContactPieces: a table of Hertz contacts as plain numbers for the lanes (contact_table.hpp makes and owns it, contact_sum.hpp
// evaluates it).
//
// Whole contacts: entry at time t of the forcing period with speed v -> duration d, speed of exit, integral of trace(f_x), and
// the tangent at fixed time. Contacts in which the period ends, after the part q of the contact: angle a = 2 asin(sqrt(q)) and
// v -> depth, speed, integral and tangent at the end of the period. (These are smooth in a, but not in t, at both ends of the
// contact.)
//
// A piece is a rectangle of (t, v) or (a, v) with tensor products of Chebyshev polynomials. A band is the speeds between two
// powers of 2; a grid of cells in each band points to the pieces.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace graze::lanes {

/// Number of polynomials in each variable, and of cells of a band in each.
inline constexpr std::size_t polynomials = 16, time_cells = 32, speed_cells = 8;
inline constexpr std::uint16_t no_piece = 0xffff;

/// Coefficients of four quantities at T_2k(t) T_j(v), and of the same at T_2k+1(t) T_j(v).
struct alignas(64) TermPair {
  double at[8];
};

/// Terms of a piece for four quantities: those of k = 0 (j = 0, 1, ...), then of k = 1, and so on, without the negligible ones.
struct PieceTerms {
  std::uint32_t first = 0;
  std::array<std::uint8_t, polynomials / 2> count{};
};

struct ContactPiece {
  double time = 0.0, per_time = 0.0, speed = 0.0, per_speed = 0.0;  ///< centre, and the inverse of half the width
  PieceTerms values;                                                ///< duration or depth, speed, integral of trace(f_x), none
  PieceTerms tangent;                                               ///< row by row
};

struct ContactPieces {
  double cells_per_time = 0.0;
  std::int64_t lowest_band = 0, bands = 0;  ///< speeds of band k: 2^(lowest_band + k) up to twice that
  const std::uint16_t* whole = nullptr;     ///< cells by band, time, speed: number of the piece of the whole contact
  const std::uint16_t* begun = nullptr;     ///< cells by band, angle, speed: of its part up to the end of the period
  const ContactPiece* pieces = nullptr;
  const TermPair* terms = nullptr;
};

}  // namespace graze::lanes
