// SPDX-License-Identifier: GPL-3.0-or-later
// A result with one of its quantities (--y) in the place of the first state, so that every picture of states can also show
// quantities.
#pragma once

#include <graze/apps/pictures/pictures.hpp>

namespace graze::apps {

/// The member of such a result that names the quantity.
inline constexpr const char* shown_quantity = "shown_quantity";
/// The member with the index of the state that the quantity replaces; absent: the first state.
inline constexpr const char* shown_place = "shown_place";

/// The result with the quantity in place of the state. Points of branches at which the quantity is unknown are left out; the
/// next point then has "after_gap". In a section the quantity replaces the second state. Events of a motion are removed: their
/// quantity is unknown.
Json with_quantity_as_state(const Json& result, const std::string& quantity);

/// The result with only these of its quantities, in this order. @throws std::invalid_argument for one that it does not have.
Json with_quantities(Json result, const std::vector<std::string>& chosen);

/// The picture with the first quantity of the result and further ones below it; the picture of the states if it has none.
Picture draw_shown(const PictureKind& kind, const Json& result);

}  // namespace graze::apps
