// SPDX-License-Identifier: GPL-3.0-or-later
// The damped-Hertz oscillator of the published figures.
#pragma once

#include "support/checks.hpp"

#include <graze/lib/models/oscillator.hpp>

namespace graze::support {

inline const HybridSystem& damped_hertz() {
  static const HybridSystem system = make_oscillator("linear", "hertz");
  return system;
}

inline Vector hertz_parameters(double eta = 0.95, double r = 2.0) {
  return parameters(damped_hertz(), {{"b", 0.05}, {"eta", eta}, {"r", r}, {"k_H", 100.0}, {"b_H", 0.1}});
}

}  // namespace graze::support
