// SPDX-License-Identifier: GPL-3.0-or-later
// MapStore: the finished chunks of a map in progress: small files in a folder or, without a folder, in memory.
//
// The folder holds run.json (the head of the result, and rows per chunk) and one file per chunk. Each file is written under a
// temporary name, synchronised and renamed, and then the folder is synchronised: after any crash a file is either complete or
// absent. A chunk that is damaged nevertheless (detected by its checksum) is computed again. Only one program at a time works
// in a folder: it holds the lock on the file `lock`.
#pragma once

#include <graze/apps/console/file_lock.hpp>
#include <graze/apps/map/map_chunk.hpp>

#include <optional>
#include <string>
#include <vector>

namespace graze::apps {

/// The parts of a map's head on which its numbers depend; see essence().
inline const std::vector<std::string> map_identity_parts = {"graze", "model", "parameters", "options"};

/// Only `overwriting` replaces another map that already exists.
enum class MapBeginning { anew, overwriting, resuming };

class MapStore {
 public:
  /// In memory. `advice`: tells the user the fate of the chunks if the run ends early.
  MapStore(const MapPlan& plan, const Json& head, const std::string& advice);
  /// In `folder`/chunks. Resuming continues from the chunks that an interrupted run of the same head has left there. @throws
  /// std::invalid_argument in one sentence: the folder holds another run or another map, the options differ, another program is
  /// at work there, or there is nothing to resume.
  MapStore(const MapPlan& plan, const Json& head, const std::string& folder, MapBeginning beginning);
  MapStore(const MapStore&) = delete;
  MapStore& operator=(const MapStore&) = delete;

  const MapPlan& plan() const { return plan_; }  ///< with the rows per chunk of the resumed run
  std::uint64_t fingerprint() const { return fingerprint_; }
  bool has(int number) const { return finished_[static_cast<std::size_t>(number)]; }
  std::vector<int> missing() const;
  int finished() const;
  int damaged() const { return damaged_; }  ///< chunk files that were present but unusable

  /// How to continue if the run ends early.
  std::string advice() const;

  /// Stores a chunk. nullopt: done; otherwise one sentence on the failure.
  std::optional<std::string> keep(int number, const std::string& bytes);
  /// A stored chunk. @throws std::runtime_error if it can no longer be read.
  MapChunk chunk(int number) const;
  /// Removes the folder of chunks, once the result is written.
  void remove();

 private:
  std::string file(int number) const;
  void begin(const Json& head, bool overwriting);
  void take_up(const Json& head);
  void lock();

  MapPlan plan_;
  std::uint64_t fingerprint_ = 0;
  std::string out_, folder_;  // empty: in memory
  std::string advice_;
  std::vector<std::string> kept_;
  std::vector<bool> finished_;
  int damaged_ = 0;
  std::optional<FileLock> lock_;
};

}  // namespace graze::apps
