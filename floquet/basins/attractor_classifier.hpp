// SPDX-License-Identifier: GPL-3.0-or-later
// AttractorClassifier: recognises the attractors found so far, so that a motion need not be carried to its end: by the trapping
// region of a stable orbit, or by the visited cells of a nonperiodic attractor.
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

/// A motion that may be approaching a known orbit.
struct ApproachTest {
  std::size_t attractor = 0;
  double distance = 0.0;
  double periods = 0.0;  ///< time in which the orbit's slowest multiplier halves a distance
  int times = 1;         ///< the next test comes after this many such times
};

class AttractorClassifier {
 public:
  std::size_t size() const { return list_.size(); }
  const KnownAttractor& operator[](std::size_t i) const { return list_[i]; }
  void add(KnownAttractor known) { list_.push_back(std::move(known)); }
  /// Keeps the first `count` attractors.
  void keep(std::size_t count) { list_.resize(count); }

  /// The residence tests of a new motion: one for each attractor, up to the last nonperiodic one.
  std::vector<CellResidence> residences() const;

  /// The trapping regions of the periodic attractors, for motions of two states.
  std::vector<StateEllipse> ellipses() const;
  /// The attractor that a motion has reached with its next state; `residences`: those of this motion.
  std::optional<std::size_t> reached(const Vector& state, std::vector<CellResidence>& residences) const;
  /// The known orbit of this period through `state`, within the agreement of two runs of Newton's method.
  std::optional<std::size_t> orbit_at(const Vector& state, int period) const;
  /// A known orbit not far away that a motion may be approaching if it nearly returns to `state` after `period` periods. The
  /// later test has_come_closer decides, as DistanceWatch does for a new orbit.
  std::optional<ApproachTest> nearing(const Vector& state, int period) const;
  bool has_come_closer(const ApproachTest& nearing, const Vector& state) const;
  /// Whether a known orbit is nearer than `distance`; `with_region`: only orbits that have a trapping region.
  bool orbit_near(const Vector& state, double distance, bool with_region) const;

 private:
  std::vector<KnownAttractor> list_;
};

}  // namespace graze
