// SPDX-License-Identifier: GPL-3.0-or-later
// MapLanes: the threads of one process that compute chunks of a map and lay down their bytes. They work on the points of one
// chunk together, and go on to the next while the last of it take their time.
#pragma once

#include <graze/apps/map/map_chunk.hpp>

#include <graze/floquet/follow/map_work.hpp>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace graze::apps {

struct FinishedChunk {
  int number = 0;
  std::string bytes;
};

class MapLanes {
 public:
  MapLanes(const MapPlan& plan, std::uint64_t fingerprint, int threads);
  ~MapLanes();  ///< ends what is in work without its result
  MapLanes(const MapLanes&) = delete;
  MapLanes& operator=(const MapLanes&) = delete;

  void give(int number);
  /// Whether a thread would find something to do in one more chunk.
  bool wants_more() const { return work_.wants_more(); }
  /// No more will be given.
  void close() { work_.close(); }
  /// @throws std::runtime_error if the points of others could not be computed.
  std::optional<FinishedChunk> take();
  /// Returns when a chunk may be finished, or after this time.
  void wait(std::chrono::milliseconds longest);
  /// Points of chunks in work and finished here so far.
  std::size_t points() const { return points_; }
  /// What is in work is given up; nothing new begins.
  void stop();

 private:
  void finish(int first_row, std::vector<MapPoint> points);

  const MapPlan plan_;
  const std::uint64_t fingerprint_;
  std::atomic<bool> stopped_{false};
  std::atomic<std::size_t> points_{0};
  std::mutex mutex_;
  std::condition_variable done_;
  std::deque<FinishedChunk> finished_;
  std::string error_;
  MapWork work_;
  std::thread thread_;  // waits for all that work
};

}  // namespace graze::apps
