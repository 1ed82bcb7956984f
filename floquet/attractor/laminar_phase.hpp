// SPDX-License-Identifier: GPL-3.0-or-later
// LaminarPhase: a motion that repeats itself, nearly and for long, without being known as periodic. It leaves a weakly unstable
// orbit, or comes to a weakly stable one, and has to be followed on: what was averaged may have been a transient. If it has done
// so all the time while it was averaged, the average is that orbit's, and says nothing of where the motion ends. (Chaos that
// happens to come back is soon away, but where it is intermittent. Chaos in narrow bands stays: longer than any motion that
// leaves an orbit at its exponent could.)
#pragma once

#include <graze/lib/numerics/vector.hpp>
#include <graze/lib/system/termination.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>

namespace graze {

class LaminarPhase {
 public:
  /// At `state`, with returns after so many periods to within `nearness` (relative to 1 + |x|). `long_for_chaos`: no motion that
  /// leaves an orbit would take so long; 0: that is not known.
  LaminarPhase(const Vector& state, int period, double nearness, std::int64_t long_for_chaos = 0)
      : period_(static_cast<std::size_t>(period)), nearness_(nearness), long_for_chaos_(long_for_chaos) {
    begin(state, std::max(long_enough, long_for_chaos));
  }
  /// The same question to the periods that went before, if the answer was yes.
  void look_back(const Vector& begin_of_average, std::int64_t periods) {
    now_ = lasted_ >= static_cast<std::int64_t>(period_) + long_enough;
    on_an_orbit_ = now_ && drift_ < near_an_orbit;
    stays_ = repeats_ && long_for_chaos_ > 0 && !on_an_orbit_;
    if (now_) begin(begin_of_average, periods);
  }

  bool open() const { return repeats_ && lasted_ < longest_ && (now_ || on_it_ < long_enough); }
  const Vector& state() const { return latest_.back(); }
  void see(Termination termination, const Vector& state) {
    ++lasted_;
    latest_.push_back(state);
    repeats_ = termination == Termination::time;
    if (latest_.size() <= period_ + 1) return;
    latest_.pop_front();
    drift_ = size(state - latest_.front()) / (1.0 + size(latest_.front()));
    repeats_ = repeats_ && drift_ <= nearness_;
    on_it_ = drift_ < near_an_orbit ? on_it_ + 1 : 0;
  }

  /// Whether it has to be followed on.
  bool goes_on() const { return now_ && !stays_; }
  /// Whether it repeated itself when it looked back, too.
  bool always() const { return now_ && repeats_; }
  /// Whether it was so near an orbit, before it looked back, that it would not leave it for long.
  bool on_an_orbit() const { return on_an_orbit_; }

 private:
  static constexpr std::int64_t long_enough = 128;
  static constexpr double near_an_orbit = 1e-6;
  static double size(const Vector& x) { return x.lpNorm<Eigen::Infinity>(); }
  void begin(const Vector& state, std::int64_t periods) {
    latest_ = {state};
    lasted_ = 0;
    longest_ = static_cast<std::int64_t>(period_) + periods;
    repeats_ = true;
  }

  std::size_t period_;
  double nearness_;
  std::deque<Vector> latest_;  // of one period
  std::int64_t long_for_chaos_, lasted_ = 0, longest_ = 0;
  std::int64_t on_it_ = 0;  ///< for so long it has been next to an orbit
  double drift_ = 0.0;
  bool repeats_ = true, now_ = false, stays_ = false, on_an_orbit_ = false;
};

}  // namespace graze
