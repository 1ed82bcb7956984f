// SPDX-License-Identifier: GPL-3.0-or-later
// ContactTable: the contacts of one linear oscillator with a Hertz stop, as a smooth map of the time t of entry in the forcing
// period and the speed v of entry:
//     (t, v) -> duration, speed of exit, integral of trace(f_x) over the contact, and its tangent Phi at fixed times.
//
// The map is interpolated by Chebyshev polynomials in t and v (16 each, without negligible terms). Rectangles are bisected
// until the interpolant is good: its last coefficients are small, and between the nodes it agrees with newly computed contacts,
// to `value_error` (1 + |value|) and `tangent_error` (1 + |Phi|). Where bisection fails (next to a grazing; contacts that
// outlast 3 / eta or the period), the table does not cover (t, v), and a contact must be carried in steps.
#pragma once

#include <graze/lib/lanes/contact_pieces.hpp>
#include <graze/lib/lanes/lane_width.hpp>
#include <graze/lib/system/hybrid_system.hpp>

#include <optional>
#include <vector>

namespace graze {

struct SpeedRange {
  double lowest = 0.0, highest = 0.0;  ///< rounded outwards to powers of 2
};

/// Size, coverage and accuracy of a table, measured when it is made.
struct ContactTableReport {
  std::size_t pieces = 0, bytes = 0;
  std::size_t contacts = 0;    ///< contacts carried in steps to make it
  double covered = 0.0;        ///< share of the cells, each a part of a period and of an octave of speed
  double covered_begun = 0.0;  ///< likewise of contacts in which a period ends
  double value_error = 0.0;    ///< largest between the nodes, relative to 1 + |value|
  double tangent_error = 0.0;  ///< relative to 1 + |Phi|
};

class ContactTable {
 public:
  static constexpr double value_error = 1e-13, tangent_error = 1e-11;  ///< allowed

  /// Whether the lanes support the system, with a linear flight and a contact of Hertz's law.
  static bool applies(const HybridSystem& system, const Vector& p);

  /// Made on all threads of the caller's arena (oneTBB); the table is the same to the last bit for any width and number of
  /// threads. @throws std::invalid_argument if applies() is false, and for a range that is empty or not within [2^-20, 2^20].
  ContactTable(const HybridSystem& system, const Vector& p, const SpeedRange& speeds, LaneWidth width = LaneWidth::widest);

  /// The contact that begins at 0 <= t < T with speed v > 0; nullopt: not covered.
  std::optional<lanes::ContactExit> at(double t, double v) const;

  bool made_for(const lanes::Coefficients& oscillator) const { return oscillator == oscillator_; }
  const ContactTableReport& report() const { return report_; }
  /// View for the lanes, valid as long as the table.
  lanes::ContactPieces pieces() const;

 private:
  void tabulate(std::vector<std::uint16_t>& cells, const ContactTable* whole, LaneWidth width);
  lanes::Coefficients oscillator_{};
  double period_ = 0.0;
  std::int64_t lowest_band_ = 0, bands_ = 0;
  std::vector<std::uint16_t> whole_, begun_;
  std::vector<lanes::ContactPiece> pieces_;
  std::vector<lanes::TermPair> terms_;
  ContactTableReport report_;
};

}  // namespace graze
