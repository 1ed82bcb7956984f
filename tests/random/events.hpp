// SPDX-License-Identifier: GPL-3.0-or-later
// The events of an orbit that is given by its states at phase 0: each period is flown from its own state in closed form, sampled
// for passages of the barrier, and the impacts' phases and speeds are polished by Newton's method on the orbit's equations.
#pragma once

#include "answer.hpp"
#include "summits.hpp"

namespace graze::reference {

/// y of the orbit at p. Nothing if the flights do not have `frame.impacts` impacts, or if the orbit's states differ from the
/// given ones by more than `tolerance`.
std::optional<Values<double>> events_of(const Frame& frame, double p, const std::vector<State>& states, double tolerance);

/// An orbit of up to `most_periods` periods on which the motion from rest (at the barrier, if that lies below 0) settles, with at
/// least one impact and up to `most_impacts`: its periods and impacts, and y.
struct Settled {
  int periods = 1, impacts = 1;
  Values<double> y;
};
std::optional<Settled> settled(const Frame& frame, double p, int most_periods, int most_impacts);

}  // namespace graze::reference
