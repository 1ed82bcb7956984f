// SPDX-License-Identifier: GPL-3.0-or-later
// MapLanes: the threads of one process that compute chunks of a map: each takes a chunk, computes it, and lays down its bytes.
// Towards the end, where there are fewer chunks than threads, the free ones help with the points of the others' chunks.
#pragma once

#include <graze/apps/map_chunk.hpp>

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
  std::string bytes;  ///< empty: it could not be computed
  std::string error;  ///< then why not
};

class MapLanes {
 public:
  MapLanes(const MapPlan& plan, std::uint64_t fingerprint, int threads);
  ~MapLanes();  ///< ends what is in work without its result
  MapLanes(const MapLanes&) = delete;
  MapLanes& operator=(const MapLanes&) = delete;

  void give(int number);
  /// No more will be given: threads without a chunk help the others.
  void close();
  /// How many more chunks would find a thread.
  int free() const;
  std::optional<FinishedChunk> take();
  /// Returns when a chunk may be finished, or after this time.
  void wait(std::chrono::milliseconds longest);
  /// Points of chunks in work and finished here so far.
  std::size_t points() const { return points_; }
  /// What is in work is given up; nothing new begins.
  void stop();

 private:
  void lane();

  MapPlan plan_;
  std::uint64_t fingerprint_;
  int threads_;
  std::atomic<bool> stopped_{false};
  std::atomic<std::size_t> points_{0};
  mutable std::mutex mutex_;
  std::condition_variable given_, done_;
  std::deque<int> todo_;
  bool closed_ = false;
  std::deque<FinishedChunk> finished_;
  int in_work_ = 0;
  std::thread thread_;  // waits for all lanes
};

}  // namespace graze::apps
