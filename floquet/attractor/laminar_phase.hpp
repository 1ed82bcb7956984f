// SPDX-License-Identifier: GPL-3.0-or-later
// LaminarPhase: detects a laminar phase, a motion that nearly repeats itself for a long time without being known as periodic.
// Either it leaves a weakly unstable orbit or it approaches a weakly stable one. The motion must be continued, because its
// average may be that of a transient. If it was laminar throughout the average, the average is that of the orbit and says
// nothing about where the motion ends. Chaos that returns by chance soon leaves again, unless it is intermittent. Chaos in
// narrow bands stays, for longer than any motion that leaves an orbit at its exponent could.
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
  /// Starts at `state`, for returns after `period` periods to within `nearness` (relative to 1 + |x|). `longest_escape`:
  /// periods within which any motion that leaves an orbit has gone; 0: unknown.
  LaminarPhase(const Vector& state, int period, double nearness, std::int64_t longest_escape = 0)
      : period_(static_cast<std::size_t>(period)), nearness_(nearness), long_for_chaos_(longest_escape) {
    begin(state, std::max(shortest_laminar_phase, longest_escape));
  }
  /// Repeats the test over the periods of the average if the motion repeats itself at the end of it.
  void look_back(const Vector& begin_of_average, std::int64_t periods) {
    now_ = lasted_ >= static_cast<std::int64_t>(period_) + shortest_laminar_phase;
    on_an_orbit_ = now_ && drift_ < near_an_orbit;
    stays_ = repeats_ && long_for_chaos_ > 0 && !on_an_orbit_;
    if (now_) begin(begin_of_average, periods);
  }

  bool open() const { return repeats_ && lasted_ < longest_ && (now_ || on_it_ < shortest_laminar_phase); }
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

  /// Whether the motion must be continued.
  bool goes_on() const { return now_ && !stays_; }
  /// Whether it also repeated itself throughout look_back.
  bool always() const { return now_ && repeats_; }
  /// Whether, before look_back, it was so close to an orbit that leaving it takes long.
  bool on_an_orbit() const { return on_an_orbit_; }

 private:
  static constexpr std::int64_t shortest_laminar_phase = 128;
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
  std::deque<Vector> latest_;  // over one period
  std::int64_t long_for_chaos_, lasted_ = 0, longest_ = 0;
  std::int64_t on_it_ = 0;  ///< consecutive periods next to an orbit
  double drift_ = 0.0;
  bool repeats_ = true, now_ = false, stays_ = false, on_an_orbit_ = false;
};

}  // namespace graze
