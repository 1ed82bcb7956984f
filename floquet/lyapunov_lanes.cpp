// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/batch_means.hpp>
#include <graze/floquet/exponents.hpp>
#include <graze/floquet/log_product.hpp>
#include <graze/floquet/lyapunov_lanes.hpp>
#include <graze/lib/many_motions.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace graze {

namespace {

/// An average that may stop early is expected to last when it has gone on for so many periods.
constexpr std::int64_t lasting = ManyMotions::periods_for_table / 4;
/// Forcing periods between two looks at what has been reached: an eighth of what there was, lest much be carried in vain.
constexpr std::size_t shortest_stretch = 32, longest_stretch = 256;

/// One motion with its first tangent vector.
struct Strand {
  MotionStart at;
  double c = 1.0, s = 0.0;
  LogProduct growth = {}, det = {};  // since the last orthonormalisation
  double liouville = 0.0;            // likewise
  int periods = 0;
  std::array<BatchMeans, 2> means = {};
};

/// All motions of one start.
class Average {
 public:
  Average(const AverageStart& start, std::size_t set, const LyapunovOptions& options, double period)
      : options_(options), interval_time_(options.interval * period) {
    const double apart = 1e-7 * (1.0 + std::abs(start.state[0]));
    for (int i = 0; i < std::max(1, options.motions); ++i)
      strands_.push_back({.at = {set, start.state[0] - apart * i, start.state[1]}});
    uncounted_ = std::max<std::int64_t>(options.aligning, strands_.size() > 1 ? parting : 0);
    out_.stop = LyapunovStop::budget;
    out_.state = start.state;
    open_ = options.max_periods >= options.interval * static_cast<std::int64_t>(strands_.size());
  }

  bool open() const { return open_; }
  const std::vector<Strand>& strands() const { return strands_; }

  /// Tells `many` what is still to come, once that is known.
  void announce(ManyMotions& many) {
    const bool to_the_end = options_.standard_error == 0.0 && options_.change == 0.0;
    if (announced_ || (!to_the_end && out_.periods < lasting)) return;
    announced_ = true;
    many.expect(strands_.front().at.parameters, options_.max_periods - out_.periods);
  }

  /// What `periods` more did to its motions, one after the other.
  void add(const PeriodResult* results, std::size_t periods) {
    for (std::size_t k = 0; k < periods && open_; ++k) {
      for (std::size_t i = 0; i < strands_.size(); ++i) add(strands_[i], results[i * periods + k]);
      out_.termination = results[k].termination;
      if (failed_) {
        out_.stop = LyapunovStop::failed;
        open_ = false;
      } else if (uncounted_ > 0) {
        --uncounted_;
      } else if (strands_.front().periods == 0) {
        look();
      }
    }
    out_.state = Vector{{strands_.front().at.x, strands_.front().at.v}};
  }

  void stop(LyapunovStop reason) {
    if (open_) out_.stop = reason;
    open_ = false;
  }
  std::int64_t periods() const { return out_.periods; }

  LyapunovSpectrum result() && {
    const auto correlation = [&](std::size_t i) {
      double time = 0.0;
      for (const Strand& strand : strands_) time += strand.means[i].correlation_time();
      return lost_[i] ? 0.0 : time / static_cast<double>(strands_.size()) * options_.interval;
    };
    hand_over(
        2, [&](std::size_t i) { return exponent(i); }, [&](std::size_t i) { return standard_error(i); }, correlation, out_);
    for (std::size_t i = 1; i < strands_.size(); ++i) out_.others.push_back(Vector{{strands_[i].at.x, strands_[i].at.v}});
    return std::move(out_);
  }

 private:
  void add(Strand& strand, const PeriodResult& period) {
    if (period.termination != Termination::time) {
      failed_ = true;
      return;
    }
    strand.at.x = period.x;
    strand.at.v = period.v;
    const double c = period.Phi[0] * strand.c + period.Phi[1] * strand.s, s = period.Phi[2] * strand.c + period.Phi[3] * strand.s;
    const double length = std::sqrt(c * c + s * s), inverse = 1.0 / length;
    strand.growth.multiply(length);
    strand.det.multiply(period.det);
    strand.liouville += period.liouville;
    strand.c = length > 0.0 ? c * inverse : 1.0;
    strand.s = length > 0.0 ? s * inverse : 0.0;
    const auto begin_interval = [&] {
      strand.growth = strand.det = {};
      strand.liouville = 0.0;
      strand.periods = 0;
    };
    if (uncounted_ > 0) return begin_interval();
    out_.impacts += period.impacts;
    if (++strand.periods < options_.interval) return;
    const double log_det = strand.det.value(), first = strand.growth.value();
    const std::array<double, 2> growth = {first, (std::isfinite(log_det) ? log_det : strand.liouville) - first};
    for (std::size_t i = 0; i < 2; ++i) {
      lost_[i] = lost_[i] || !std::isfinite(growth[i]);
      if (!lost_[i]) strand.means[i].add(growth[i]);
    }
    if (std::isfinite(log_det) && std::isfinite(strand.liouville))
      out_.liouville_residual = std::max(out_.liouville_residual, std::abs(log_det - strand.liouville) / options_.interval);
    begin_interval();
    out_.periods += options_.interval;
  }

  /// After an orthonormalisation of all motions: whether that is enough.
  void look() {
    const std::int64_t round = options_.interval * static_cast<std::int64_t>(strands_.size());
    if (options_.change > 0.0) {
      const std::array<double, 2> before = last_;
      for (std::size_t i = 0; i < 2; ++i) last_[i] = lost_[i] ? 0.0 : exponent(i);
      const double change = std::max(std::abs(last_[0] - before[0]), std::abs(last_[1] - before[1]));
      if (out_.periods > round && change < options_.change) return stop(LyapunovStop::change);
    }
    if (options_.change == 0.0 && options_.standard_error > 0.0 && settled()) return stop(LyapunovStop::standard_error);
    if (out_.periods + round > options_.max_periods) open_ = false;
  }

  bool settled() const {
    return precise_enough(
        options_, out_.periods, 2, [&](std::size_t i) { return exponent(i); }, [&](std::size_t i) { return standard_error(i); });
  }

  double exponent(std::size_t i) const {
    if (lost_[i]) return -std::numeric_limits<double>::infinity();
    double sum = 0.0;
    std::int64_t count = 0;
    for (const Strand& strand : strands_) {
      sum += strand.means[i].total();
      count += strand.means[i].count();
    }
    return sum / static_cast<double>(std::max<std::int64_t>(count, 1)) / interval_time_;
  }
  /// The motions are independent of each other, but for the ends of their series: near an orbit they do not part. Where they do
  /// not agree as well as each one's own error says (some have settled, or what correlates them in time lasts longer than they),
  /// their spread counts.
  double standard_error(std::size_t i) const {
    if (lost_[i]) return 0.0;
    const auto n = static_cast<double>(strands_.size());
    double squares = 0.0, edges = 0.0, mean = 0.0, apart = 0.0;
    for (const Strand& strand : strands_) {
      squares += strand.means[i].standard_error() * strand.means[i].standard_error();
      edges += strand.means[i].edge() / n;
      mean += strand.means[i].mean() / n;
    }
    for (const Strand& strand : strands_) apart += (strand.means[i].mean() - mean) * (strand.means[i].mean() - mean);
    const double spread = strands_.size() > 1 ? apart / (n - 1.0) / n : 0.0;
    return std::sqrt(std::max(squares / (n * n), spread) + edges * edges) / interval_time_;
  }

  const LyapunovOptions& options_;
  double interval_time_;
  std::vector<Strand> strands_;
  std::int64_t uncounted_ = 0;
  std::array<bool, 2> lost_{};
  std::array<double, 2> last_{};
  bool open_ = true, failed_ = false, announced_ = false;
  LyapunovSpectrum out_;
};

}  // namespace

std::vector<LyapunovSpectrum> lane_spectra(const HybridSystem& system, const std::vector<AverageStart>& starts,
                                           const LyapunovOptions& options) {
  ManyMotions many(system, options.flow);
  if (options.all_threads) many.use_all_threads();
  std::vector<Average> averages;
  averages.reserve(starts.size());
  for (const AverageStart& start : starts) {
    initial_mode(system, 0.0, start.state, start.p);
    const std::size_t set = many.add_parameters(start.p);
    if (options.table) many.use(set, *options.table);
    averages.emplace_back(start, set, options, forcing_period(system, start.p));
  }
  std::vector<MotionStart> motions;
  std::vector<PeriodResult> results;
  std::int64_t told = 0;
  std::size_t carried = 0;
  for (;;) {
    const bool cancelled = options.cancelled && options.cancelled();
    motions.clear();
    std::int64_t periods = 0;
    for (Average& average : averages) {
      if (cancelled) average.stop(LyapunovStop::interrupted);
      if (average.open()) average.announce(many);
      if (average.open())
        for (const Strand& strand : average.strands()) motions.push_back(strand.at);
      periods += average.periods();
    }
    if (options.progress && periods > told) options.progress(told = periods);
    if (motions.empty()) break;
    const std::size_t stretch = std::clamp(carried / 8, shortest_stretch, longest_stretch);
    many.carry(motions, stretch, true, results);
    carried += stretch;
    const PeriodResult* next = results.data();
    for (Average& average : averages) {
      if (!average.open()) continue;
      average.add(next, stretch);
      next += average.strands().size() * stretch;
    }
  }
  std::vector<LyapunovSpectrum> spectra;
  for (Average& average : averages) spectra.push_back(std::move(average).result());
  return spectra;
}

}  // namespace graze
