// SPDX-License-Identifier: GPL-3.0-or-later
// MapThreads: the threads of one process that compute chunks of a map and store their bytes. They share the points of one
// chunk, and go on to the next chunk while the last points of this one are still running.
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

class MapThreads {
 public:
  MapThreads(const MapPlan& plan, std::uint64_t fingerprint, int threads);
  ~MapThreads();  ///< cancels the work in progress, without results
  MapThreads(const MapThreads&) = delete;
  MapThreads& operator=(const MapThreads&) = delete;

  void give(int number);
  /// Whether one more chunk would give work to an idle thread.
  bool wants_more() const { return work_.wants_more(); }
  /// No more chunks will be given.
  void close() { work_.close(); }
  /// A finished chunk, if there is one. @throws std::runtime_error if points of other chunks could not be computed.
  std::optional<FinishedChunk> take();
  /// Returns when a chunk may be finished, or after `longest`.
  void wait(std::chrono::milliseconds longest);
  /// Number of points computed so far, in unfinished and finished chunks.
  std::size_t points() const { return points_; }
  /// Cancels the work in progress; nothing new begins.
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
  std::thread thread_;  // waits for the work to end
};

}  // namespace graze::apps
