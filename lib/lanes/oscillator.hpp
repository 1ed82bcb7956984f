// SPDX-License-Identifier: GPL-3.0-or-later
// The oscillators of which the lanes know the equations: linear and underdamped in free flight, before one barrier at the right,
// rigid with a coefficient of restitution or of Hertz's law.
#pragma once

#include <graze/lib/hybrid_system.hpp>
#include <graze/lib/lanes/job.hpp>

#include <optional>

namespace graze::lanes {

struct Oscillator {
  Law law = Law::restitution;
  Coefficients coefficients{};
  std::size_t hit = 0;             ///< index of the event in which a contact begins
  double log_volume_change = 0.0;  ///< ln|det S| of an impact

  /// ln|det Phi| of a period from Liouville's identity.
  double liouville(const Period& period) const {
    return period.divergence + (period.impacts > 0 && log_volume_change != 0.0 ? period.impacts * log_volume_change : 0.0);
  }
};

/// nullopt: the lanes do not know the system at these parameters.
std::optional<Oscillator> lane_oscillator(const HybridSystem& system, const Vector& p);

}  // namespace graze::lanes
