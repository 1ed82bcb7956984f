// SPDX-License-Identifier: GPL-3.0-or-later
// The oscillators of which the lanes know the equations: in free flight linear and underdamped or a cantilever (beta x^3), before
// one barrier at the right, rigid with a coefficient of restitution, of Hertz's law, or linear elastic; whose forcing is not so
// slow (nor the stop so stiff) that, if linear, its period has more than `most_cells` cells.
#pragma once

#include <graze/lib/lanes/job.hpp>
#include <graze/lib/system/hybrid_system.hpp>

#include <memory>
#include <optional>

namespace graze::lanes {

inline constexpr double most_cells = 4000;

struct Oscillator {
  Law law = Law::restitution;
  bool cubic = false;
  Coefficients coefficients{};
  std::shared_ptr<const Grid> grid;  ///< none, if cubic
  Coefficients pressed{};            ///< with a linear elastic stop: in contact, of -x
  std::shared_ptr<const Grid> pressed_grid;
  std::size_t hit = 0;  ///< index of the event in which a contact begins

  /// Whether there are tables of its contacts.
  bool tabulated() const { return law == Law::hertz && !cubic; }
};

/// Whether the lanes know the system at these parameters.
bool lanes_know(const HybridSystem& system, const Vector& p);
/// nullopt: the lanes do not know the system at these parameters.
std::optional<Oscillator> lane_oscillator(const HybridSystem& system, const Vector& p);

}  // namespace graze::lanes
