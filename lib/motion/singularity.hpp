// SPDX-License-Identifier: GPL-3.0-or-later
// Finds the expression of a text system that ends a run: it stops being finite, or the motion slides along its jump.
#pragma once

#include <graze/lib/equations/not_finite.hpp>
#include <graze/lib/motion/trajectory.hpp>

#include <optional>

namespace graze {

/// The part of the field, of a guard or of a derivative that is not finite at the end of the run or right after it, or a
/// divisor that changed its sign in the last stretch, or a reset that is not finite. nullopt: none found.
std::optional<equations::EquationError> find_singularity(const equations::TextSystem& text, const Trajectory& run,
                                                         const Vector& p);

/// A jump of sign or step along which the motion slides, if the run ended with events without end between its two sides.
std::optional<equations::EquationError> find_sliding(const equations::TextSystem& text, const Trajectory& run);

}  // namespace graze
