// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/lanes/contact_patch.hpp>
#include <graze/lib/lanes/contact_sum.hpp>
#include <graze/lib/lanes/contact_table.hpp>
#include <graze/lib/lanes/oscillator.hpp>
#include <graze/lib/numerics/parallel.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace graze {

using lanes::time_cells;

bool ContactTable::applies(const HybridSystem& system, const Vector& p) {
  const auto oscillator = lanes::lane_oscillator(system, p);
  return oscillator && oscillator->tabulated();
}

ContactTable::ContactTable(const HybridSystem& system, const Vector& p, const SpeedRange& speeds, LaneWidth width) {
  check_parameters(system.parameters, p);
  const auto oscillator = lanes::lane_oscillator(system, p);
  if (!oscillator || !oscillator->tabulated())
    throw std::invalid_argument(
        fmt::format("{} at these parameters is not a linear oscillator with a Hertz stop; a table of its contacts cannot be made",
                    system.name));
  constexpr int widest = 20;
  if (!(speeds.lowest >= std::ldexp(1.0, -widest) && speeds.highest >= speeds.lowest &&
        speeds.highest <= std::ldexp(1.0, widest)))
    throw std::invalid_argument(fmt::format("speeds of entry from {} to {} were given; from 2^-{} to 2^{} are allowed",
                                            speeds.lowest, speeds.highest, widest, widest));
  oscillator_ = oscillator->coefficients;
  period_ = oscillator_[lanes::period];
  lowest_band_ = lanes::band_of<double>(speeds.lowest);
  bands_ = lanes::band_of<double>(speeds.highest) - lowest_band_ + 1;
  tabulate(whole_, nullptr, width);
  tabulate(begun_, this, width);
  terms_.shrink_to_fit();
  report_.pieces = pieces_.size();
  report_.bytes = terms_.size() * sizeof(lanes::TermPair) + pieces_.size() * sizeof(lanes::ContactPiece) + 4 * whole_.size();
  const auto covered = [](const std::vector<std::uint16_t>& cells) {
    return 1.0 - static_cast<double>(std::count(cells.begin(), cells.end(), lanes::no_piece)) / static_cast<double>(cells.size());
  };
  report_.covered = covered(whole_);
  report_.covered_begun = covered(begun_);
}

void ContactTable::tabulate(std::vector<std::uint16_t>& cells, const ContactTable* whole, LaneWidth width) {
  constexpr std::size_t patches_of_band = time_cells / ContactPatch::columns;
  std::vector<ContactPatch> patches(static_cast<std::size_t>(bands_) * patches_of_band);
  in_parallel(patches.size(), [&](std::size_t i) {
    const auto band = lowest_band_ + static_cast<std::int64_t>(i / patches_of_band);
    patches[i] = contact_patch(oscillator_, width, {i % patches_of_band * ContactPatch::columns, band}, whole);
  });
  for (const ContactPatch& patch : patches) {
    report_.contacts += patch.contacts;
    const std::size_t first = pieces_.size();
    const bool too_many = first + patch.pieces.size() > lanes::no_piece;
    for (const std::uint16_t number : patch.cells)
      cells.push_back(too_many || number == lanes::no_piece ? lanes::no_piece : static_cast<std::uint16_t>(first + number));
    if (too_many) continue;
    const auto first_term = static_cast<std::uint32_t>(terms_.size());
    for (lanes::ContactPiece piece : patch.pieces) {
      piece.values.first += first_term;
      piece.tangent.first += first_term;
      pieces_.push_back(piece);
    }
    terms_.insert(terms_.end(), patch.terms.begin(), patch.terms.end());
    report_.value_error = std::max(report_.value_error, patch.value_error);
    report_.tangent_error = std::max(report_.tangent_error, patch.tangent_error);
  }
}

lanes::ContactPieces ContactTable::pieces() const {
  return {time_cells / period_, lowest_band_, bands_, whole_.data(), begun_.data(), pieces_.data(), terms_.data()};
}

std::optional<lanes::ContactExit> ContactTable::at(double t, double v) const {
  const lanes::ContactPiece* piece = lanes::find_piece<double>(pieces(), whole_.data(), t * (time_cells / period_), v);
  if (!piece) return std::nullopt;
  lanes::ContactExit exit =
      evaluate(*piece, terms_.data(), (t - piece->time) * piece->per_time, (v - piece->speed) * piece->per_speed);
  exit.ended = true;
  return exit;
}

}  // namespace graze
