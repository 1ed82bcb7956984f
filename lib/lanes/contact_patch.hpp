// SPDX-License-Identifier: GPL-3.0-or-later
// ContactPatch: the pieces of a ContactTable on one initial rectangle, a quarter of a period by an octave of speeds. Patches
// are independent of each other, so that they can be made in parallel.
#pragma once

#include <graze/lib/lanes/contact_table.hpp>

#include <array>

namespace graze {

/// Evaluates a piece at (x, y) in [-1, 1]^2. `ended` stays false; the duration and the depth are both set.
lanes::ContactExit evaluate(const lanes::ContactPiece& piece, const lanes::TermPair* terms, double x, double y);

struct ContactPatch {
  static constexpr std::size_t columns = lanes::time_cells / 4, rows = lanes::speed_cells;

  std::vector<lanes::ContactPiece> pieces;
  std::vector<lanes::TermPair> terms;
  std::array<std::uint16_t, columns * rows> cells;  ///< by time, speed: number of the piece, or no_piece
  std::size_t contacts = 0;                         ///< number of contacts carried in steps to make it
  double value_error = 0.0, tangent_error = 0.0;    ///< as in ContactTableReport
};

/// Position of a patch: its first column of cells, and its octave of speeds, which begins at 2^band.
struct PatchPlace {
  std::size_t column = 0;
  std::int64_t band = 0;
};

/// The patch of whole contacts or, given their table `whole`, of their parts up to the end of the period.
ContactPatch contact_patch(const lanes::Coefficients& oscillator, LaneWidth width, const PatchPlace& place,
                           const ContactTable* whole);

}  // namespace graze
