// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of parameter maps: attractor types with a legend, or the first exponent.
#pragma once

#include <graze/apps/drawing/picture.hpp>
#include <graze/apps/map/map_file.hpp>

#include <string>
#include <vector>

namespace graze::apps {

/// `kind`: "attractors" (default) or "exponent"; `layers`: what --layer asked for, else the first four. A map of more points than
/// the picture has elements is drawn from every so-many-th of them. @throws std::invalid_argument for a kind or a layer there is
/// none of.
Picture picture_of_map(const MapPlan& plan, const MapRows& rows, const std::string& kind = {},
                       const std::vector<int>& layers = {});

/// What --layer says, once or several times. @throws std::invalid_argument if it is no whole number.
std::vector<int> layer_numbers(const std::vector<std::string>& texts);

/// Whether these can be drawn. @throws std::invalid_argument with one sentence if not.
void check_layers(const MapPlan& plan, const std::vector<int>& layers);

}  // namespace graze::apps
