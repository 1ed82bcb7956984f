// SPDX-License-Identifier: GPL-3.0-or-later
// KnownAttractors: what recognises the attractors that have been met, so that a motion need not be carried to its end: the
// trapping region of a stable orbit, the visited cells of one that is not periodic.
#pragma once

#include <graze/floquet/attractor.hpp>
#include <graze/floquet/trapping_region.hpp>
#include <graze/floquet/visited_cells.hpp>

#include <optional>
#include <vector>

namespace graze {

struct KnownAttractor {
  AttractorType type = AttractorType::undecided;
  TrappingRegion orbit;
  VisitedCells cells;
};

class KnownAttractors {
 public:
  std::size_t size() const { return list_.size(); }
  const KnownAttractor& operator[](std::size_t i) const { return list_[i]; }
  void add(KnownAttractor known) { list_.push_back(std::move(known)); }
  /// Forgets what was added last.
  void keep(std::size_t count) { list_.resize(count); }

  /// The attractor that a motion has reached with its next state; `strands`: one for each attractor, of that motion.
  std::optional<std::size_t> reached(const Vector& state, std::vector<Strand>& strands) const;
  /// The known orbit of this period through the state, as far as two runs of Newton's method agree.
  std::optional<std::size_t> orbit_at(const Vector& state, int period) const;
  /// The nearest known orbit that is nearer than `distance`, of this period or a divisor, if its rate is known.
  std::optional<std::size_t> orbit_around(const Vector& state, int period, double distance) const;
  /// Whether a known orbit is nearer than `distance`; `with_region`: of those that have a trapping region.
  bool orbit_near(const Vector& state, double distance, bool with_region) const;

 private:
  std::vector<KnownAttractor> list_;
};

}  // namespace graze
