// SPDX-License-Identifier: GPL-3.0-or-later
// Sweep: the attractor followed from one value of a parameter to the next, up, down or both ways: what a laboratory sees, with
// its hysteresis. Each value starts from the orbit on which the one before ended, or from where its motion was after the
// transient, and, if the one before that had not settled either, already after 64 forcing periods of it: chaos is on its
// attractor by then.
//
// What has not settled is left behind: the rest of its transient, its samples and its time average, which take long, are carried
// out side by side, for many rows (SweepWork). On smooth branches the orbits of the values ahead are computed side by side, too
// (SweepChain). And the values are divided into stretches that begin at the same time, each behind a guess of what those before
// it come to (SweepStretches).
#pragma once

#include <graze/floquet/attractor/attractor.hpp>

#include <functional>
#include <string>
#include <vector>

namespace graze {

enum class SweepDirection { up, down };

/// "up", "down".
std::string_view sweep_direction_name(SweepDirection direction);

struct SweepRow {
  double value = 0.0;
  SweepDirection direction = SweepDirection::up;
  Attractor attractor;                ///< without the orbit in full
  Vector end;                         ///< state at phase 0 from which the next value starts (behind it, a transient may go on)
  std::vector<Vector> states;         ///< at forcing phase 0: those of the orbit, or SweepOptions::samples of them
  std::vector<double> impact_speeds;  ///< of the impacts (entries) on the way through them
};

struct SweepOptions {
  std::string parameter = "eta";
  double from = 0.0, to = 0.0, step = 0.0;  ///< values from, from + step, ... up to `to` (from < to, step > 0)
  std::vector<SweepDirection> directions = {SweepDirection::up};
  int first_transient = 1000;  ///< forcing periods at the first value; AttractorOptions::transient at the others
  int samples = 200;           ///< stroboscopic states (and impacts) kept of an attractor that is not periodic
  AttractorOptions attractor = {};
  int threads = 1;  ///< the result does not depend on it
  std::function<bool()> cancelled = {};
  std::function<void(std::size_t rows, double value)> progress = {};  ///< by one thread at a time
  /// Told after each row that is done, by one thread at a time: what sweep() would return now. The others may wait for it.
  std::function<void(const std::function<std::vector<SweepRow>()>& so_far)> keep = {};
};

/// Rows in the order in which they are reached, direction by direction. `so_far`: rows of an earlier run, which are kept; the
/// sweep goes on behind them.
/// @throws std::invalid_argument for an unknown parameter, or a range or step that is not one.
std::vector<SweepRow> sweep(const HybridSystem& system, const Vector& p, const Vector& start, const SweepOptions& options,
                            const std::vector<SweepRow>& so_far = {});

/// The values of a sweep, ascending.
std::vector<double> sweep_values(double from, double to, double step);

}  // namespace graze
