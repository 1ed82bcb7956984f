// SPDX-License-Identifier: GPL-3.0-or-later
// MapChain: how the points of a map are computed: those of a followed row, or one independent point. A point that is not on an
// orbit after its transient publishes its state before its average, which takes long.
#pragma once

#include <graze/floquet/follow/parameter_map.hpp>
#include <graze/floquet/follow/row.hpp>

#include <memory>
#include <utility>
#include <vector>

namespace graze {

/// Settings common to all points of a map.
struct MapSetting {
  SharedSystem system;
  Vector p;
  ParameterGrid grid;
  std::vector<MapLayer> layers;
  MapOptions options;
  Eigen::Index column_parameter = 0, row_parameter = 0;
  AttractorOptions from_start, from_neighbour;
};

/// @throws as check_map.
MapSetting map_setting(const HybridSystem& system, const Vector& p, const ParameterGrid& grid,
                       const std::vector<MapLayer>& layers, const MapOptions& options);

class MapChain : public RowChain {
 public:
  /// `count` points from column `column` on, in the direction of the layer.
  MapChain(std::shared_ptr<const MapSetting> map, std::size_t layer, int row, int column, int count)
      : map_(std::move(map)), layer_(layer), row_(row), column_(column), count_(count) {}

  /// Column of a point.
  int column(std::size_t number) const;

  std::size_t size() const override { return static_cast<std::size_t>(count_); }
  std::size_t stretch() const override;
  std::size_t many() const override;
  MotionTask<Found> find(TaskSlot& slot, Begin begin, std::function<bool()> cancelled,
                         std::function<void(const Vector& state)> publish) const override;

 private:
  const MapLayer& layer() const { return map_->layers[layer_]; }

  std::shared_ptr<const MapSetting> map_;
  std::size_t layer_;
  int row_, column_, count_;
};

/// The point of a map that a point of its row is.
MapPoint map_point(const HybridSystem& system, const RowPoint& point);

}  // namespace graze
