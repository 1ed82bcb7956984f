// SPDX-License-Identifier: GPL-3.0-or-later
// VisitedCells: what an attractor that is not periodic covers: the cells of a grid in which its states at forcing phase 0 lie.
// The grid is as fine (up to 128 cells across) as lets 99.9 % of the second half of the samples fall into cells of the first.
//
// CellResidence: a motion that stays in these cells for `window` periods on end, and visits as many of them as the attractor does
// in that time, has reached the attractor. In dissipative systems a motion that stays so long has come near by contraction; the
// number of cells tells it from a periodic orbit that happens to lie among them.
#pragma once

#include <graze/lib/numerics/vector.hpp>

#include <cstdint>
#include <vector>

namespace graze {

/// Numbers of cells, none of which is 0: a hash table with open addressing.
class CellSet {
 public:
  /// False: it was there.
  bool insert(std::uint64_t number);
  bool holds(std::uint64_t number) const { return slots_[place(number)] == number; }
  std::size_t size() const { return size_; }

 private:
  /// Where it is, or would be.
  std::size_t place(std::uint64_t number) const;

  std::vector<std::uint64_t> slots_ = std::vector<std::uint64_t>(std::size_t{1} << 7);  // 0: free
  int bits_ = 7;                                                                        // of an index of them
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
  /// Share of the states that lie in the cells.
  double share(const std::vector<Vector>& states) const;
  /// A number that belongs to the cell of x alone.
  std::uint64_t cell(const Vector& x) const;
  /// Cells that the attractor visits in `window` periods, at the least.
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
  /// The next state of the motion. True: it has reached the attractor.
  bool add(const VisitedCells& cells, const Vector& x);

 private:
  std::vector<std::uint64_t> met_;  // since it was last outside
};

}  // namespace graze
