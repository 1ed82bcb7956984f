// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/input_file.hpp>
#include <graze/apps/map_band.hpp>
#include <graze/apps/map_file.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace graze::apps {

using namespace hdf5;

namespace {

void read_part(hid_t dataset, hid_t type, const Band& band, bool of_states, void* data) {
  const std::vector<hsize_t> at = band.offset(of_states), size = band.size(of_states);
  const Handle memory = space_of(size), in_file(H5Dget_space(dataset), H5Sclose);
  check(H5Sselect_hyperslab(in_file, H5S_SELECT_SET, at.data(), nullptr, size.data(), nullptr));
  check(H5Dread(dataset, type, memory, in_file, H5P_DEFAULT, data));
}

bool begins_as_hdf5(const std::string& file) {
  char beginning[8] = {};
  std::ifstream(file, std::ios::binary).read(beginning, sizeof beginning);
  return std::string_view(beginning, sizeof beginning) == "\x89HDF\r\n\x1a\n";
}

/// Number of values along each axis; empty where it is no dataset.
std::vector<hsize_t> size_of(hid_t file, const char* name) {
  try {
    const Handle dataset(H5Dopen2(file, name, H5P_DEFAULT), H5Dclose), space(H5Dget_space(dataset), H5Sclose);
    std::vector<hsize_t> size(static_cast<std::size_t>(std::max(H5Sget_simple_extent_ndims(space), 0)));
    if (!size.empty()) check(H5Sget_simple_extent_dims(space, size.data(), nullptr));
    return size;
  } catch (const std::runtime_error&) {
    return {};
  }
}

std::string text_attribute(hid_t object, const char* name) {
  const Handle attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
  const Handle type(H5Aget_type(attribute), H5Tclose);
  if (H5Tis_variable_str(type) <= 0) throw std::runtime_error("another kind of attribute");
  char* characters = nullptr;
  check(H5Aread(attribute, type, &characters));
  std::string text = characters ? characters : "";
  H5free_memory(characters);
  return text;
}

}  // namespace

struct MapFile::Open {
  Handle file;
};

MapFile::MapFile(const std::string& file) : name_(file) {
  silence();
  if (!std::filesystem::is_regular_file(file)) read_whole(file);  // which says what is wrong with it
  try {
    open_ = std::make_unique<Open>(Open{Handle(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose)});
  } catch (const std::runtime_error&) {
    throw std::invalid_argument(file + (begins_as_hdf5(file) ? ": this HDF5 file is truncated or damaged; compute the map anew"
                                                             : ": this is not an HDF5 file"));
  }
  try {
    head_ = Json::parse(text_attribute(open_->file, "head"));
  } catch (const std::exception&) {
    throw std::invalid_argument(file + ": this HDF5 file is no result of graze map: it lacks its head");
  }
  try {
    plan_ = plan_of(head_);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("{}: {}", file, error.what()));
  }
  check_datasets();
}

MapFile::~MapFile() = default;
MapFile::MapFile(MapFile&&) noexcept = default;

std::invalid_argument MapFile::damaged(const std::string& dataset, const std::string& how) const {
  return std::invalid_argument(
      fmt::format("{}: this map is damaged: its dataset \"{}\" {}; compute the map anew", name_, dataset, how));
}

void MapFile::check_datasets() const {
  const Band all{0, plan_.grid.rows.count, plan_.layers(), plan_.grid.columns.count,
                 static_cast<int>(plan_.problem.system.states)};
  for (const Field& field : fields) {
    if (H5Lexists(open_->file, field.name, H5P_DEFAULT) <= 0) throw damaged(field.name, "is missing");
    const std::vector<hsize_t> size = size_of(open_->file, field.name), wanted = all.size(field.of_states);
    if (size != wanted)
      throw damaged(field.name,
                    fmt::format("has {} values and should have {}", fmt::join(size, " x "), fmt::join(wanted, " x ")));
  }
}

void MapFile::read(int first) {
  const int layers = plan_.layers(), columns = plan_.grid.columns.count, states = static_cast<int>(plan_.problem.system.states);
  const Band band{first, std::min(static_cast<int>(cell), plan_.grid.rows.count - first), layers, columns, states};
  BandData data(band);
  const Handle attractor = attractor_type();
  const std::array<void*, 6> memory = data.memory();
  const std::array<hid_t, 6> types = BandData::types(attractor);
  for (std::size_t i = 0; i < fields.size(); ++i) {
    try {
      const Handle dataset(H5Dopen2(open_->file, fields[i].name, H5P_DEFAULT), H5Dclose);
      read_part(dataset, types[i], band, fields[i].of_states, memory[i]);
    } catch (const std::runtime_error&) {
      throw damaged(fields[i].name, "cannot be read");
    }
  }
  for (const unsigned char type : data.type)
    if (type >= static_cast<unsigned char>(MapType::not_run))
      throw damaged("attractor", fmt::format("holds a {}, which stands for nothing", type));
  points_.clear();
  for (int row = 0; row < band.rows; ++row)
    for (int layer = 0; layer < layers; ++layer)
      for (int column = 0; column < columns; ++column)
        points_.push_back(data.get(band.place(layer, row, column), static_cast<std::size_t>(states)));
  band_ = first;
}

std::vector<MapPoint> MapFile::row(int number) {
  const int first = number / static_cast<int>(cell) * static_cast<int>(cell);
  if (first != band_) read(first);
  const std::ptrdiff_t size = static_cast<std::ptrdiff_t>(plan_.layers()) * plan_.grid.columns.count;
  const auto begin = points_.begin() + (number - first) * size;
  return {begin, begin + size};
}

}  // namespace graze::apps
