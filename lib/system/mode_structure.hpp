// SPDX-License-Identifier: GPL-3.0-or-later
// Known structure of a mode's equations, for which a faster exact flow exists.
//
// A mode may declare, for given parameter values, that its field is one of the structures below; make_flow then selects the
// flow made for it. A mode without a declared structure is integrated by the general integrator, which is also the reference
// for the other flows. All quantities are dimensionless; states are (x, v).
#pragma once

#include <graze/lib/numerics/vector.hpp>
#include <graze/lib/system/hertz_contact.hpp>

#include <array>
#include <functional>
#include <variant>
#include <vector>

namespace graze {

/// x'' + 2 damping x' + stiffness x = amplitude cos(frequency t) + constant, stiffness > 0: solved in closed form.
struct LinearOscillator {
  double damping = 0.0;
  double stiffness = 1.0;
  double amplitude = 0.0;
  double frequency = 1.0;
  double constant = 0.0;
  /// d(damping, stiffness, amplitude, frequency, constant)/dp, 5 x (number of parameters).
  Matrix dp;
  /// Parameters for which the closed form has no derivative (beta at beta = 0): a request for it selects the general flow.
  std::vector<std::size_t> not_differentiable_in;
};

/// x'' + 2 damping x' + stiffness x + cubic x^3 = amplitude cos(frequency t) + constant: integrated by Taylor series.
struct CubicOscillator {
  enum Coefficient : std::size_t { damping, stiffness, cubic, amplitude, frequency, constant, count };
  std::array<double, count> value{};
  /// d(value)/dp, 6 x (number of parameters).
  Matrix dp = {};
};

/// No known structure: the general integrator.
struct GeneralField {};

using ModeStructure = std::variant<GeneralField, LinearOscillator, CubicOscillator, HertzContact>;

/// The structure of a mode at given parameter values; an empty function means GeneralField.
using StructureAt = std::function<ModeStructure(const Vector& p)>;

}  // namespace graze
