// SPDX-License-Identifier: GPL-3.0-or-later
// ReturnWatch: whether a motion comes back to where it was.
#pragma once

#include <graze/lib/numerics/vector.hpp>

#include <cmath>

namespace graze {

/// Looks, period by period, for returns to a state that moves on in doubling steps (Brent's way to find a cycle): most motions
/// are near their orbit long before a transient is over.
class ReturnWatch {
 public:
  explicit ReturnWatch(double recurrence) : recurrence_(recurrence) {}
  /// The next state. The number of periods since the state looked at, if it is back within `recurrence` (relative to 1 + |x|);
  /// else 0.
  int see(const Vector& state) {
    ++periods_;
    int back = 0;
    // (Entry by entry: mostly the first is too far away.)
    bool near = looked_ >= 0;
    for (Eigen::Index i = 0; near && i < state.size(); ++i) near = std::abs(state[i] - looked_at_[i]) < within_;
    if (near) {
      back = periods_ - looked_;
      looked_ = -1;
      look_ = 2 * periods_;
    }
    if (periods_ == look_) {
      looked_ = periods_;
      looked_at_ = state;
      within_ = recurrence_ * (1.0 + state.lpNorm<Eigen::Infinity>());
      look_ = 2 * periods_;
    }
    return back;
  }

 private:
  double recurrence_, within_ = 0.0;
  int periods_ = 0, look_ = 4, looked_ = -1;
  Vector looked_at_;
};

}  // namespace graze
