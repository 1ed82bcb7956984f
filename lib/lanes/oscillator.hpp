// SPDX-License-Identifier: GPL-3.0-or-later
// Recognises the oscillators that the lanes support, and computes their coefficients. In free flight an oscillator is linear
// and underdamped, or a cantilever (beta x^3). It has one barrier at its right: rigid with a coefficient of restitution, of
// Hertz's law, or linear elastic. A linear flight must not have more than `most_cells` cells in a period, which excludes slow
// forcing and stiff stops.
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
  std::shared_ptr<const Grid> grid;  ///< null if cubic
  Coefficients pressed{};            ///< coefficients of -x in contact with a linear elastic stop
  std::shared_ptr<const Grid> pressed_grid;
  std::size_t hit = 0;  ///< index of the event in which a contact begins

  /// Whether its contacts can be tabulated.
  bool tabulated() const { return law == Law::hertz && !cubic; }
};

/// Whether the lanes support the system at these parameters.
bool lanes_support(const HybridSystem& system, const Vector& p);
/// The oscillator of the system at these parameters. nullopt: the lanes do not support it.
std::optional<Oscillator> lane_oscillator(const HybridSystem& system, const Vector& p);

}  // namespace graze::lanes
