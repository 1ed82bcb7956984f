// SPDX-License-Identifier: GPL-3.0-or-later
// The events of the contacts of mechanics, from mode to mode, and the surfaces that resets of the text may cross. Internal.
//
// Events of a rigid stop: the impact, its accumulation into the mode with the stop closed, and the release where gap'' > 0
// without the stop. An impulse that reaches a closed rigid stop through M opens it; friction then continues with the sign of
// its speed. Events of a stop with a force law: the contact begins and ends. Events of friction: its speed vanishes (it sticks
// if |lambda| is below the static limit, otherwise it slips the other way), and the multiplier reaches the limit.
#pragma once

#include <graze/lib/equations/contact_modes.hpp>

#include <vector>

namespace graze::equations {

/// Adds the events by which contact `c` leaves the mode `at`. Events refer to each other by their numbers in `events`.
void add_contact_events(const Coordinates& coordinates, const ContactModes& modes, const Combination& at, std::size_t c,
                        std::vector<EventPiece>& events);

/// Adds the constraints and surfaces of contact `c` that a reset of the text may leave or cross.
void add_contact_surfaces(const ContactModes& modes, const Combination& at, std::size_t c, std::vector<SurfacePiece>& surfaces);

}  // namespace graze::equations
