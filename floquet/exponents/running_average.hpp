// SPDX-License-Identifier: GPL-3.0-or-later
// RunningAverage: the running time average of the Lyapunov exponents over several motions on one attractor, which average over it
// sooner than one, and the rule that ends it. It is taken for a task, whose slot carries the motions.
#pragma once

#include <graze/floquet/exponents/lyapunov.hpp>
#include <graze/floquet/exponents/motion_growth.hpp>
#include <graze/lib/tasks/task.hpp>

#include <cstdint>
#include <vector>

namespace graze {

class CarriedMotions;
class TaskSlot;

class RunningAverage {
 public:
  /// Over LyapunovOptions::motions motions until the options' rule is met. Each motion beyond the first starts 1e-7 (1 + |x|)
  /// from the one before (neighbouring_starts). If there are several, all are first carried for `decorrelation_periods` uncounted
  /// periods, in which chaos separates them; the last of these periods also align their tangent vectors.
  /// @throws std::invalid_argument as lyapunov_spectrum does, and for a table of other parameters.
  RunningAverage(const TaskSlot& slot, const AverageStart& start, const LyapunovOptions& options);

  /// Carries the average until it ends (false) or has averaged over this many periods (true), by up to `most_at_once` periods at
  /// a time.
  MotionTask<bool> carry(TaskSlot& slot, std::int64_t periods, std::size_t most_at_once = fewest_at_once);
  static constexpr std::size_t fewest_at_once = 32;

  /// State of its first motion.
  const Vector& state() const { return states_.front(); }
  LyapunovSpectrum result() &&;

 private:
  void stop(LyapunovStop reason);
  bool cancelled();
  void announce(const TaskSlot& slot);
  double count() const { return static_cast<double>(motions_.size()); }
  std::int64_t round() const { return options_.interval * static_cast<std::int64_t>(motions_.size()); }
  bool is_parting() const { return to_part_ > 0; }
  void add(const CarriedMotions& carried, std::size_t periods, bool all_threads);
  void add_part(const CarriedMotions& carried, std::size_t begin, std::size_t count, bool all_threads);
  std::int64_t until_look() const;
  void gather();
  void look();
  bool settled() const;
  double interval_time() const;
  double exponent(std::size_t i) const;
  double standard_error(std::size_t i) const;

  LyapunovOptions options_;
  std::vector<MotionGrowth> motions_;
  std::vector<Vector> states_;        ///< present ones of the motions
  double forced_interval_;            ///< time of an interval; 0: autonomous
  std::int64_t to_part_, uncounted_;  ///< periods left without tangents, and without counting
  std::vector<char> lost_;            ///< directions that some motion has lost
  std::vector<double> last_;          ///< exponents at the last look
  std::size_t requested_ = 0;         ///< periods of each motion so far
  bool open_, announced_ = false;
  LyapunovSpectrum out_;
};

/// Periods in which neighbouring motions part in chaos, and the last of these, with a tangent, that align it: chaos aligns
/// tangent vectors sooner than it separates motions.
inline constexpr std::int64_t decorrelation_periods = 300, aligning_periods = 60;
/// Starts of neighbouring motions, the first at `state`; of motion i the first coordinate that may be moved differs by
/// 1e-7 (1 + |x|) i.
std::vector<Vector> neighbouring_starts(const HybridSystem& system, const Vector& p, const Vector& state, int motions);

/// LyapunovOptions::motions for an average over possibly chaotic motion. enough_motions: for an average computed by itself.
/// motions_in_company: for one of many computed together; one motion is then enough unless the average is long.
int enough_motions(const HybridSystem& system, const Vector& p, const LyapunovOptions& averaging);
int motions_in_company(const LyapunovOptions& averaging);

}  // namespace graze
