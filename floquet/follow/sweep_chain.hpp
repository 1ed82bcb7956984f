// SPDX-License-Identifier: GPL-3.0-or-later
// SweepChain: the rows of one direction of a sweep, each from those before it: the motion is followed from where it was at the
// value before. Behind a row that is not known to be periodic it is handed on early: what that row is takes long to find out, and
// is found out beside those behind it (SweepWork).
//
// On a smooth branch the orbits of a block of values are found ahead (orbits_ahead.hpp). Blocks begin at every 16th value, and
// what is found in one depends on the rows before it alone: a sweep that was interrupted comes to the same rows.
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

  /// Where row k begins.
  struct Begin {
    std::size_t number = 0;  ///< k
    Vector state;            ///< where the row before ended, or was when it was handed on; the start of the sweep
    bool settled = true;     ///< whether that is periodic
    bool at_start = false;   ///< it is the start of the sweep
  };
  /// Values of a block.
  static constexpr std::size_t block = 16;
  /// The first row of its block, before which orbits are looked for.
  static std::size_t block_of(std::size_t number) { return number / block * block; }
  /// Whether two rows, one behind the other, are periodic in the same way.
  static bool alike(const SweepRow& before, const SweepRow& row);

  SweepRow row(std::size_t number) const;
  /// The orbits of a block of rows that were found ahead.
  struct Block {
    static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
    std::size_t begin = none;        ///< its first row
    std::vector<OrbitAhead> orbits;  ///< from there on
  };
  /// Whether the orbits of the block of row k are still to be looked for.
  bool looks_ahead(const Block& ahead, std::size_t number) const {
    return options_.attractor.periods_on_orbit == 0 && block_of(number) != ahead.begin;  // (an average belongs to an orbit)
  }
  /// Does so. `before`: the orbits of the rows before the block that are alike, the last one last.
  Block look_ahead(std::size_t number, const std::vector<std::vector<Vector>>& before) const;
  /// Row k, if its orbit was found.
  std::optional<SweepRow> known(Block& ahead, std::size_t number) const;

  /// What else row k is, in lanes if they know the oscillator. `hand_on` is told where the next row begins as soon as that is
  /// known, if this one is not known to be periodic by then. Where the motion could not be carried, or `finding` broke it off, no
  /// average has come to its end.
  MotionTask<SweepRow> find(TaskSlot& lane, Begin begin, AttractorOptions finding,
                            std::function<void(const Vector& state)> hand_on) const;

 private:
  Vector off_guards(const Vector& p, const Vector& state) const;
  Vector with_its_stop(const Begin& begin, const Vector& p) const;
  MotionTask<std::optional<Vector>> carry_on(TaskSlot& lane, const Vector& p, const Vector& state, int periods) const;
  MotionTask<> sample(TaskSlot& lane, const Vector& p, SweepRow& row) const;
  void sample_alone(const Vector& p, std::size_t periods, SweepRow& row) const;

  const HybridSystem& system_;
  const SweepOptions& options_;
  std::size_t parameter_;
  Vector p_, start_;
  SweepDirection direction_;
  std::vector<double> values_;
};

}  // namespace graze
