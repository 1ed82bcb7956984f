// SPDX-License-Identifier: GPL-3.0-or-later
// MapColours: the colour of each point of a map and its entry in the legend: by attractor, by first exponent or by a quantity.
#pragma once

#include <graze/apps/drawing/picture.hpp>

#include <graze/floquet/follow/parameter_map.hpp>

#include <functional>
#include <string>
#include <vector>

namespace graze::apps {

struct MapColours {
  std::vector<std::string> colours;
  std::function<int(const MapPoint& point)> index;  ///< index of a point's colour; -1: white
  std::vector<Curve> legend;                        ///< entries for the classes that occur
  std::vector<ColourStop> scale;                    ///< of exponents or a quantity; empty: no point has a value
};

/// Colours by z = p/n: the most frequent z have colours of their own, in one hue per period; the others are coloured by period.
MapColours attractor_colours(const std::vector<MapPoint>& points);

/// A scale that is neutral at zero and warm above; -infinity and points without exponent have colours of their own.
MapColours exponent_colours(const std::vector<MapPoint>& points);

/// Colours of the quantity with index `place`, from dark to light.
MapColours quantity_colours(const std::vector<MapPoint>& points, Eigen::Index place);

}  // namespace graze::apps
