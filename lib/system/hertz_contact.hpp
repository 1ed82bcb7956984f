// SPDX-License-Identifier: GPL-3.0-or-later
// HertzContact: the equations of motion in a Hertz contact, as a structure of a mode (mode_structure.hpp).
#pragma once

#include <graze/lib/numerics/vector.hpp>

#include <array>
#include <cstddef>

namespace graze {

/// x'' = amplitude cos(frequency t) - 2 damping x' - x - beta x^3 - stiffness (x - barrier)^(3/2) (1 + contact_damping x')
/// for x >= barrier, integrated in the regularising variable y = sqrt(x - barrier), dt = y ds (DESIGN: "Hertz contact").
struct HertzContact {
  enum Coefficient : std::size_t { damping, beta, amplitude, frequency, barrier, stiffness, contact_damping, count };
  std::array<double, count> value{};
  /// d(value)/dp, 7 x (number of parameters).
  Matrix dp = {};
};

/// True if the parameter with this index is the barrier itself.
inline bool is_barrier(const HertzContact& contact, std::size_t parameter) {
  auto row = contact.dp.row(HertzContact::barrier);
  return row[static_cast<Eigen::Index>(parameter)] == 1.0 && (row.array() != 0.0).count() == 1;
}

}  // namespace graze
