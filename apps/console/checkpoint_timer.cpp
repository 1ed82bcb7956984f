// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/console/checkpoint_timer.hpp>

#include <algorithm>
#include <chrono>

namespace graze::apps {

namespace {

double usual_length = 30.0;

/// Smallest ratio of an interval's length to the cost of its checkpoint.
constexpr double worth = 20.0;

}  // namespace

double steady_seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

double interval_length() { return usual_length; }

void set_interval_length(double seconds) { usual_length = seconds; }

CheckpointTimer::CheckpointTimer(std::optional<double> length, End end, Clock clock)
    : length_(length), end_(end), clock_(std::move(clock)) {}

void CheckpointTimer::begin(std::size_t done) {
  if (!length_) return;
  const double now = clock_();
  if (end_ == End::stops && done_ && done <= *done_) *length_ = 2.0 * std::max(*length_, ended_ - begun_);
  const double writing = done_ ? now - ended_ : 0.0;
  due_ = now + std::max(*length_, worth * writing);
  begun_ = now;
  first_again_ = done_.has_value();
  done_ = done;
  over_ = false;
}

void CheckpointTimer::news() {
  if (!length_ || over_) return;
  const double now = clock_();
  // Until its first piece is finished, an interval must restart the work and redo the pieces lost before.
  if (end_ == End::stops && first_again_) due_ = std::max(due_, begun_ + worth * (now - begun_));
  first_again_ = false;
  if (now < due_) return;
  ended_ = now;
  over_ = true;
}

}  // namespace graze::apps
