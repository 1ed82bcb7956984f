// SPDX-License-Identifier: GPL-3.0-or-later
// ContactTableProbe: goes ahead of many motions of one oscillator and one set of parameters: finds out how soon the first of them
// settle and how fast they meet the barrier, and keeps a table of contacts of those speeds for all, where one pays.
#pragma once

#include <graze/floquet/attractor/attractor.hpp>
#include <graze/lib/motion/lane_carrier.hpp>

#include <memory>
#include <vector>

namespace graze {

class ContactTableProbe {
 public:
  /// `starts`: of all motions, at forcing phase 0, a column each. The table, and whether there is one, depends on nothing else.
  ContactTableProbe(const HybridSystem& system, const Vector& p, const Matrix& starts, const FlowOptions& flow = {});

  /// Null: the lanes do not know the oscillator, or it does not pay.
  const ContactTable* table() const { return table_; }
  /// The states at forcing phase 0 of a motion, from its start on; fewer than `count` where it cannot be carried on. By
  /// one thread at a time.
  std::vector<Vector> states(const Vector& start, std::size_t count) const;
  /// What covers an attractor that is not periodic: the states of a motion on it, or, if it is chaotic and the lanes know the
  /// oscillator, of several that chaos has parted, one after the other, of each a multiple of VisitedCells::window: `count` or a
  /// few more in all.
  std::vector<Vector> states(const Attractor& attractor, std::size_t count) const;

 private:
  const HybridSystem& system_;
  const Vector& p_;
  FlowOptions flow_;
  std::unique_ptr<LaneCarrier> many_;
  const ContactTable* table_ = nullptr;
};

}  // namespace graze
