// SPDX-License-Identifier: GPL-3.0-or-later
// Transient: runs the transient towards an attractor. It searches for an orbit at the end and, if AttractorOptions::recurrence
// is set, also when the motion returns.
#pragma once

#include <graze/floquet/attractor/attractor_task.hpp>
#include <graze/floquet/attractor/refused_orbits.hpp>
#include <graze/floquet/attractor/return_watch.hpp>
#include <graze/floquet/attractor/settling_orbit.hpp>
#include <graze/lib/motion/unbounded.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace graze {

/// Distance (relative to 1 + |x|) of returns for which Newton's method is tried, larger than the one that triggers a search.
/// Also the bound on the drift of a laminar phase.
inline double return_tolerance(const AttractorOptions& options) {
  return 20.0 * (options.recurrence > 0.0 ? options.recurrence : usual_recurrence);
}

/// Longest period in a search for an orbit after `carried` forcing periods: max_period, in fast mode at most 64 or 1/16 of
/// `carried`. (A motion that has settled on a longer orbit is recognised by its return.)
inline int longest_period_tried(const AttractorOptions& options, std::int64_t carried) {
  constexpr std::int64_t always = short_return, part = 16;
  if (!(options.recurrence > 0.0)) return options.max_period;
  return static_cast<int>(std::min<std::int64_t>(options.max_period, std::max(always, carried / part)));
}

inline bool cancelled(const AttractorOptions& options) { return options.lyapunov.cancelled && options.lyapunov.cancelled(); }

class Transient {
 public:
  Transient(const SharedSystem& system, const Vector& p, const Vector& start, const AttractorOptions& options)
      : system_(system), p_(p), options_(options), watch_(options.recurrence) {
    if (options.transient < 0)
      throw std::invalid_argument(fmt::format("the transient is {} periods; allowed is 0 or more", options.transient));
    initial_mode(system, 0.0, start, p);
    out_.state = start;
    out_.termination = Termination::time;
    if (transient() == 0) asks_ = longest_period_tried(options, 0);
  }

  bool open() const { return open_ && asks_ == 0; }
  const Vector& state() const { return out_.state; }
  void stop(Termination reason) {
    out_.termination = reason;
    open_ = false;
    asks_ = 0;
  }

  /// Takes the result of the next period.
  void see(Termination termination, const Vector& state) {
    ++periods_;
    if (termination == Termination::event_limit) {  // maybe endless, ever lower bounces on its stop
      broken_ = true;
      asks_ = 1;
      return;
    }
    if (termination == Termination::no_return) out_.state = state;
    if (termination != Termination::time) return stop(termination);
    out_.state = state;
    if (at_end() && resonant_periods(system_, p_, state) > periods_) return stop(Termination::resonance);
    asks_ = std::min(watch_.see(state), options_.max_period);
    if (periods_ == transient()) asks_ = std::max(asks_, longest_period_tried(options_, periods_));
  }

  /// > 0: waits for answer(), whether the motion is settling on an orbit of up to this many periods.
  int asks() const { return asks_; }
  /// The orbits that the motion was seen to pass at its returns. Null at the end of the transient, when all are tried again.
  RefusedOrbits* passed_by() { return at_end() ? nullptr : &passed_by_; }
  void answer(std::optional<StableOrbit> orbit) {
    if (!orbit && broken_) return stop(Termination::event_limit);
    open_ = !orbit && !at_end();
    asks_ = 0;
    if (orbit) settle_on(out_, std::move(*orbit));
  }

  Attractor result() && { return std::move(out_); }

 private:
  /// An autonomous motion starts anywhere: it must reach its first return.
  int transient() const { return is_forced(system_) ? options_.transient : std::max(1, options_.transient); }
  bool at_end() const { return periods_ >= transient(); }

  SharedSystem system_;
  Vector p_;
  AttractorOptions options_;
  ReturnWatch watch_;
  RefusedOrbits passed_by_;
  Attractor out_;
  int periods_ = 0, asks_ = 0;
  bool open_ = true, broken_ = false;  // broken: the next period has more events than are allowed
};

}  // namespace graze
