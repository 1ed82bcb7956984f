// SPDX-License-Identifier: GPL-3.0-or-later
// The run of a parameter map over all threads of all ranks. Rank 0 hands out chunks one by one to whoever is free, itself
// included; the other ranks are told the plan by it, read no file, and send the bytes of what they have finished back, so that
// only rank 0 needs a file system for the map. Any rank that fails, or is not heard of for two minutes, ends the run; what is
// finished is kept.
#pragma once

#include <graze/apps/console/console.hpp>
#include <graze/apps/map/map_store.hpp>
#include <graze/apps/map/ranks.hpp>

#include <functional>
#include <string>

namespace graze::apps {

struct MapRun {
  Status status = Status::failed;
  std::string message;      ///< why it ended before its end
  bool unwritable = false;  ///< the message is that of a chunk that could not be written, or the whole could not be
};

/// Rank 0's part: computes what is missing in the store. `threads`: of this rank. When all is there it is written by `write`
/// (false: it could not be) before the other ranks are let go: with them mpirun may end the run, if a signal comes late.
MapRun run_map(MapStore& store, const Json& head, Ranks& ranks, int threads, const Console& console,
               const std::function<bool()>& write);

/// The part of the other ranks. The exit code.
int help_with_map(Ranks& ranks, int threads);

/// Lets the other ranks go where there is nothing to do for them after all.
void dismiss(Ranks& ranks);

}  // namespace graze::apps
