// SPDX-License-Identifier: GPL-3.0-or-later
// Sweep: the attractor followed from one value of a parameter to the next, up, down or both ways, as in a laboratory experiment
// with its hysteresis. Each value starts from the orbit found at the previous value or, if there is none, from the state there
// after the transient. If the value before that had not settled either, the state after 64 forcing periods is used: chaos is on
// its attractor by then.
//
// Rows that have not settled are completed later: the rest of the transient, the samples and the time average take long and run
// in parallel for many rows (RowRunner). On smooth branches the orbits of the next values are also computed together
// (predicted_orbits.hpp). The values are divided into stretches that start at the same time, each from a guess of the state at
// the end of the stretch before it (Row).
#pragma once

#include <graze/floquet/attractor/attractor.hpp>

#include <functional>
#include <string>
#include <vector>

namespace graze {

enum class SweepDirection { up, down };

/// "up", "down".
std::string_view sweep_direction_name(SweepDirection direction);

/// The attractor at one of the values along which it is followed.
struct FollowedAttractor {
  Attractor attractor;                ///< without the complete orbit
  Vector end;                         ///< state at phase 0 from which the next value starts (its transient may have continued)
  std::vector<Vector> states;         ///< at forcing phase 0: those of the orbit, or SweepOptions::samples of them
  std::vector<double> impact_speeds;  ///< of the impacts (entries into contact) in the periods of `states`
};

struct SweepRow : FollowedAttractor {
  double value = 0.0;
  SweepDirection direction = SweepDirection::up;
};

struct SweepOptions {
  std::string parameter = "eta";
  double from = 0.0, to = 0.0, step = 0.0;  ///< values from, from + step, ... up to `to` (from < to, step > 0)
  std::vector<SweepDirection> directions = {SweepDirection::up};
  int first_transient = 1000;  ///< forcing periods at the first value; AttractorOptions::transient at the others
  int samples = 200;           ///< stroboscopic states (and impacts) kept of a nonperiodic attractor
  AttractorOptions attractor = {};
  int threads = 1;  ///< the result does not depend on it
  std::function<bool()> cancelled = {};
  std::function<void(std::size_t rows, double value)> progress = {};  ///< called by one thread at a time
  /// Called after each finished row, by one thread at a time; `so_far` returns the rows that sweep() would return now. Other
  /// threads may have to wait meanwhile.
  std::function<void(const std::function<std::vector<SweepRow>()>& so_far)> keep = {};
};

/// Rows in the order of computation, direction by direction. `so_far`: rows of an earlier run; they are kept, and the sweep
/// continues after them.
/// @throws std::invalid_argument for an unknown parameter, or an invalid range or step.
std::vector<SweepRow> sweep(const HybridSystem& system, const Vector& p, const Vector& start, const SweepOptions& options,
                            const std::vector<SweepRow>& so_far = {});

/// The values of a sweep, in ascending order.
std::vector<double> sweep_values(double from, double to, double step);

}  // namespace graze
