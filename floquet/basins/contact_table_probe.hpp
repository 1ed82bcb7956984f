// SPDX-License-Identifier: GPL-3.0-or-later
// ContactTableProbe: carries the first of many motions of one oscillator with one set of parameters. It measures how soon they
// settle and how fast they hit the barrier, and builds a table of contacts at those speeds for all motions if that pays.
#pragma once

#include <graze/floquet/attractor/attractor.hpp>
#include <graze/lib/motion/lane_carrier.hpp>

#include <memory>
#include <vector>

namespace graze {

class ContactTableProbe {
 public:
  /// `starts`: of all motions, at forcing phase 0, one per column. The table and its existence depend on nothing else.
  ContactTableProbe(const SharedSystem& system, const Vector& p, const Matrix& starts, const FlowOptions& flow = {});

  /// Null: the lanes do not support the oscillator, or a table does not pay.
  const std::shared_ptr<const ContactTable>& table() const { return table_; }
  /// The states of a motion at forcing phase 0, from `start` on; fewer than `count` if it cannot be continued. Called by one
  /// thread at a time.
  std::vector<Vector> states(const Vector& start, std::size_t count) const;
  /// States that cover a nonperiodic attractor, `count` or a few more in all: those of one motion on it. If it is chaotic and
  /// the lanes support the oscillator, they come from several motions separated by chaos, one after the other, each with a
  /// multiple of VisitedCells::window states.
  std::vector<Vector> states(const Attractor& attractor, std::size_t count) const;

 private:
  SharedSystem system_;
  Vector p_;
  FlowOptions flow_;
  std::unique_ptr<LaneCarrier> many_;
  std::shared_ptr<const ContactTable> table_ = nullptr;
};

}  // namespace graze
