// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/interrupt.hpp>
#include <graze/apps/map_lanes.hpp>

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <exception>

namespace graze::apps {

MapLanes::MapLanes(const MapPlan& plan, std::uint64_t fingerprint, int threads)
    : plan_(plan), fingerprint_(fingerprint), threads_(threads) {
  plan_.options.cancelled = [this] { return stopped_ || interrupted(); };
  plan_.options.progress = [this] { ++points_; };
  thread_ = std::thread([this] {
    oneapi::tbb::task_arena arena(threads_);
    arena.execute([this] {
      oneapi::tbb::parallel_for(
          0, threads_, [this](int) { lane(); }, oneapi::tbb::simple_partitioner());
    });
  });
}

MapLanes::~MapLanes() {
  stop();
  thread_.join();
}

void MapLanes::give(int number) {
  const std::lock_guard lock(mutex_);
  todo_.push_back(number);
  given_.notify_one();
}

void MapLanes::close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  given_.notify_all();
}

int MapLanes::free() const {
  const std::lock_guard lock(mutex_);
  return threads_ - in_work_ - static_cast<int>(todo_.size());
}

std::optional<FinishedChunk> MapLanes::take() {
  const std::lock_guard lock(mutex_);
  if (finished_.empty()) return std::nullopt;
  FinishedChunk chunk = std::move(finished_.front());
  finished_.pop_front();
  return chunk;
}

void MapLanes::wait(std::chrono::milliseconds longest) {
  std::unique_lock lock(mutex_);
  done_.wait_for(lock, longest, [this] { return !finished_.empty(); });
}

void MapLanes::stop() {
  const std::lock_guard lock(mutex_);
  stopped_ = true;
  given_.notify_all();
}

void MapLanes::lane() {
  for (;;) {
    FinishedChunk result;
    {
      std::unique_lock lock(mutex_);
      given_.wait(lock, [this] { return stopped_ || closed_ || !todo_.empty(); });
      if (stopped_ || todo_.empty()) return;
      result.number = todo_.front();
      todo_.pop_front();
      ++in_work_;
    }
    try {
      if (const auto chunk = compute_chunk(plan_, result.number)) result.bytes = chunk_bytes(*chunk, plan_, fingerprint_);
    } catch (const std::exception& error) {
      result.error = error.what();
    }
    const std::lock_guard lock(mutex_);
    --in_work_;
    if (result.bytes.empty() && result.error.empty()) return;  // cancelled
    finished_.push_back(std::move(result));
    done_.notify_one();
  }
}

}  // namespace graze::apps
