// SPDX-License-Identifier: GPL-3.0-or-later
// Newton guesses next to a period doubling, from the states at forcing phase 0 of a motion that nearly returns after an even
// number of periods. Before the doubling, Newton's method fails for the doubled orbit, because its equations are nearly
// singular there, but not for the simple orbit. Beyond the doubling, it may converge from states around the doubled orbit to
// the simple one, which is then unstable.
#pragma once

#include <graze/floquet/orbit/state_distance.hpp>

#include <cmath>
#include <complex>
#include <cstddef>
#include <vector>

namespace graze {

/// The midpoints of corresponding states of the two halves, if these are close (`near`: relative to 1 + |x|); otherwise empty.
inline std::vector<Vector> between_halves(const std::vector<Vector>& states, double near) {
  const std::size_t half = states.size() / 2;
  if (states.size() % 2 != 0) return {};
  std::vector<Vector> out;
  for (std::size_t k = 0; k < half; ++k) {
    if (state_distance(states[k], states[k + half]) > near * (1.0 + state_size(states[k]))) return {};
    out.push_back(weighted(0.5, states[k], 0.5, states[k + half]));
  }
  return out;
}

/// Whether the orbit found from a return after `returned_after` periods has half that period and, by its first multiplier, lies
/// shortly beyond a period doubling.
inline bool has_doubled(std::size_t period, std::complex<double> mu, std::size_t returned_after) {
  constexpr double far_off = 0.2;
  return 2 * period == returned_after && mu.imag() == 0.0 && mu.real() < -1.0 && mu.real() > -1.0 - far_off;
}

/// Guess for the doubled orbit around a simple one of period n with states `single` and first multiplier mu. It keeps the shape
/// of the motion and scales its distance a from `single` by one factor. Next to the doubling, 2 n periods multiply a by mu^2 -
/// c a^2 (normal form; Kuznetsov, Elements of Applied Bifurcation Theory, 3rd ed., sec. 4.4). This is 1 on the doubled orbit;
/// the growth of the motion's own a gives c. `motion`: its states after 0 to 3 n periods. Empty if there is no useful guess.
inline std::vector<Vector> doubled_states(const std::vector<Vector>& single, double mu, const std::vector<Vector>& motion) {
  constexpr double most_times = 20.0;
  const std::size_t n = single.size();
  const auto across = [&](std::size_t k) { return weighted(0.5, motion[k], -0.5, motion[k + n]); };
  const double factor = std::sqrt((mu * mu - 1.0) / (mu * mu - state_size(across(2 * n)) / state_size(across(0))));
  if (!(factor < most_times && factor > 1.0 / most_times)) return {};
  std::vector<Vector> out;
  for (const double side : {factor, -factor})
    for (std::size_t k = 0; k < n; ++k) out.push_back(weighted(1.0, single[k], side, across(k)));
  return out;
}

}  // namespace graze
