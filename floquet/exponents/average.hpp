// SPDX-License-Identifier: GPL-3.0-or-later
// Average: the running time average of the Lyapunov exponents over several motions on one attractor, and the rule that ends it.
// The caller carries the motions. A Motion is a MotionGrowth with state() and with times(): ReturnTimes of an
// autonomous motion, null for a forced one.
#pragma once

#include <graze/floquet/exponents/exponents.hpp>
#include <graze/floquet/exponents/frame_motion.hpp>
#include <graze/floquet/exponents/running_average.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace graze {

template <class Motion> class Average {
 public:
  /// `period`: the forcing period, or 0 for autonomous motions.
  Average(std::vector<Motion> motions, std::size_t directions, const LyapunovOptions& options, double period)
      : options_(options), motions_(std::move(motions)), forced_interval_(options.interval * period), lost_(directions, 0),
        last_(directions, 0.0) {
    uncounted_ = std::max<std::int64_t>(options.aligning, motions_.size() > 1 ? aligning_periods : 0);
    to_part_ = motions_.size() > 1 ? std::max<std::int64_t>(0, decorrelation_periods - uncounted_) : 0;
    out_.stop = LyapunovStop::budget;
    out_.state = motions_.front().state();
    open_ = options.max_periods >= round();
  }

  bool open() const { return open_; }
  const LyapunovOptions& options() const { return options_; }
  const std::vector<Motion>& motions() const { return motions_; }
  std::int64_t periods() const { return out_.periods; }
  const Vector& state() const { return out_.state; }
  /// Asks whether the average is cancelled, which ends it.
  bool cancelled() {
    if (!options_.cancelled || !options_.cancelled()) return false;
    stop(LyapunovStop::interrupted);
    return true;
  }

  /// The next work: whether with tangents, and how many of `periods` periods.
  bool with_tangents() const { return to_part_ == 0; }
  std::size_t part_of(std::size_t periods) const {
    return with_tangents() ? periods : std::min(periods, static_cast<std::size_t>(to_part_));
  }

  /// Adds `periods` more periods of each motion, in parts between two tests of the stop rule. add_part(motions, begin, count,
  /// counted) adds the periods begin ... begin + count - 1 of them. Before with_tangents() there is one part, without tangents.
  template <class AddPart> void add(std::size_t periods, const AddPart& add_part) {
    if (!with_tangents()) {
      add_part(motions_, std::size_t{0}, periods, false);
      to_part_ -= static_cast<std::int64_t>(periods);
      if (gather(); out_.termination != Termination::time) stop(LyapunovStop::failed);
    } else {
      for (std::size_t k = 0; k < periods && open_;) k += add_and_look(k, periods - k, add_part);
    }
    out_.state = motions_.front().state();
  }

  LyapunovSpectrum result() && {
    const auto correlation = [&](std::size_t i) {
      double time = 0.0;
      for (const Motion& motion : motions_) time += motion.means(i).correlation_time();
      return lost_[i] ? 0.0 : time / count() * options_.interval;
    };
    write_exponents(
        lost_.size(), [&](std::size_t i) { return exponent(i); }, [&](std::size_t i) { return standard_error(i); }, correlation,
        out_);
    for (std::size_t i = 1; i < motions_.size(); ++i) out_.others.push_back(motions_[i].state());
    return std::move(out_);
  }

 private:
  void stop(LyapunovStop reason) {
    if (open_) out_.stop = reason;
    open_ = false;
  }
  double count() const { return static_cast<double>(motions_.size()); }
  /// Periods of all motions in an interval.
  std::int64_t round() const { return options_.interval * static_cast<std::int64_t>(motions_.size()); }

  template <class AddPart> std::size_t add_and_look(std::size_t begin, std::size_t most, const AddPart& add_part) {
    const std::size_t n = std::min<std::size_t>(most, static_cast<std::size_t>(until_look()));
    const bool counted = uncounted_ == 0;
    add_part(motions_, begin, n, counted);
    if (gather(); out_.termination != Termination::time) {
      stop(LyapunovStop::failed);
    } else if (!counted) {
      uncounted_ -= static_cast<std::int64_t>(n);
    } else if (motions_.front().periods_open() == 0) {
      look();
    }
    return n;
  }

  /// Periods until the next test: the motions begin to count, have a new standard error, or may end.
  std::int64_t until_look() const {
    if (uncounted_ > 0) return uncounted_;
    const Motion& first = motions_.front();
    const std::int64_t to_end = (options_.max_periods - out_.periods) / static_cast<std::int64_t>(motions_.size());
    const std::int64_t intervals = options_.change > 0.0 || lost_[0] ? 1 : first.means(0).until_batch_ends();
    return std::max<std::int64_t>(1, std::min(intervals * options_.interval - first.periods_open(), to_end));
  }

  /// Collects the sums over all motions.
  void gather() {
    out_.impacts = 0;
    out_.periods = 0;
    out_.duration = out_.log_growth = out_.log_volume = 0.0;
    out_.termination = Termination::time;
    for (const Motion& motion : motions_) {
      out_.impacts += motion.impacts();
      out_.periods += motion.averaged();
      if (const ReturnTimes* const times = motion.times()) out_.duration += times->total();
      out_.log_growth += motion.means(0).total() / count();
      out_.log_volume += motion.log_volume() / count();
      out_.liouville_residual = std::max(out_.liouville_residual, motion.liouville_residual());
      for (std::size_t i = 0; i < lost_.size(); ++i) lost_[i] = lost_[i] || motion.lost(i);
      if (motion.termination() != Termination::time) out_.termination = motion.termination();
    }
  }

  /// Applies the stop rule after an orthonormalisation of all motions.
  void look() {
    if (options_.change > 0.0) {
      double change = 0.0;
      for (std::size_t i = 0; i < lost_.size(); ++i) {
        const double before = std::exchange(last_[i], lost_[i] ? 0.0 : exponent(i));
        change = std::max(change, std::abs(last_[i] - before));
      }
      if (out_.periods > round() && change < options_.change) return stop(LyapunovStop::change);
    }
    if (has_new_errors(options_, lost_[0], motions_.front().means(0)) && settled()) return stop(LyapunovStop::standard_error);
    if (out_.periods + round() > options_.max_periods) open_ = false;
  }

  bool settled() const {
    const std::int64_t each = out_.periods / static_cast<std::int64_t>(motions_.size());
    const bool is_chaos = grows_beyond_shear(out_.log_growth, out_.log_volume, each);
    return precise_enough(
        options_, out_.periods, is_chaos, lost_.size(), [&](std::size_t i) { return exponent(i); },
        [&](std::size_t i) { return standard_error(i); });
  }

  /// Mean time of an interval.
  double interval_time() const {
    if (forced_interval_ > 0.0) return forced_interval_;
    return out_.duration / static_cast<double>(std::max<std::int64_t>(out_.periods, 1)) * options_.interval;
  }

  double exponent(std::size_t i) const {
    if (lost_[i]) return -std::numeric_limits<double>::infinity();
    double sum = 0.0;
    std::int64_t terms = 0;
    for (const Motion& motion : motions_) {
      sum += motion.means(i).total();
      terms += motion.means(i).count();
    }
    return sum / static_cast<double>(std::max<std::int64_t>(terms, 1)) / interval_time();
  }

  /// The motions are independent, except for the ends of their series: near an orbit they do not separate. If they differ by
  /// more than their own errors explain (some have settled, or their correlation lasts longer than the average), their spread
  /// gives the error.
  double standard_error(std::size_t i) const {
    if (lost_[i]) return 0.0;
    const double rate = forced_interval_ > 0.0 ? 0.0 : exponent(i);
    double squares = 0.0, edges = 0.0, mean = 0.0, apart = 0.0, drift = 0.0;
    // Growth of the direction in an interval beyond that of the common rate in the motion's own time.
    const auto beyond = [&](const Motion& motion) {
      const ReturnTimes* const times = motion.times();
      return motion.means(i).mean() - (times ? rate * times->mean() : 0.0);
    };
    for (const Motion& motion : motions_) {
      const BatchMeans& growth = motion.means(i);
      const ReturnTimes* const times = motion.times();
      const double own = times ? times->error(i, growth, rate) : growth.standard_error();
      squares += own * own;
      edges += growth.edge() / count();
      mean += beyond(motion) / count();
      drift += (times ? times->drift(growth, rate) : growth.drift()) / count();
    }
    for (const Motion& motion : motions_) apart += (beyond(motion) - mean) * (beyond(motion) - mean);
    const double spread = motions_.size() > 1 ? apart / (count() - 1.0) / count() : 0.0;
    return with_trend(std::sqrt(std::max(squares / (count() * count()), spread) + edges * edges), drift) / interval_time();
  }

  LyapunovOptions options_;
  std::vector<Motion> motions_;
  double forced_interval_;  ///< time of an interval; 0: autonomous
  std::int64_t to_part_ = 0, uncounted_ = 0;
  std::vector<char> lost_;    ///< directions that some motion has lost
  std::vector<double> last_;  ///< exponents at the last look
  bool open_ = true;
  LyapunovSpectrum out_;
};

}  // namespace graze
