// SPDX-License-Identifier: GPL-3.0-or-later
// Result of a forcing period in a lane, and the test whether it ended in an ellipse of the job.
#pragma once

#include <graze/lib/lanes/memory.hpp>

#include <cstdint>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

/// Stores the result of a lane's period, which ended at (x, v).
template <class Real, bool Tangent>
void write_period(const Memory<Real>& m, std::size_t lane, double x, double v, Period& result) {
  result.x = x;
  result.v = v;
  const double impacts = m.field[impact_count][lane];
  if constexpr (Tangent) {
    for (std::size_t i = 0; i < 4; ++i) result.Phi[i] = m.field[phi_00 + i][lane];
    result.det = m.field[det][lane];
    const double of_impacts = impacts > 0.0 ? impacts * m.coefficient[rebound_volume][lane] : 0.0;
    result.liouville = m.field[divergence][lane] + of_impacts;
  }
  result.impacts = static_cast<std::int32_t>(impacts);
  result.termination = Termination::time;
  result.by_propagator = false;
}

/// Lanes whose state is in an ellipse of the job.
template <class Real> Mask<Real> in_ellipses(const Job& job, const Real& x, const Real& v) {
  Mask<Real> in = mask_of<Real>(0);
  for (std::size_t i = 0; i < job.ellipse_count; ++i) {
    const Ellipse& e = job.ellipses[i];
    const Real d = x - e.x0, d_v = v - e.v0;
    in = in | (d * (e.xx * d + e.xv * d_v) + e.vv * (d_v * d_v) <= Real(1.0));
  }
  return in;
}

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
