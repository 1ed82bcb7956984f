// SPDX-License-Identifier: GPL-3.0-or-later
// Neighbourhood: what lies next to an orbit on its branch: the nearest special points either way, and where its first exponent
// takes a given value. It says how far a parameter would have to move for a figure to come out.
#pragma once

#include <graze/continuation/graph/continuation.hpp>

#include <optional>
#include <string>

namespace graze {

struct NeighbourhoodOptions {
  std::string parameter = "eta";
  double reach = 0.01;             ///< how far the branch is followed either way
  std::optional<double> exponent;  ///< the wanted value of the first exponent ln|mu_1| / (n T)
  std::function<bool()> cancelled = {};
};

struct Neighbourhood {
  /// The nearest bifurcation or grazing below and above the orbit's own value, on the orbit's branch.
  std::optional<SpecialPoint> below, above;
  /// The nearest value at which the stable orbit's first exponent is the wanted one, to about 1e-12; empty: none within reach.
  std::optional<double> value_of_exponent;

  /// The nearer of the two, if there is one.
  const SpecialPoint* nearest(double value) const;
};

/// @throws std::invalid_argument as continue_orbit does.
Neighbourhood neighbourhood(const HybridSystem& system, const PeriodicOrbit& orbit, const NeighbourhoodOptions& options);

}  // namespace graze
