// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of parameter maps: attractor types with a legend, the first exponent, or a quantity of --y.
#pragma once

#include <graze/apps/drawing/picture.hpp>
#include <graze/apps/map/map_file.hpp>

#include <string>
#include <vector>

namespace graze::apps {

struct MapView {
  std::string kind = {};         ///< "attractors" (default), "exponent" or "quantity"
  std::string quantity = {};     ///< a quantity of the map; empty: the first
  std::vector<int> layers = {};  ///< of --layer; empty: the first four
};

/// The picture of a map. A map with more points than the picture has pixels is drawn from every k-th point. @throws
/// std::invalid_argument for a kind, a quantity or a layer that the map does not have.
Picture picture_of_map(const MapPlan& plan, const MapRows& rows, const MapView& view = {});

/// The layers given by --layer, once or several times. @throws std::invalid_argument if one is not a whole number.
std::vector<int> layer_numbers(const std::vector<std::string>& texts);

/// @throws std::invalid_argument with one sentence if these layers cannot be drawn.
void check_layers(const MapPlan& plan, const std::vector<int>& layers);

}  // namespace graze::apps
