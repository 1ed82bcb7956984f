// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/console/interrupt.hpp>
#include <graze/apps/map/map_threads.hpp>
#include <graze/lib/numerics/parallel.hpp>

#include <algorithm>
#include <exception>
#include <stdexcept>
#include <utility>

namespace graze::apps {

namespace {

MapOptions with(MapOptions options, std::function<bool()> cancelled, std::function<void()> progress) {
  options.cancelled = std::move(cancelled);
  options.progress = std::move(progress);
  return options;
}

}  // namespace

MapThreads::MapThreads(const MapPlan& plan, std::uint64_t fingerprint, int threads)
    : plan_(plan), fingerprint_(fingerprint),
      work_(plan_.problem.system, plan_.problem.parameters, plan_.grid, layers_of(plan_),
            with(
                plan_.options, [this] { return stopped_ || interrupted(); }, [this] { ++points_; }),
            threads, [this](int first_row, std::vector<MapPoint> points) { finish(first_row, std::move(points)); }) {
  thread_ = std::thread([this, threads] {
    try {
      in_parallel_on(threads, static_cast<std::size_t>(threads), [this](std::size_t) { work_.work(); });
    } catch (const std::exception& error) {
      const std::lock_guard lock(mutex_);
      error_ = std::string("points of the map could not be computed: ") + error.what();
    }
  });
}

MapThreads::~MapThreads() {
  stop();
  thread_.join();
}

void MapThreads::give(int number) { work_.give(plan_.first_row(number), plan_.rows_of(number)); }

std::optional<FinishedChunk> MapThreads::take() {
  const std::lock_guard lock(mutex_);
  if (finished_.empty() && !error_.empty()) throw std::runtime_error(error_);
  if (finished_.empty()) return std::nullopt;
  FinishedChunk chunk = std::move(finished_.front());
  finished_.pop_front();
  return chunk;
}

void MapThreads::wait(std::chrono::milliseconds longest) {
  std::unique_lock lock(mutex_);
  done_.wait_for(lock, longest, [this] { return !finished_.empty(); });
}

void MapThreads::stop() {
  stopped_ = true;
  close();
}

void MapThreads::finish(int first_row, std::vector<MapPoint> points) {
  const auto not_run = [](const MapPoint& point) { return point.type == MapType::not_run; };
  if (std::any_of(points.begin(), points.end(), not_run)) return;  // cancelled
  const int number = plan_.chunk_of(first_row);
  FinishedChunk chunk{number, chunk_bytes({first_row, plan_.rows_of(number), std::move(points)}, plan_, fingerprint_)};
  const std::lock_guard lock(mutex_);
  finished_.push_back(std::move(chunk));
  done_.notify_one();
}

}  // namespace graze::apps
