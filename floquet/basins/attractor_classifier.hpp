// SPDX-License-Identifier: GPL-3.0-or-later
// AttractorClassifier: what recognises the attractors that have been met, so that a motion need not be carried to its end: the
// trapping region of a stable orbit, the visited cells of one that is not periodic.
#pragma once

#include <graze/floquet/attractor/attractor.hpp>
#include <graze/floquet/basins/trapping_region.hpp>
#include <graze/floquet/basins/visited_cells.hpp>

#include <optional>
#include <vector>

namespace graze {

struct KnownAttractor {
  AttractorType type = AttractorType::undecided;
  TrappingRegion orbit;
  VisitedCells cells;
};

/// A motion that may be on its way to a known orbit.
struct Nearing {
  std::size_t attractor = 0;
  double distance = 0.0;
  double periods = 0.0;  ///< in which the orbit's slowest multiplier halves a distance
  int times = 1;         ///< that so many have gone by when it is asked for
};

class AttractorClassifier {
 public:
  std::size_t size() const { return list_.size(); }
  const KnownAttractor& operator[](std::size_t i) const { return list_[i]; }
  void add(KnownAttractor known) { list_.push_back(std::move(known)); }
  /// Forgets what was added last.
  void keep(std::size_t count) { list_.resize(count); }

  /// Of a new motion: one for each of them, up to the last that is not periodic.
  std::vector<CellResidence> residences() const;

  /// Where a motion (of two states) is when it has reached a periodic one of them.
  std::vector<StateEllipse> ellipses() const;
  /// The attractor that a motion has reached with its next state; `residences`: its own.
  std::optional<std::size_t> reached(const Vector& state, std::vector<CellResidence>& residences) const;
  /// The known orbit of this period through the state, as far as two runs of Newton's method agree.
  std::optional<std::size_t> orbit_at(const Vector& state, int period) const;
  /// Whether a motion that returns to its state after `period` periods, nearly, may be on its way to a known orbit not far off;
  /// later, whether it was: that it has come closer is what proves it. (By 3/4 each time: where the tangent is far from normal
  /// that takes more than one.)
  std::optional<Nearing> nearing(const Vector& state, int period) const;
  bool has_come_closer(const Nearing& nearing, const Vector& state) const;
  /// Whether a known orbit is nearer than `distance`; `with_region`: of those that have a trapping region.
  bool orbit_near(const Vector& state, double distance, bool with_region) const;

 private:
  std::vector<KnownAttractor> list_;
};

}  // namespace graze
