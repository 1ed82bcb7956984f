// SPDX-License-Identifier: GPL-3.0-or-later
// HertzContact: the equations of a passage through Hertz contact as a structure that a mode may have (mode_structure.hpp).
#pragma once

#include <array>
#include <cstddef>

namespace graze {

/// x'' = amplitude cos(frequency t) - 2 damping x' - x - beta x^3 - stiffness (x - barrier)^(3/2) (1 + contact_damping x')
/// for x >= barrier: carried in the regularising variable y = sqrt(x - barrier), dt = y ds (DESIGN: "Hertz contact").
struct HertzContact {
  enum Coefficient : std::size_t { damping, beta, amplitude, frequency, barrier, stiffness, contact_damping, count };
  std::array<double, count> value{};
  /// Index of the parameter that each coefficient is (they are plain parameters of the system).
  std::array<std::size_t, count> parameter{};
};

}  // namespace graze
