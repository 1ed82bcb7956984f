// SPDX-License-Identifier: GPL-3.0-or-later
// KeptState: a state, or the difference of two, that a motion keeps: the place of a mass that friction holds, or the distance of
// two masses that friction holds together.
#pragma once

#include <graze/lib/numerics/vector.hpp>

#include <algorithm>
#include <optional>
#include <vector>

namespace graze {

struct KeptState {
  Eigen::Index index = 0;
  std::optional<Eigen::Index> less = {};  ///< index of the state that is subtracted

  bool operator==(const KeptState&) const = default;
  double of(const Vector& x) const { return less ? x[index] - x[*less] : x[index]; }
  /// Gives it this value, and leaves the other states.
  void set(Vector& x, double value) const { x[index] = less ? x[*less] + value : value; }
  /// The row of its map, from the rows of the states.
  template <class AnyMatrix> Eigen::RowVectorXd row(const AnyMatrix& rows, Eigen::Index first = 0) const {
    Eigen::RowVectorXd out = rows.row(first + index);
    if (less) out -= rows.row(first + *less);
    return out;
  }
  /// Its gradient: n numbers.
  Eigen::RowVectorXd gradient(Eigen::Index n) const {
    Eigen::RowVectorXd out = Eigen::RowVectorXd::Unit(n, index);
    if (less) out[*less] = -1.0;
    return out;
  }
  /// The difference of its row and the one that keeps it that counts as rounding: none for a single state, whose row is exact.
  double rounding(const Eigen::RowVectorXd& row) const {
    return less ? 1e-12 * std::max(1.0, row.lpNorm<Eigen::Infinity>()) : 0.0;
  }
  /// Whether the map of all states keeps it.
  bool kept_by(const Matrix& map) const {
    const Eigen::RowVectorXd own = row(map);
    return (own - gradient(map.cols())).lpNorm<Eigen::Infinity>() <= rounding(own);
  }
};

/// All independent ones among n states for which keeps(KeptState) is true.
template <class Keeps> std::vector<KeptState> find_kept_states(Eigen::Index n, const Keeps& keeps) {
  std::vector<KeptState> list;
  const auto is_listed = [&](Eigen::Index i) {
    return std::any_of(list.begin(), list.end(), [i](const KeptState& one) { return one.index == i; });
  };
  for (Eigen::Index i = 0; i < n; ++i) {
    if (keeps(KeptState{i})) {
      list.push_back({i});
      continue;
    }
    for (Eigen::Index j = 0; j < i; ++j) {
      if (is_listed(j) || !keeps(KeptState{i, j})) continue;
      list.push_back({i, j});
      break;
    }
  }
  return list;
}

}  // namespace graze
