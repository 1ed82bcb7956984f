// SPDX-License-Identifier: GPL-3.0-or-later
// MapColours: the colour of each point of a map and its line in the legend, by attractor, by first exponent or by a quantity.
#pragma once

#include <graze/apps/drawing/picture.hpp>

#include <graze/floquet/follow/parameter_map.hpp>

#include <functional>
#include <string>
#include <vector>

namespace graze::apps {

struct MapColours {
  std::vector<std::string> colours;
  std::function<int(const MapPoint& point)> index;  ///< of its colour; -1: white
  std::vector<Curve> legend;                        ///< of what occurs
  std::vector<ColourStop> scale;                    ///< of exponents or a quantity; empty: no point has one
};

/// By z = p/n: the most frequent ones have colours of their own, in one hue for each period; the others are told by period.
MapColours attractor_colours(const std::vector<MapPoint>& points);

/// A scale that is neutral at zero and warm above it; -infinity and points without exponent have colours of their own.
MapColours exponent_colours(const std::vector<MapPoint>& points);

/// Of the quantity at this place, from dark to light.
MapColours quantity_colours(const std::vector<MapPoint>& points, Eigen::Index place);

}  // namespace graze::apps
