// SPDX-License-Identifier: GPL-3.0-or-later
// CheckpointTimer: work that takes long is looked at now and then, so that its results so far can be written while it goes on:
// kill -9 and a power cut cost only what came after the last look. Work that can be looked at only when it has stopped is stopped
// at the end of each stint, as Ctrl-C would stop it, and then continued. A stint is long against the time that this takes.
#pragma once

#include <atomic>
#include <functional>
#include <optional>

namespace graze::apps {

/// Seconds.
using Clock = std::function<double()>;
double steady_seconds();

/// What a stint lasts at least, in seconds; it can be set for tests.
double stint_length();
void set_stint_length(double seconds);

class CheckpointTimer {
 public:
  /// What happens to the work at the end of a stint. If it stops, what was in work is lost.
  enum class End { stops, goes_on };

  /// Without a length there is one stint that does not end.
  CheckpointTimer(std::optional<double> length, End end, Clock clock = steady_seconds);

  /// A stint begins, with so many pieces of work done. (If none has been added by the last one, it was too short for that.)
  void begin(std::size_t done);

  /// A piece more is done. By one thread at a time.
  void news();

  /// Whether it is time. Any thread may ask.
  bool over() const { return over_; }

 private:
  std::optional<double> length_;
  End end_;
  Clock clock_;
  double begun_ = 0.0, ended_ = 0.0, due_ = 0.0;
  std::optional<std::size_t> done_;
  bool first_again_ = false;  ///< its first piece is still to come, after a stint before it
  std::atomic<bool> over_ = false;
};

}  // namespace graze::apps
