// SPDX-License-Identifier: GPL-3.0-or-later
// ContactPatch: the pieces of a ContactTable on one first rectangle, a quarter of a period by an octave of speeds. Patches do not
// know of each other, so that they can be made at the same time.
#pragma once

#include <graze/lib/lanes/contact_table.hpp>

#include <array>

namespace graze {

/// What a piece says at (x, y) of [-1, 1]^2; `ended` is left false, and both the duration and the depth are filled in.
lanes::ContactExit evaluate(const lanes::ContactPiece& piece, const lanes::TermPair* terms, double x, double y);

struct ContactPatch {
  static constexpr std::size_t columns = lanes::time_cells / 4, rows = lanes::speed_cells;

  std::vector<lanes::ContactPiece> pieces;
  std::vector<lanes::TermPair> terms;
  std::array<std::uint16_t, columns * rows> cells;  ///< by time, speed: number of the piece, or no_piece
  std::size_t contacts = 0;                         ///< carried in steps for it
  double value_error = 0.0, tangent_error = 0.0;    ///< as ContactTableReport
};

/// Where a patch lies: its first column of cells, and its octave of speeds, of which 2^band is the lowest.
struct PatchPlace {
  std::size_t column = 0;
  std::int64_t band = 0;
};

/// Of whole contacts; with a table of these, of their parts up to the end of the period.
ContactPatch contact_patch(const lanes::Coefficients& oscillator, LaneWidth width, const PatchPlace& place,
                           const ContactTable* whole);

}  // namespace graze
