// SPDX-License-Identifier: GPL-3.0-or-later
// The events of an orbit given by its states at phase 0. Each period is carried from its own state in closed form and sampled
// for passages of the barrier. Newton's method on the equations of the orbit then polishes the phases and speeds of the
// impacts.
#pragma once

#include "answer.hpp"
#include "summits.hpp"

namespace graze::reference {

/// An orbit at the parameter y.back().
struct Orbit {
  Frame frame;
  Values<double> y;
};

/// The orbit at p with these states and that number of impacts; a symmetric one is given by its half. Nothing if the flights
/// have other impacts, or if the states of the orbit differ from the given ones by more than `tolerance`.
std::optional<Orbit> events_of(Frame frame, int impacts, double p, const std::vector<State>& states, double tolerance);

/// An orbit of up to `most_periods` periods on which the motion from rest settles (from rest at the stop, if that lies below
/// 0). It has at least one impact and up to `most_impacts`.
std::optional<Orbit> settled(const Frame& frame, double p, int most_periods, int most_impacts);

}  // namespace graze::reference
