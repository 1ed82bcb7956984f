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
  std::string quantity = {};     ///< of the map; empty: its first
  std::vector<int> layers = {};  ///< of --layer; empty: the first four
};

/// A map of more points than the picture has elements is drawn from every so-many-th of them. @throws std::invalid_argument for
/// a kind, a quantity or a layer that the map does not have.
Picture picture_of_map(const MapPlan& plan, const MapRows& rows, const MapView& view = {});

/// What --layer says, once or several times. @throws std::invalid_argument if it is no whole number.
std::vector<int> layer_numbers(const std::vector<std::string>& texts);

/// Whether these can be drawn. @throws std::invalid_argument with one sentence if not.
void check_layers(const MapPlan& plan, const std::vector<int>& layers);

}  // namespace graze::apps
