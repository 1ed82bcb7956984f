// SPDX-License-Identifier: GPL-3.0-or-later
// A system written as text in a TOML file, read as the pieces that equations::make_system takes, each with its place in the
// file.
//
//   [system]         states = ["x", "v"], forcing = "eta" or period = "T" (neither: autonomous), name = "..."
//   [parameters]     eta = 0.8, r = "36/35", xi = "A*eta^2", b = { value = 0.05, min = 0, unit = "mm", meaning = "damping" }
//   [definitions]    spring = "x + x^3"
//   [modes.NAME]     equations = """ x' = v ... """
//   [[events]]       name, kind, from, to, when, reset, count
//   [mechanics]      coordinates, velocities, mass, damping, stiffness, force: instead of states and modes
//   [[stops]]        name, gap, law = { newton = "e" }, { hertz = ["k_H", "b_H"] }, { linear = ["k", "c"], adhesion = true },
//                    { force = "k*d^2*(1 + c*d')" }
//   [[friction]]     name, speed, normal, law, sticking
//   [[surfaces]]     function, below, above, sliding
//   [outputs]        energy = "v^2/2 + x^2/2"
//   [units]          x = "mm", energy = "J", t = "s": for axes
//   [start]          state = { x = 0.3, v = 0.1 } or [0.3, 0.1]; settle and period as in any problem file
//   [tables.NAME]    u = [...], y = [...], periodic = true or slopes = [first, last]
#pragma once

#include <graze/lib/equations/system_text.hpp>

#include <toml++/toml.h>

#include <string>

namespace graze::apps {

/// Whether a file describes its own system, rather than naming a built-in one.
bool has_system(const toml::table& root);

/// @throws EquationError with file, line and column for any entry that does not belong in such a file.
equations::SystemText read_system(const toml::table& root, equations::Source source);

}  // namespace graze::apps
