// SPDX-License-Identifier: GPL-3.0-or-later
// The run of a parameter map over all threads of all ranks. Rank 0 gives chunks one by one to free ranks, itself included. The
// other ranks receive the plan from rank 0, read no file, and send back the bytes of their finished chunks, so that only rank 0
// needs a file system for the map. A rank that fails, or sends no message for two minutes, ends the run; finished chunks are
// kept.
#pragma once

#include <graze/apps/console/console.hpp>
#include <graze/apps/map/map_store.hpp>
#include <graze/apps/map/ranks.hpp>

#include <functional>
#include <string>

namespace graze::apps {

struct MapRun {
  Status status = Status::failed;
  std::string message;      ///< why the run ended early
  bool unwritable = false;  ///< a chunk or the result could not be written; in the first case the message says why
};

/// Rank 0's part: computes the chunks missing in the store, with `threads` threads on this rank. Once all chunks are present,
/// `write` writes the result (false: failed) before the other ranks are released: after their release mpirun may end the run if
/// a signal arrives late.
MapRun run_map(MapStore& store, const Json& head, Ranks& ranks, int threads, const Console& console,
               const std::function<bool()>& write);

/// The part of the other ranks. Returns the exit code.
int run_map_helper(Ranks& ranks, int threads);

/// Releases the other ranks if there is no work for them after all.
void dismiss(Ranks& ranks);

}  // namespace graze::apps
