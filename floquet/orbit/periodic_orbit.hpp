// SPDX-License-Identifier: GPL-3.0-or-later
// PeriodicOrbit: one orbit with all computed properties.
#pragma once

#include <graze/floquet/orbit/multipliers.hpp>
#include <graze/floquet/orbit/signature.hpp>
#include <graze/lib/motion/trajectory.hpp>
#include <graze/lib/numerics/newton.hpp>

#include <optional>

namespace graze {

enum class Admissibility { not_checked, admissible, inadmissible };

/// A monodromy matrix by finite differences, compared with the variational one. Not applicable if every useful step leaves the
/// signature (at a grazing).
struct FiniteDifferenceCheck {
  bool applicable = false;
  double disagreement = 0.0;    ///< max|M - M_fd| / (1 + max|M|)
  double error_estimate = 0.0;  ///< of the Richardson extrapolation, on the same scale
  MonodromyMatrix monodromy;    ///< its factors by differences, one per stretch between nodes; empty if not applicable
};

/// Checks stored with an orbit; every number is a relative error.
struct OrbitChecks {
  double residual = -1.0;   ///< largest mismatch of the shooting stretches / (1 + |x|)
  double liouville = -1.0;  ///< |sum of ln|det| - Liouville's identity|; -1: not applicable (a factor of deficient rank)
  std::optional<FiniteDifferenceCheck> finite_difference;  ///< on request
};

struct PeriodicOrbit {
  Vector parameters;
  int period = 0;              ///< n forcing periods; autonomous: 1, or n returns (at_returns)
  double duration = 0.0;       ///< n T, dimensionless time
  Vector state;                ///< at forcing phase 0
  std::vector<Vector> states;  ///< at forcing phase 0 after 0 ... n - 1 periods; states[0] = state
  std::vector<Vector> nodes;   ///< shooting nodes, equally spaced in time from section_phase on
  double section_phase = 0.0;  ///< of nodes[0], forcing phase over 2 pi; also that of the monodromy matrix
  Signature signature;
  int impacts = 0;            ///< p of z = p/n
  int isolated_impacts = 0;   ///< without those of complete chatters, whose number depends on the definition
  bool rests = false;         ///< the mass is held at its stop all the time (lib/motion/rest.hpp)
  bool conservative = false;  ///< Liouville's sum is exactly zero along it
  NewtonReport newton;
  Admissibility admissible = Admissibility::not_checked;
  std::vector<EventRecord> events;  ///< along the orbit, with times from phase 0 to `duration`
  MonodromyMatrix monodromy;        ///< factors of M over the orbit
  FloquetMultipliers multipliers;
  OrbitChecks checks;

  bool converged() const { return newton.converged(); }
  bool stable() const { return multipliers.stable(); }
  /// Elliptic, at rest, or on the border of these, and conservative: it attracts nothing, and repels nothing.
  bool neutral() const { return conservative && multipliers.neutral(); }
};

}  // namespace graze
