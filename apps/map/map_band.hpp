// SPDX-License-Identifier: GPL-3.0-or-later
// Band: consecutive rows of a map in the layout of its HDF5 file, for reading and writing.
#pragma once

#include <graze/apps/map/hdf5.hpp>
#include <graze/apps/map/map_columns.hpp>

#include <algorithm>
#include <string>
#include <vector>

namespace graze::apps::hdf5 {

constexpr hsize_t cell = 64;  // rows and columns of a chunk of the file, or all if there are fewer

/// Position of a band in the datasets: (layer, row, column) or (layer, row, column, component).
struct Band {
  int first = 0, rows = 0, layers = 0, columns = 0, states = 0;
  std::size_t points() const {
    return static_cast<std::size_t>(rows) * static_cast<std::size_t>(layers) * static_cast<std::size_t>(columns);
  }
  std::vector<hsize_t> offset(bool of_states) const {
    std::vector<hsize_t> at = {0, static_cast<hsize_t>(first), 0};
    if (of_states) at.push_back(0);
    return at;
  }
  std::vector<hsize_t> size(bool of_states) const {
    std::vector<hsize_t> all = {static_cast<hsize_t>(layers), static_cast<hsize_t>(rows), static_cast<hsize_t>(columns)};
    if (of_states) all.push_back(static_cast<hsize_t>(states));
    return all;
  }
  /// Rows and columns of a chunk of the file, if this band is the whole map.
  int cell_rows() const { return std::min(static_cast<int>(cell), rows); }
  int cell_columns() const { return std::min(static_cast<int>(cell), columns); }
  /// Index of a point in the dataset's own order, in which the layer comes first.
  std::size_t place(int layer, int row, int column) const {
    return (static_cast<std::size_t>(layer) * static_cast<std::size_t>(rows) + static_cast<std::size_t>(row)) *
               static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(column);
  }
};

/// The fields of a band, each as an array of numbers.
struct BandData {
  const std::vector<MapField>& fields;
  std::size_t states;
  std::vector<std::string> memory;  ///< one buffer per field
  /// `map_fields` must outlive the object.
  BandData(const Band& band, const std::vector<MapField>& map_fields)
      : fields(map_fields), states(static_cast<std::size_t>(band.states)) {
    for (const MapField& field : fields) memory.emplace_back(band.points() * field.bytes(states), '\0');
  }
  void put(std::size_t i, const MapPoint& point) {
    for (std::size_t k = 0; k < memory.size(); ++k) write_bytes(fields[k], point, &memory[k][i * fields[k].bytes(states)]);
  }
  MapPoint get(std::size_t i) const {
    MapPoint point;
    for (std::size_t k = 0; k < memory.size(); ++k) read_bytes(fields[k], &memory[k][i * fields[k].bytes(states)], states, point);
    return point;
  }
};

/// The HDF5 type of a field's numbers, in memory and in the file.
inline hid_t type_of(const MapField& field, hid_t attractor) {
  if (std::holds_alternative<MapType MapPoint::*>(field.member)) return attractor;
  return std::holds_alternative<int MapPoint::*>(field.member) ? H5T_NATIVE_INT : H5T_NATIVE_DOUBLE;
}

inline Handle attractor_type() {
  Handle type(H5Tenum_create(H5T_STD_U8LE), H5Tclose);
  for (unsigned char i = 0; i < static_cast<unsigned char>(MapType::not_run); ++i)
    check(H5Tenum_insert(type, map_type_name(static_cast<MapType>(i)).data(), &i));
  return type;
}

}  // namespace graze::apps::hdf5
