// SPDX-License-Identifier: GPL-3.0-or-later
// Mechanics as modes and events: M q'' + C q' + K q = force with stops and dry friction (system_text.hpp). Internal.
//
// Each stop is open, closed or apart (a force law that does not pull has ended, but the gap has not opened). Each friction
// slips forward, slips backward or sticks. Every combination is a mode (contact_modes.hpp), and its contacts have the events
// that lead to the others (contact_events.hpp).
#pragma once

#include <graze/lib/equations/names.hpp>
#include <graze/lib/equations/pieces.hpp>

namespace graze::equations {

/// The modes and events of the mechanics. @throws EquationError
Pieces make_mechanics(Names& names);

}  // namespace graze::equations
