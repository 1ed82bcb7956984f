// SPDX-License-Identifier: GPL-3.0-or-later
// Basins: the attractors that coexist, met from many starts, and which start leads to which.
//
// A motion is carried on, period by period, until it is inside the trapping region of a known orbit (trapping_region.hpp), has
// stayed among the cells of a known attractor that is not periodic (visited_cells.hpp), or is settling on an orbit that Newton's
// method finds (settling_orbit). What has done none of this after the transient is averaged for exponents (find_attractor) and
// becomes an attractor of its own unless it settles meanwhile: chaotic, or undecided if its first exponent is not positive by
// several standard errors. A chaotic transient is thus told from chaos as far as `periods` reach.
//
// Starts are taken in rounds, the first ones small and spread over all starts; what is known is the same for all motions of a
// round. The result does not depend on the number of threads, nor on where a run was interrupted, to the last bit.
//
// The fraction f of N admissible starts has the standard error sqrt(f (1 - f) / N): that of random starts. On a grid it is rather
// too large, the more so the smoother the border between the basins; it does not tell how f changes with the window chosen. What
// no start met has a fraction below 3 / N (at 95 %).
#pragma once

#include <graze/floquet/attractor/attractor.hpp>

#include <cstdint>
#include <functional>
#include <vector>

namespace graze {

struct BasinOptions {
  int transient = 1000;    ///< forcing periods in which a motion may be recognised without an average
  int max_period = 64;     ///< longest period that is recognised
  int periods = 20000;     ///< of the average over a motion that is not recognised; as many states then say what it covers
  int kept_states = 1000;  ///< states given of an attractor that is not periodic
  int threads = 1;
  FlowOptions flow = {};
  std::function<bool()> cancelled = {};                                           ///< asked every few periods, by all threads
  std::function<void(std::size_t starts, std::size_t attractors)> progress = {};  ///< by one thread at a time
};

/// What became of a start.
enum class Fate : std::uint8_t {
  not_run,       ///< interrupted before
  reached,       ///< an attractor
  inadmissible,  ///< it lies beyond a barrier
  lost           ///< the motion could not be carried on, or there were too many attractors
};

struct StartOutcome {
  Fate fate = Fate::not_run;
  std::uint32_t attractor = 0;  ///< index in Basins::attractors, if reached
  bool operator==(const StartOutcome&) const = default;
};

struct CoexistingAttractor {
  Attractor attractor;
  std::vector<Vector> states;  ///< at forcing phase 0: those of the orbit, or BasinOptions::kept_states of them
  std::size_t count = 0;       ///< starts that reach it
  double fraction = 0.0;       ///< of the admissible starts that were run
  double fraction_error = 0.0;
};

struct Basins {
  std::vector<CoexistingAttractor> attractors;  ///< largest basin first
  std::vector<StartOutcome> outcomes;           ///< of each start, in their order
  std::size_t admissible = 0;                   ///< starts that were run and lie in front of every barrier
  std::size_t lost = 0;
  std::int64_t periods = 0;  ///< forcing periods carried out for the starts: what it cost
  bool complete = false;     ///< all starts were run
};

/// The attractors of the starts (states at forcing phase 0, a column each). `so_far`: the result of a run of the same starts and
/// options that was interrupted, which is gone on with. @throws std::invalid_argument for an autonomous system, starts of the
/// wrong size or none, options out of range, or a `so_far` of other starts.
Basins find_attractors(const HybridSystem& system, const Vector& p, const Matrix& starts, const BasinOptions& options = {},
                       const Basins& so_far = {});

/// Checks what find_attractors throws for, without computing anything.
void check_basins(const HybridSystem& system, const Matrix& starts, const BasinOptions& options, const Basins& so_far = {});

}  // namespace graze
