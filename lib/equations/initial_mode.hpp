// SPDX-License-Identifier: GPL-3.0-or-later
// The mode of a state, from the guards, constraints and conditions of the modes.
#pragma once

#include <graze/lib/system/hybrid_system.hpp>

#include <vector>

namespace graze::equations {

/// A state lies on the constraint of a sticking or sliding mode within this tolerance, relative to 1 + |x|: the drift of
/// integration along a moving or curved constraint over many periods.
inline constexpr double constraint_tolerance = 1e-10;

/// A constraint of a mode and its tolerance, relative to 1 + |x|.
struct ToleratedConstraint {
  ScalarFunction value;
  double tolerance = constraint_tolerance;
};

/// Determines the mode of a state from the guards of each mode (see system_text.hpp), its constraints, and the conditions that
/// are not negative in it.
InitialMode mode_by_guards(const HybridSystem& system, const std::vector<std::vector<ToleratedConstraint>>& constraints,
                           const std::vector<std::vector<ScalarFunction>>& conditions);

}  // namespace graze::equations
