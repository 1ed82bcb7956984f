// SPDX-License-Identifier: GPL-3.0-or-later
// Basins: the coexisting attractors reached from many starts, and the attractor that each start reaches.
//
// A motion is carried period by period until it is inside the trapping region of a known orbit (trapping_region.hpp), has
// stayed among the cells of a known nonperiodic attractor (visited_cells.hpp), or is settling on an orbit that Newton's method
// finds (settling_orbit). If none of these happens during the transient, its exponents are averaged (find_attractor). Unless it
// settles meanwhile, it becomes an attractor of its own: chaotic, or undecided if its first exponent is not positive by several
// standard errors. Thus a chaotic transient is distinguished from chaos if it ends within `periods`.
//
// Starts are processed in rounds; the first rounds are small, and each is spread over all starts. All motions of a round use
// the same known attractors. The result is bitwise independent of the number of threads and of where a run was interrupted.
//
// The fraction f of N admissible starts has the standard error sqrt(f (1 - f) / N) of random starts. On a grid this is an
// overestimate, the more so the smoother the basin boundary; it does not describe how f depends on the chosen window. An
// attractor that no start reached has a fraction below 3 / N (at 95 %).
#pragma once

#include <graze/floquet/attractor/attractor.hpp>

#include <cstdint>
#include <functional>
#include <vector>

namespace graze {

struct BasinOptions {
  int transient = 1000;    ///< forcing periods in which a motion may be recognised without an average
  int max_period = 64;     ///< longest period recognised
  int periods = 20000;     ///< average over an unrecognised motion; also the number of states that define its cells
  int kept_states = 1000;  ///< states stored of a nonperiodic attractor
  int threads = 1;
  FlowOptions flow = {};
  std::function<bool()> cancelled = {};                                           ///< called every few periods, by all threads
  std::function<void(std::size_t starts, std::size_t attractors)> progress = {};  ///< called by one thread at a time
};

/// Outcome of a start.
enum class Fate : std::uint8_t {
  not_run,       ///< not run before the interruption
  reached,       ///< an attractor
  inadmissible,  ///< the start lies beyond a barrier
  lost           ///< the motion could not be continued, or there were too many attractors
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
  std::size_t admissible = 0;                   ///< starts that were run and are not beyond a barrier
  std::size_t lost = 0;
  std::int64_t periods = 0;  ///< forcing periods carried for the starts: the cost
  bool complete = false;     ///< all starts were run
};

/// The attractors of the starts (states at forcing phase 0, one per column). `so_far`: result of an interrupted run with the
/// same starts and options, which is continued. @throws std::invalid_argument for an autonomous system, starts of the wrong
/// size or none, options out of range, or a `so_far` of other starts.
Basins find_attractors(const HybridSystem& system, const Vector& p, const Matrix& starts, const BasinOptions& options = {},
                       const Basins& so_far = {});

/// Makes the checks of find_attractors alone: throws as it does, and computes nothing.
void check_basins(const HybridSystem& system, const Matrix& starts, const BasinOptions& options, const Basins& so_far = {});

}  // namespace graze
