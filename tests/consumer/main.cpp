// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/orbit/shooting.hpp>
#include <graze/lib/models/oscillator.hpp>

#include <cmath>

int main() {
  const graze::HybridSystem system = graze::make_oscillator("linear", "hertz");
  const graze::Vector p = graze::default_parameters(system.parameters);
  const graze::PeriodicOrbit orbit = graze::shoot(system, p, graze::Vector{{2.0, 1.5}}, 1);
  return orbit.converged() && orbit.stable() ? 0 : 1;
}
