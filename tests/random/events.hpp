// SPDX-License-Identifier: GPL-3.0-or-later
// The events of an orbit that is given by its states at phase 0: each period is flown from its own state in closed form, sampled
// for passages of the barrier, and the impacts' phases and speeds are polished by Newton's method on the orbit's equations.
#pragma once

#include "answer.hpp"
#include "summits.hpp"

namespace graze::reference {

/// An orbit at the parameter y.back().
struct Orbit {
  Frame frame;
  Values<double> y;
};

/// The orbit at p with these states and that number of impacts: as its half if it is symmetric. Nothing if the flights do not
/// have them, or if the orbit's states differ from the given ones by more than `tolerance`.
std::optional<Orbit> events_of(Frame frame, int impacts, double p, const std::vector<State>& states, double tolerance);

/// An orbit of up to `most_periods` periods on which the motion from rest (at the stop, if that lies below 0) settles, with at
/// least one impact and up to `most_impacts`.
std::optional<Orbit> settled(const Frame& frame, double p, int most_periods, int most_impacts);

}  // namespace graze::reference
