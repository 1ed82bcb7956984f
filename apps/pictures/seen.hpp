// SPDX-License-Identifier: GPL-3.0-or-later
// A result as it is seen through one of its quantities (--y): its values stand where the first state did, so that every picture
// of states is one of quantities, too.
#pragma once

#include <graze/apps/pictures/pictures.hpp>

namespace graze::apps {

/// The member of such a result that names the quantity.
inline constexpr const char* seen_quantity = "seen_quantity";
/// And the number of the state in whose place it stands; not there: the first.
inline constexpr const char* seen_place = "seen_place";

/// Points of branches at which the quantity is not known are left out; the next one then has "after_gap". In a section the
/// quantity stands in the place of the second state. Of the events of a motion it is not known.
Json seen_through(const Json& result, const std::string& quantity);

/// The result with these of its quantities alone, in this order. @throws std::invalid_argument for one that it does not have.
Json with_quantities(Json result, const std::vector<std::string>& chosen);

/// The picture with the first quantity of the result, further ones below it; that of the states if it has none.
Picture draw_seen(const PictureKind& kind, const Json& result);

}  // namespace graze::apps
