// SPDX-License-Identifier: GPL-3.0-or-later
// SweepChain: the rows of one direction of a sweep, each from those before it: the motion is followed from where it was at the
// value before. Behind a row that is not known to be periodic it is handed on early: what that row is takes long to find out, and
// is found out beside it (SweepWork).
//
// On a smooth branch the orbits of a block of values are found ahead (orbits_ahead.hpp). Blocks begin at every 16th value, and
// what is found in one depends on the rows before it alone: a sweep that was interrupted comes to the same rows.
#pragma once

#include <graze/continuation/sweep.hpp>

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

namespace graze {

class SweepChain {
 public:
  SweepChain(const HybridSystem& system, const Vector& p, const Vector& start, const SweepOptions& options,
             SweepDirection direction);

  SweepDirection direction() const { return direction_; }
  std::size_t size() const { return values_.size(); }
  Vector parameters(double value) const;

  /// What row k wants of those before it.
  struct Before {
    std::size_t number = 0;                   ///< k
    Vector end;                               ///< where the row before ended; the start of the sweep
    bool settled = true;                      ///< whether that is periodic
    std::vector<std::vector<Vector>> orbits;  ///< of the rows before its block that are alike, the last one last
  };
  /// The first row of its block, before which orbits are looked for.
  static std::size_t block_of(std::size_t number) { return number / block * block; }
  /// Whether two rows, one behind the other, are periodic in the same way.
  static bool alike(const SweepRow& before, const SweepRow& row);
  const Vector& start() const { return start_; }

  /// Row k, with what its orbit is if it was found; empty where it was interrupted, or where the motion could not be carried on.
  std::optional<SweepRow> row(const Before& before);
  /// Forcing periods of the transient of a row that are left behind SweepRow::end.
  int transient_left(const Before& before) const;
  /// Rows were taken back: those before a block may be others.
  void forget() { block_begin_ = none; }

  /// Puts down what there is to be seen of a row's orbit, and keeps of it what it is, and not how it was found: there may be a
  /// million rows.
  void sample_orbit(SweepRow& row) const;
  /// What there is to be seen of any other motion.
  void sample_motion(SweepRow& row) const;

 private:
  static constexpr std::size_t block = 16, none = std::numeric_limits<std::size_t>::max();
  std::optional<Attractor> attractor(const Before& before, const Vector& p);
  void look_ahead(const Before& before);
  int transient_of(const Before& before) const;
  int handed_on_after(const Before& before) const;
  Attractor handed_on(const Vector& p, const Vector& start, int periods) const;

  const HybridSystem& system_;
  const SweepOptions& options_;
  std::size_t parameter_;
  Vector p_, start_;
  SweepDirection direction_;
  std::vector<double> values_;
  std::size_t block_begin_ = none;
  std::vector<PeriodicOrbit> ahead_;  ///< of the rows from there on
};

}  // namespace graze
