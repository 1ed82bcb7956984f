// SPDX-License-Identifier: GPL-3.0-or-later
// Neighbourhood of an orbit on its branch: the nearest special points in both directions, and the parameter value at which the
// first exponent has a given value. It shows how far a parameter would have to move to reproduce a figure.
#pragma once

#include <graze/continuation/graph/continuation.hpp>

#include <optional>
#include <string>

namespace graze {

struct NeighbourhoodOptions {
  std::string parameter = "eta";
  double reach = 0.01;             ///< distance to which the branch is followed in each direction
  std::optional<double> exponent;  ///< the wanted value of the first exponent ln|mu_1| / (n T)
  std::function<bool()> cancelled = {};
};

struct NearestSpecialPoints {
  /// The nearest bifurcation or grazing below and above the orbit's own value, on the orbit's branch.
  std::optional<SpecialPoint> below, above;
  /// The nearest parameter value at which the stable orbit's first exponent is the wanted one, to about 1e-12; empty if there
  /// is none within reach.
  std::optional<double> value_of_exponent;

  /// The nearer of `below` and `above`; null if there is neither.
  const SpecialPoint* nearest(double value) const;
};

/// The neighbourhood of `orbit`. @throws std::invalid_argument as continue_orbit does.
NearestSpecialPoints nearest_special_points(const HybridSystem& system, const PeriodicOrbit& orbit,
                                            const NeighbourhoodOptions& options);

}  // namespace graze
