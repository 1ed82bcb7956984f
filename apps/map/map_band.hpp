// SPDX-License-Identifier: GPL-3.0-or-later
// Band: rows of a map as they stand in its HDF5 file, so many at a time, in both directions.
#pragma once

#include <graze/apps/map/hdf5.hpp>

#include <graze/floquet/follow/parameter_map.hpp>

#include <algorithm>
#include <array>

namespace graze::apps::hdf5 {

constexpr hsize_t cell = 64;  // a chunk of the file is so many rows and columns, or all

/// One field of all points: how its numbers are put into memory, and how it is kept.
struct Field {
  const char* name;
  const char* meaning;
  bool of_states;
  std::size_t size;  ///< of a number, in bytes
};
constexpr std::array<Field, 6> fields = {
    Field{"attractor", "what the motion settles on", false, sizeof(unsigned char)},
    {"period", "n of z = p/n, in forcing periods; 0: not periodic", false, sizeof(int)},
    {"impacts", "p of z = p/n; 0 also where not periodic", false, sizeof(int)},
    {"lambda_1", "first Lyapunov exponent per unit of dimensionless time", false, sizeof(double)},
    {"standard_error", "of lambda_1; 0: exact, from the multipliers", false, sizeof(double)},
    {"state", "the states on the attractor at forcing phase 0", true, sizeof(double)}};

/// Places of the rows of a band: (layer, row, column) or (layer, row, column, component).
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
  /// A cell of the file has so many rows and columns, if this is the whole map.
  int cell_rows() const { return std::min(static_cast<int>(cell), rows); }
  int cell_columns() const { return std::min(static_cast<int>(cell), columns); }
  /// Index of a point in the dataset's own order, which has the layer first.
  std::size_t place(int layer, int row, int column) const {
    return (static_cast<std::size_t>(layer) * static_cast<std::size_t>(rows) + static_cast<std::size_t>(row)) *
               static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(column);
  }
};

/// The fields of a band as arrays, in both directions.
struct BandData {
  std::vector<unsigned char> type;
  std::vector<int> period, impacts;
  std::vector<double> lambda, error, state;
  explicit BandData(const Band& band)
      : type(band.points()), period(band.points()), impacts(band.points()), lambda(band.points()), error(band.points()),
        state(band.points() * static_cast<std::size_t>(band.states)) {}
  std::array<void*, 6> memory() {
    return {type.data(), period.data(), impacts.data(), lambda.data(), error.data(), state.data()};
  }
  static std::array<hid_t, 6> types(hid_t attractor) {
    return {attractor, H5T_NATIVE_INT, H5T_NATIVE_INT, H5T_NATIVE_DOUBLE, H5T_NATIVE_DOUBLE, H5T_NATIVE_DOUBLE};
  }
  void put(std::size_t i, const MapPoint& point) {
    type[i] = static_cast<unsigned char>(point.type);
    period[i] = point.period;
    impacts[i] = point.impacts;
    lambda[i] = point.lambda_1;
    error[i] = point.standard_error;
    const auto states = static_cast<std::size_t>(point.state.size());
    std::copy(point.state.begin(), point.state.end(), state.begin() + static_cast<std::ptrdiff_t>(i * states));
  }
  MapPoint get(std::size_t i, std::size_t states) const {
    MapPoint point;
    point.type = static_cast<MapType>(type[i]);
    point.period = period[i];
    point.impacts = impacts[i];
    point.lambda_1 = lambda[i];
    point.standard_error = error[i];
    point.state = Vector::Map(state.data() + i * states, static_cast<Eigen::Index>(states));
    return point;
  }
};

inline Handle attractor_type() {
  Handle type(H5Tenum_create(H5T_STD_U8LE), H5Tclose);
  for (unsigned char i = 0; i < static_cast<unsigned char>(MapType::not_run); ++i)
    check(H5Tenum_insert(type, map_type_name(static_cast<MapType>(i)).data(), &i));
  return type;
}

}  // namespace graze::apps::hdf5
