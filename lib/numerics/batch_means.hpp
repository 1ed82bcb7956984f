// SPDX-License-Identifier: GPL-3.0-or-later
// BatchMeans: mean of a correlated series with its standard error. The series is cut into batches of equal length, 32 to 64 of
// them in a long series: when there are 64, neighbours are merged and the length doubles. The means of batches much longer than
// the correlation time are practically independent: error^2 = variance of the batch means / number of batches.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace graze {

class BatchMeans {
 public:
  void add(double value) { add(std::span<const double>(&value, 1)); }
  void add(std::span<const double> values) {
    while (!values.empty()) {
      if (count_ == 0) first_ = values.front();
      const std::size_t n = std::min(values.size(), static_cast<std::size_t>(until_batch_ends()));
      double sum = sum_, squares = squares_, open = open_;
      for (const double value : values.first(n)) {
        const double beyond = value - first_;
        sum += beyond;
        squares += beyond * beyond;
        open += value;
      }
      sum_ = sum;
      squares_ = squares;
      open_ = open;
      count_ += static_cast<std::int64_t>(n);
      in_open_ += static_cast<std::int64_t>(n);
      values = values.subspan(n);
      if (in_open_ == length_) end_batch();
    }
  }

  std::int64_t count() const { return count_; }
  double total() const { return static_cast<double>(count_) * first_ + sum_; }
  double mean() const { return total() / static_cast<double>(std::max<std::int64_t>(count_, 1)); }
  /// True if the last value completed a batch, which updated the standard error. until_batch_ends(): number of values up to the
  /// next completion.
  bool ended_batch() const { return in_open_ == 0; }
  std::int64_t until_batch_ends() const { return length_ - in_open_; }
  /// Infinite until there are 16 batches.
  double standard_error() const { return error_; }
  /// Mean of the later half of the batches minus that of the earlier half; 0 until there are 16 batches.
  double drift() const {
    if (batches_.size() < most / 4) return 0.0;
    const std::size_t half = batches_.size() / 2;
    double earlier = 0.0, later = 0.0;
    for (std::size_t i = 0; i < half; ++i) {
      earlier += batches_[i];
      later += batches_[batches_.size() - 1 - i];
    }
    return (later - earlier) / static_cast<double>(half);
  }
  /// Effect of the ends of the series: if terms alternate strongly (the growth along an orbit of several periods), the mean
  /// depends on their number. Standard deviation of a term divided by the count; negligible in chaos.
  double edge() const { return count_ > 1 ? std::sqrt(variance()) / static_cast<double>(count_) : 0.0; }
  /// Integrated correlation time, in terms of the series: error^2 = 2 tau variance / count; 1/2 for independent terms.
  double correlation_time() const {
    const double error = standard_error(), spread = variance();
    return spread > 0.0 ? 0.5 * error * error * static_cast<double>(count_) / spread : 0.5;
  }

 private:
  static constexpr std::size_t most = 64;

  void end_batch() {
    batches_.push_back(open_ / static_cast<double>(length_));
    open_ = 0.0;
    in_open_ = 0;
    if (batches_.size() == most) {
      for (std::size_t i = 0; i < most / 2; ++i) batches_[i] = 0.5 * (batches_[2 * i] + batches_[2 * i + 1]);
      batches_.resize(most / 2);
      length_ *= 2;
      batch_sum_ = batch_squares_ = 0.0;
      for (const double batch : batches_) count_in(batch);
    } else {
      count_in(batches_.back());
    }
    error_ = error_of_batches();
  }

  double variance() const {
    const auto n = static_cast<double>(count_);
    return count_ > 1 ? std::max(0.0, (squares_ - sum_ * sum_ / n) / (n - 1.0)) : 0.0;
  }

  double error_of_batches() const {
    const std::size_t n = batches_.size();
    if (n < most / 4) return std::numeric_limits<double>::infinity();
    const auto all = static_cast<double>(n);
    return std::sqrt(std::max(0.0, batch_squares_ - batch_sum_ * batch_sum_ / all) / (all - 1.0) / all);
  }

  void count_in(double batch) {
    const double beyond = batch - batches_.front();
    batch_sum_ += beyond;
    batch_squares_ += beyond * beyond;
  }

  std::vector<double> batches_;
  std::int64_t count_ = 0, length_ = 1, in_open_ = 0;
  double first_ = 0.0, sum_ = 0.0, squares_ = 0.0;  // sums of the differences from the first value, and of their squares
  double batch_sum_ = 0.0, batch_squares_ = 0.0;    // the same for the batch means, from the first one
  double open_ = 0.0, error_ = std::numeric_limits<double>::infinity();
};

}  // namespace graze
