// SPDX-License-Identifier: GPL-3.0-or-later
// MapFile: the result of `graze map` as HDF5 (schema graze.map/1), readable by h5py and MATLAB:
//     <columns>, <rows>, layer, component      the axes, as dimension scales; the first two have their parameters' names
//     attractor (layer, rows, columns)         enumeration: undecided, periodic, chaotic, inadmissible, lost
//     period, impacts                          n and p of z = p/n if periodic, otherwise 0
//     lambda_1, standard_error                 NaN if unknown; the error is 0 if periodic
//     state (.., component)                    on the attractor, at forcing phase 0
//     start (layer, component), follow (layer) origin of each layer; a start from rest is NaN
//     y/<quantity>                             quantities of --y, if any; NaN if unknown
//     parameters                               a group with one attribute per parameter
// Attributes of the file: schema, graze (version), oscillator, contact, options and head (both JSON), units. The file holds no
// time stamps, so that the same map is the same file, byte by byte. The file is built in memory and written like any other
// output, because the HDF5 library cannot recover from a full disc.
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

/// Builds the file in memory, compressed on `threads` threads, and writes it completely or not at all. Requests each row once,
/// in order. nullopt: done; otherwise one sentence on the failure.
std::optional<std::string> write_map_file(const std::string& file, const MapPlan& plan, const Json& head, const MapRows& rows,
                                          int threads);

/// A map written earlier.
class MapFile {
 public:
  /// @throws std::invalid_argument if the file cannot be read, is not a map, or lacks a dataset.
  explicit MapFile(const std::string& file);
  ~MapFile();
  MapFile(MapFile&&) noexcept;
  MapFile& operator=(MapFile&&) = delete;

  const Json& head() const { return head_; }
  const MapPlan& plan() const { return plan_; }
  /// The points of one row, by layer and column. Reads bands of rows; fast if rows are requested in order. @throws
  /// std::invalid_argument naming the dataset that cannot be read or holds invalid values.
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
  int band_ = -1;                 // index of the band in `points_`
  std::vector<MapPoint> points_;  // by row, layer, column
};

}  // namespace graze::apps
