// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/follow/map_work.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace graze {

namespace {

bool is_followed(const MapLayer& layer) { return layer.follow != MapDirection::none; }

RowRunnerOptions running(const MapSetting& map, std::size_t threads) {
  RowRunnerOptions out;
  out.flow = map.options.flow;
  out.threads = threads;
  out.cancelled = map.options.cancelled;
  return out;
}

}  // namespace

MapWork::MapWork(const HybridSystem& system, const Vector& p, const ParameterGrid& grid, const std::vector<MapLayer>& layers,
                 const MapOptions& options, int threads, Done done)
    : map_(std::make_shared<const MapSetting>(map_setting(system, p, grid, layers, options))),
      threads_(static_cast<std::size_t>(std::max(1, threads))), done_(std::move(done)),
      followed_(std::any_of(layers.begin(), layers.end(), is_followed)), rows_(map_->system, running(*map_, threads_)) {}

void MapWork::give(int first, int count) {
  if (first < 0 || count < 0 || first > map_->grid.rows.count - count)
    throw std::invalid_argument(
        fmt::format("rows {} to {} were asked for; the map has {}", first, first + count - 1, map_->grid.rows.count));
  const std::size_t layers = map_->layers.size();
  const int columns = map_->grid.columns.count;
  const auto size = static_cast<std::size_t>(count) * layers * static_cast<std::size_t>(columns);
  const auto piece = std::make_shared<Piece>(first, std::vector<MapPoint>(size));
  std::vector<std::shared_ptr<Row>> rows;
  for (std::size_t k = 0; k < static_cast<std::size_t>(count) * layers; ++k) {
    MapPoint* const row = piece->points.data() + k * static_cast<std::size_t>(columns);
    const int together = is_followed(map_->layers[k % layers]) ? columns : 1;
    for (int column = 0; column < columns; column += together) {
      auto chain = std::make_unique<MapChain>(map_, k % layers, first + static_cast<int>(k / layers), column, together);
      Row::Listener listener;
      listener.commit = [this, row, chain = chain.get()](std::size_t number, const RowPoint& point) {
        row[chain->column(number)] = map_point(map_->system, point);
        if (map_->options.progress) map_->options.progress();
      };
      listener.finished = [this, piece] {
        --open_;
        if (--piece->left > 0) return;
        --pieces_;
        done_(piece->first, std::move(piece->points));
      };
      rows.push_back(std::make_shared<Row>(std::move(chain), std::move(listener), Row::usual_guesses(threads_)));
    }
  }
  piece->left = rows.size();
  open_ += rows.size();
  if (!rows.empty()) ++pieces_;
  rows_.give(rows);
}

bool MapWork::wants_more() const {
  const std::size_t enough = RowRunnerOptions{}.enough;
  return rows_.ready() < enough * threads_ && (pieces_ <= threads_ || (followed_ && open_ < 2 * enough * threads_));
}

}  // namespace graze
