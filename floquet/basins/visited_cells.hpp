// SPDX-License-Identifier: GPL-3.0-or-later
// VisitedCells: the region covered by a nonperiodic attractor: the grid cells that contain its states at forcing phase 0. The
// grid is the finest (at most 128 cells across) for which 99.9 % of the second half of the samples fall into cells of the first
// half.
//
// CellResidence: a motion has reached the attractor if it stays in these cells for `window` consecutive periods and visits at
// least half as many different cells as the attractor always does in that time. In dissipative systems a motion that stays so
// long has come near by contraction; the number of cells distinguishes it from a periodic orbit that happens to lie among them.
#pragma once

#include <graze/lib/numerics/vector.hpp>

#include <cstdint>
#include <vector>

namespace graze {

/// Set of cell numbers, none of which is 0: a hash table with open addressing.
class CellSet {
 public:
  /// False: already present.
  bool insert(std::uint64_t number);
  bool holds(std::uint64_t number) const { return slots_[place(number)] == number; }
  std::size_t size() const { return size_; }

 private:
  /// Slot of the number, or the free slot for it.
  std::size_t place(std::uint64_t number) const;

  std::vector<std::uint64_t> slots_ = std::vector<std::uint64_t>(std::size_t{1} << 7);  // 0: free
  int bits_ = 7;                                                                        // bits of a slot index
  std::size_t size_ = 0;
};

class VisitedCells {
 public:
  static constexpr int window = 64;  ///< forcing periods

  VisitedCells() = default;
  /// `states`: at forcing phase 0 after 0, 1, 2, ... periods on the attractor.
  explicit VisitedCells(const std::vector<Vector>& states);

  bool holds(const Vector& x) const { return cells_.holds(cell(x)); }
  bool holds(std::uint64_t number) const { return cells_.holds(number); }
  /// Share of the states that lie in the visited cells.
  double share(const std::vector<Vector>& states) const;
  /// A number unique to the cell of x.
  std::uint64_t cell(const Vector& x) const;
  /// Least number of different cells that the attractor visits in `window` periods.
  std::size_t least_in_window() const { return least_in_window_; }
  std::size_t count() const { return cells_.size(); }

 private:
  void choose(const std::vector<Vector>& states, int across);

  Vector low_, per_size_;  ///< one over the size of a cell
  CellSet cells_;
  std::size_t least_in_window_ = 0;
};

class CellResidence {
 public:
  /// Takes the next state of the motion. True: it has reached the attractor.
  bool add(const VisitedCells& cells, const Vector& x);

 private:
  std::vector<std::uint64_t> met_;  // cells since the motion was last outside
};

}  // namespace graze
