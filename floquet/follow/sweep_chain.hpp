// SPDX-License-Identifier: GPL-3.0-or-later
// SweepChain: the rows of one direction of a sweep, each computed from those before it: the motion continues from its state at
// the previous value. If a row has not been recognised as periodic, its state is published early; classifying it takes long and
// proceeds in parallel with the following rows (SweepWork).
//
// On a smooth branch the orbits of a block of values are predicted (predicted_orbits.hpp). Blocks begin at every 16th value,
// and their predictions depend only on the rows before them: an interrupted sweep gives the same rows when it is resumed.
#pragma once

#include <graze/floquet/follow/predicted_orbits.hpp>
#include <graze/floquet/follow/sweep.hpp>
#include <graze/lib/tasks/task.hpp>

#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

namespace graze {

class TaskSlot;

class SweepChain {
 public:
  SweepChain(const HybridSystem& system, const Vector& p, const Vector& start, const SweepOptions& options,
             SweepDirection direction);

  SweepDirection direction() const { return direction_; }
  std::size_t size() const { return values_.size(); }
  double value(std::size_t number) const { return values_[number]; }
  Vector parameters(double value) const;
  const Vector& start() const { return start_; }

  /// Start of row k.
  struct Begin {
    std::size_t number = 0;  ///< k
    Vector state;            ///< final or published state of the row before; at_start: the start of the sweep
    bool settled = true;     ///< the row before is periodic
    bool at_start = false;   ///< `state` is the start of the sweep
  };
  /// Number of values in a block.
  static constexpr std::size_t block = 16;
  /// First row of a row's block; orbits are predicted there.
  static std::size_t block_of(std::size_t number) { return number / block * block; }
  /// Whether two consecutive rows are periodic with the same n and p.
  static bool alike(const SweepRow& before, const SweepRow& row);

  SweepRow row(std::size_t number) const;
  /// The predicted orbits of a block of rows.
  struct Block {
    static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
    std::size_t begin = none;            ///< its first row
    std::vector<PredictedOrbit> orbits;  ///< of the rows from `begin` on
  };
  /// Whether the orbits of row k's block have yet to be predicted. Never with a time average on orbits, which a prediction
  /// lacks.
  bool looks_ahead(const Block& ahead, std::size_t number) const {
    return options_.attractor.periods_on_orbit == 0 && block_of(number) != ahead.begin;
  }
  /// Predicts them. `before`: the orbits of the rows before the block, as long as they are alike, the last one last.
  Block look_ahead(std::size_t number, const std::vector<std::vector<Vector>>& before) const;
  /// Row k, if its orbit was predicted.
  std::optional<SweepRow> known(Block& ahead, std::size_t number) const;

  /// Computes row k from the motion, in lanes if these support the oscillator. `publish` receives the start of the next row as
  /// soon as it is known, if this row is not yet known to be periodic. If the motion failed or `finding` cancelled it, the
  /// average of the result is incomplete.
  MotionTask<SweepRow> find(TaskSlot& lane, Begin begin, AttractorOptions finding,
                            std::function<void(const Vector& state)> publish) const;

 private:
  Vector off_guards(const Vector& p, const Vector& state) const;
  Vector with_its_stop(const Begin& begin, const Vector& p) const;
  MotionTask<std::optional<Vector>> carry_on(TaskSlot& lane, const Vector& p, const Vector& state, int periods) const;
  MotionTask<> sample(TaskSlot& lane, const Vector& p, SweepRow& row) const;

  const HybridSystem& system_;
  const SweepOptions& options_;
  std::size_t parameter_;
  Vector p_, start_;
  SweepDirection direction_;
  std::vector<double> values_;
};

}  // namespace graze
