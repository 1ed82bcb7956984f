// SPDX-License-Identifier: GPL-3.0-or-later
// ReturnWatch: detects when a motion returns to an earlier state.
#pragma once

#include <graze/lib/numerics/vector.hpp>

#include <cmath>

namespace graze {

/// Compares each state with a reference that is renewed at doubling intervals, first after 4 periods (Brent's cycle detection).
/// Most motions are near their orbit long before the transient ends.
class ReturnWatch {
 public:
  explicit ReturnWatch(double recurrence) : recurrence_(recurrence) {}
  /// Takes the next state. Returns the number of periods since the reference if the state is within `recurrence` of it
  /// (relative to 1 + |x|), otherwise 0.
  int see(const Vector& state) {
    ++periods_;
    int back = 0;
    // Entry by entry: usually the first one already differs too much.
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
