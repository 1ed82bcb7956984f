// SPDX-License-Identifier: GPL-3.0-or-later
// The least period of an orbit found by Newton's method. An orbit of n periods (forcing periods, or returns of an autonomous
// motion) that nearly closes after a divisor d of n may be one of period d. Near a period doubling the doubled orbit passes close
// to its own start without closing there. Therefore Newton's method is run again with d periods, and the orbit is replaced if
// both runs have found the same state.
#pragma once

#include <graze/floquet/orbit/state_distance.hpp>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <vector>

namespace graze {

/// The divisors of the number of states after which an orbit with these states nearly closes, by increasing size.
inline std::vector<std::size_t> shorter_periods(const std::vector<Vector>& states) {
  constexpr double nearly = 1e-5;  // relative to 1 + |x|
  const std::size_t n = states.size();
  std::vector<std::size_t> out;
  for (std::size_t d = 1; d <= n / 2; ++d)
    if (n % d == 0 && state_distance(states[d], states[0]) <= nearly * (1.0 + state_size(states[0]))) out.push_back(d);
  return out;
}

/// Newton's guess for the orbit of `shorter` periods: the first states of the longer one, which begin midway between the two that
/// should be one.
inline std::vector<Vector> guess_of_shorter(const std::vector<Vector>& states, std::size_t shorter) {
  std::vector<Vector> out(states.begin(), states.begin() + static_cast<std::ptrdiff_t>(shorter));
  out.front() = weighted(0.5, states[0], 0.5, states[shorter]);
  return out;
}

/// Whether an orbit is the one with these multipliers, run through `times` times, if the two runs of Newton's method have found
/// the state x at this distance from each other. Newton's error is rounding divided by the distance of the multipliers from 1:
/// near a bifurcation it is not small.
inline bool is_repeated(const std::vector<std::complex<double>>& multipliers, std::size_t times, double distance,
                        double size_of_x) {
  constexpr double rounding = 1e-12, least = 1e-10, most = 1e-6;
  double nearest = 1.0;
  for (const std::complex<double>& mu : multipliers)
    nearest = std::min(nearest, std::abs(1.0 - std::pow(mu, static_cast<double>(times))));
  return distance < std::clamp(rounding / nearest, least, most) * (1.0 + size_of_x);
}

}  // namespace graze
