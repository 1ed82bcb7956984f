// SPDX-License-Identifier: GPL-3.0-or-later
// CheckpointTimer: long computations are checkpointed periodically, so that kill -9 or a power cut costs only the work since
// the last checkpoint. Work that can be read only when it has stopped is stopped at the end of each interval between
// two checkpoints, as Ctrl-C would stop it, and then continued. An interval is long compared with the cost of a stop.
#pragma once

#include <atomic>
#include <functional>
#include <optional>

namespace graze::apps {

/// The time in seconds.
using Clock = std::function<double()>;
double steady_seconds();

/// Shortest length of an interval in seconds; tests can set it.
double interval_length();
void set_interval_length(double seconds);

class CheckpointTimer {
 public:
  /// Whether the work stops or continues at the end of an interval. If it stops, unfinished pieces are lost.
  enum class End { stops, goes_on };

  /// nullopt: a single interval without end.
  CheckpointTimer(std::optional<double> length, End end, Clock clock = steady_seconds);

  /// Begins an interval, with `done` pieces of work finished. If the previous one added none, it was too short, and the next one
  /// is longer.
  void begin(std::size_t done);

  /// Reports one more finished piece. Must be called by one thread at a time.
  void news();

  /// Whether the interval is over. Any thread may ask.
  bool over() const { return over_; }

 private:
  std::optional<double> length_;
  End end_;
  Clock clock_;
  double begun_ = 0.0, ended_ = 0.0, due_ = 0.0;
  std::optional<std::size_t> done_;
  bool first_again_ = false;  ///< the first piece after an earlier interval is not finished yet
  std::atomic<bool> over_ = false;
};

}  // namespace graze::apps
