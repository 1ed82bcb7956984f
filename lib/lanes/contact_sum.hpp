// SPDX-License-Identifier: GPL-3.0-or-later
// Evaluation of a table of Hertz contacts (contact_pieces.hpp). The order of summation is the same for any number of lanes.
#pragma once

#include <graze/lib/lanes/contact_pieces.hpp>
#include <graze/lib/lanes/real.hpp>

#include <bit>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

/// Exponent of 2 of a positive normal number.
template <class Real> [[gnu::always_inline]] inline std::int64_t band_of(double v) {
  return (std::bit_cast<std::int64_t>(v) >> 52) - 1023;
}

/// The piece at a column of cells and a speed; null: not covered. (A template of Real, so that each kind of processor has its
/// own.)
template <class Real>
inline const ContactPiece* find_piece(const ContactPieces& table, const std::uint16_t* cells, double column, double v) {
  const std::int64_t band = band_of<Real>(v) - table.lowest_band;
  if (!(v > 0.0) || band < 0 || band >= table.bands) return nullptr;
  if (!(column >= 0.0 && column < static_cast<double>(time_cells))) return nullptr;
  const auto row = static_cast<std::size_t>((std::bit_cast<std::int64_t>(v) >> 49) & 7);
  const std::size_t cell = (static_cast<std::size_t>(band) * time_cells + static_cast<std::size_t>(column)) * speed_cells + row;
  const std::uint16_t piece = cells[cell];
  return piece == no_piece ? nullptr : table.pieces + piece;
}

/// T_0 ... T_15 at x.
template <class Real> inline void chebyshev(const Real& x, Real (&T)[polynomials]) {
  const Real twice = x + x;
  T[0] = Real(1.0);
  T[1] = x;
  for (std::size_t i = 2; i < polynomials; ++i) T[i] = twice * T[i - 1] - T[i - 2];
}

/// The four quantities: sum over k and j, with the polynomials of one lane at T[stride * i].
template <class Real>
[[gnu::always_inline]] inline void add_up(const TermPair* all, const PieceTerms& terms, const double* T_time,
                                          const double* T_speed, std::size_t stride, double (&out)[4]) {
  constexpr std::size_t W = width<Real>, chunks = 8 / W;
  Real total[chunks];
  for (Real& one : total) one = Real(0.0);
  const TermPair* term = all + terms.first;
  for (std::size_t k = 0; k < polynomials / 2; ++k) {
    const std::size_t n = terms.count[k];
    if (n == 0) break;
    Real even[chunks], odd[chunks];
    for (std::size_t i = 0; i < chunks; ++i) even[i] = odd[i] = Real(0.0);
    const double* T = T_speed;
    std::size_t j = 0;
    for (; j + 1 < n; j += 2, term += 2, T += 2 * stride) {
      const Real one = Real(T[0]), two = Real(T[stride]);
      for (std::size_t i = 0; i < chunks; ++i) {
        even[i] = madd(take<Real>(term[0].at + i * W), one, even[i]);
        odd[i] = madd(take<Real>(term[1].at + i * W), two, odd[i]);
      }
    }
    if (j < n) {
      const Real one = Real(T[0]);
      for (std::size_t i = 0; i < chunks; ++i) even[i] = madd(take<Real>(term->at + i * W), one, even[i]);
      ++term;
    }
    const double first = T_time[2 * k * stride], second = T_time[(2 * k + 1) * stride];
    for (std::size_t i = 0; i < chunks; ++i) {
      Real weight;
      if constexpr (W == 8) {
        alignas(64) static constexpr double half[8] = {0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0};
        weight = select(take<Real>(half) > Real(0.5), Real(second), Real(first));
      } else {
        weight = Real(i * W < 4 ? first : second);
      }
      total[i] = madd(weight, Real(even[i] + odd[i]), total[i]);
    }
  }
  alignas(64) double sum[8];
  for (std::size_t i = 0; i < chunks; ++i) put(sum + i * W, total[i]);
  for (std::size_t f = 0; f < 4; ++f) out[f] = sum[f] + sum[4 + f];
}

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
