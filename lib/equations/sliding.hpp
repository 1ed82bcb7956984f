// SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces between two modes (Filippov), as sliding modes and events. Internal.
//
// On h(t, x) = 0 let r- and r+ be the rates of h in the modes below (h < 0) and above. Where r- > 0 > r+ both fields press the
// motion onto the surface; it then moves in the sliding mode with
//     f = (r- f+ - r+ f-) / (r- - r+),
// the combination of both that keeps h = 0. The motion leaves the mode downwards where r- falls through zero, and upwards where
// r+ rises through zero; there f equals the field of the mode entered. A motion that meets the surface passes through if the
// field on the other side does not press against it.
#pragma once

#include <graze/lib/equations/names.hpp>
#include <graze/lib/equations/pieces.hpp>

namespace graze::equations {

/// Adds the modes and events of the surfaces. @throws EquationError
void add_surfaces(Names& names, Pieces& pieces);

}  // namespace graze::equations
