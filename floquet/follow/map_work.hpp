// SPDX-License-Identifier: GPL-3.0-or-later
// MapWork: computes rows of a map on several threads. Its followed rows and independent points are rows of a RowRunner. They are
// given in pieces; the last points of a piece may take long and share the lanes with those of the next piece.
#pragma once

#include <graze/floquet/follow/map_chain.hpp>
#include <graze/floquet/follow/row_runner.hpp>

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace graze {

class MapWork {
 public:
  /// Receives a piece and its points, ordered by row, layer, column; called by any thread. Points not reached because of
  /// MapOptions::cancelled are not_run.
  using Done = std::function<void(int first, std::vector<MapPoint> points)>;

  /// `threads`: number of threads that will call work(). @throws as check_map.
  MapWork(const HybridSystem& system, const Vector& p, const ParameterGrid& grid, const std::vector<MapLayer>& layers,
          const MapOptions& options, int threads, Done done);
  MapWork(const MapWork&) = delete;
  MapWork& operator=(const MapWork&) = delete;

  /// Adds `count` rows from row `first` on. @throws std::invalid_argument if the map does not have them.
  void give(int first, int count);
  /// Whether more rows would give a thread something to do. It limits the open work to one piece more than there are threads,
  /// or to followed rows that fill the lanes twice, because open work is lost if the program is killed.
  bool wants_more() const;
  /// No more rows will follow: idle threads stop waiting.
  void close() { rows_.close(); }
  /// Run by each thread: works until it is closed and nothing is left to start. @throws the exception of a computation, and
  /// ends the other threads.
  void work() { rows_.work(); }

 private:
  /// Rows given in one call.
  struct Piece {
    Piece(int first_row, std::vector<MapPoint> all) : first(first_row), points(std::move(all)) {}
    int first;
    std::vector<MapPoint> points;
    std::atomic<std::size_t> left = 0;  ///< rows of the runner that are not finished
  };

  const std::shared_ptr<const MapSetting> map_;
  const std::size_t threads_;
  const Done done_;
  const bool followed_;                  ///< some layers are followed
  std::atomic<std::size_t> open_ = 0;    ///< rows of the runner that are not finished
  std::atomic<std::size_t> pieces_ = 0;  ///< pieces that are not finished
  RowRunner rows_;
};

}  // namespace graze
