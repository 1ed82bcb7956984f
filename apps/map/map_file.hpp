// SPDX-License-Identifier: GPL-3.0-or-later
// MapFile: the result of `graze map` as HDF5 (schema graze.map/1), which h5py and MATLAB read:
//     <columns>, <rows>, layer, component      the axes, as dimension scales; the first two bear their parameters' names
//     attractor (layer, rows, columns)         enumeration: undecided, periodic, chaotic, inadmissible, lost
//     period, impacts                          n and p of z = p/n where periodic, else 0
//     lambda_1, standard_error                 NaN where there is none, error 0 where periodic
//     state (.., component)                    on the attractor, at forcing phase 0
//     start (layer, component), follow (layer) how each layer came about; a start is NaN where it was at rest
//     parameters                               a group with an attribute for each
// Attributes of the file: schema, graze (version), oscillator, contact, options and head (both JSON), units. It holds no times of
// any kind, so that the same map is the same file, byte by byte. It is put together in memory and written as any other output:
// the HDF5 library cannot recover from a full disc.
#pragma once

#include <graze/apps/map/map_plan.hpp>

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace graze::apps {

/// The points of one row, by layer and column.
using MapRows = std::function<std::vector<MapPoint>(int row)>;

/// Puts the file together in memory, compressed on so many threads, and writes it whole or not at all. Asks for each row once, in
/// order. nullopt: done; else one sentence why not.
std::optional<std::string> write_map_file(const std::string& file, const MapPlan& plan, const Json& head, const MapRows& rows,
                                          int threads);

/// A map that was written before.
class MapFile {
 public:
  /// @throws std::invalid_argument if it cannot be read, is no map, or lacks a dataset.
  explicit MapFile(const std::string& file);
  ~MapFile();
  MapFile(MapFile&&) noexcept;
  MapFile& operator=(MapFile&&) = delete;

  const Json& head() const { return head_; }
  const MapPlan& plan() const { return plan_; }
  /// Reads bands of rows, and is fast where rows are asked for in order.
  /// @throws std::invalid_argument that names the dataset which cannot be read or holds what it should not.
  std::vector<MapPoint> row(int number);

 private:
  struct Open;
  std::invalid_argument damaged(const std::string& dataset, const std::string& how) const;
  void check_datasets() const;
  void read(int first);

  std::string name_;
  std::unique_ptr<Open> open_;
  Json head_;
  MapPlan plan_;
  int band_ = -1;                 // of the rows held
  std::vector<MapPoint> points_;  // by row, layer, column
};

}  // namespace graze::apps
