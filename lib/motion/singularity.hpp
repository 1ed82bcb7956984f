// SPDX-License-Identifier: GPL-3.0-or-later
// Why a run of a system written as text could not be carried on: where one of its expressions stops being finite.
#pragma once

#include <graze/lib/equations/not_finite.hpp>
#include <graze/lib/motion/trajectory.hpp>

#include <optional>

namespace graze {

/// A part of the field, of a guard or of a derivative that is not finite where the run ended or right behind that, a divisor that
/// has changed its sign on the last stretch, or a reset. nullopt: nothing of the kind is seen.
std::optional<equations::EquationError> find_singularity(const equations::TextSystem& text, const Trajectory& run,
                                                         const Vector& p);

}  // namespace graze
