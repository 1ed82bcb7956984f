// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of parameter maps: attractor types with a legend, or the first exponent.
#pragma once

#include <graze/apps/map_file.hpp>
#include <graze/apps/picture.hpp>

#include <string>

namespace graze::apps {

/// `kind`: "attractors" (default) or "exponent". A map of more points than the picture has elements is drawn from every
/// so-many-th of them. @throws std::invalid_argument for a kind there is none of.
Picture picture_of_map(const MapPlan& plan, const MapRows& rows, const std::string& kind = {});

}  // namespace graze::apps
