// SPDX-License-Identifier: GPL-3.0-or-later
// MapStore: the finished chunks of a map under way: small files in a folder, or, without a folder, in memory.
//
// The folder holds run.json (the head of the result, and rows per chunk) and one file per chunk. Each is written under a
// temporary name, synchronised, renamed, and the folder synchronised: whatever happens, a file is there whole or not at all. What
// is damaged nevertheless (its checksum says so) is computed again. One program at a time works in a folder: it holds the lock on
// the file `lock`.
#pragma once

#include <graze/apps/console/file_lock.hpp>
#include <graze/apps/map/map_chunk.hpp>

#include <optional>
#include <string>
#include <vector>

namespace graze::apps {

/// The parts of a map's head that its numbers depend on; see essence().
inline const std::vector<std::string> map_essentials = {"graze", "model", "parameters", "options"};

/// Another map that is there already is replaced on request alone.
enum class MapBeginning { anew, overwriting, resuming };

class MapStore {
 public:
  /// In memory. `advice`: what becomes of the chunks after an end before its time.
  MapStore(const MapPlan& plan, const Json& head, const std::string& advice);
  /// In `folder`/chunks. Resuming goes on with what an interrupted run of the same head has left there.
  /// @throws std::invalid_argument in one sentence: another run is or was there, or it is of other options, or at work now, or
  /// there is nothing to resume.
  MapStore(const MapPlan& plan, const Json& head, const std::string& folder, MapBeginning beginning);
  MapStore(const MapStore&) = delete;
  MapStore& operator=(const MapStore&) = delete;

  const MapPlan& plan() const { return plan_; }  ///< with the rows per chunk of the run that is resumed
  std::uint64_t fingerprint() const { return fingerprint_; }
  bool has(int number) const { return finished_[static_cast<std::size_t>(number)]; }
  std::vector<int> missing() const;
  int finished() const;
  int damaged() const { return damaged_; }  ///< chunk files that were there and could not be used

  /// What to do after an end before its time.
  std::string advice() const;

  /// Keeps a chunk. nullopt: done; else one sentence why not.
  std::optional<std::string> keep(int number, const std::string& bytes);
  /// One that was kept. @throws std::runtime_error if it cannot be read any more.
  MapChunk chunk(int number) const;
  /// Removes the folder of chunks: the result is there.
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
