// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/input_file.hpp>
#include <graze/apps/map_band.hpp>
#include <graze/apps/map_file.hpp>

#include <algorithm>
#include <filesystem>
#include <stdexcept>

namespace graze::apps {

using namespace hdf5;

namespace {

herr_t read_part(hid_t dataset, hid_t type, hid_t memory, hid_t file, void* data) {
  return H5Dread(dataset, type, memory, file, H5P_DEFAULT, data);
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

MapFile::MapFile(const std::string& file) {
  silence();
  if (!std::filesystem::is_regular_file(file)) read_whole(file);  // which says what is wrong with it
  try {
    open_ = std::make_unique<Open>(Open{Handle(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose)});
  } catch (const std::runtime_error&) {
    throw std::invalid_argument(file + ": this is not an HDF5 file");
  }
  try {
    head_ = Json::parse(text_attribute(open_->file, "head"));
  } catch (const std::exception&) {
    throw std::invalid_argument(file + ": this HDF5 file is no result of graze map: it lacks its head");
  }
  plan_ = plan_of(head_);
}

MapFile::~MapFile() = default;
MapFile::MapFile(MapFile&&) noexcept = default;

std::vector<MapPoint> MapFile::row(int number) {
  const int first = number / static_cast<int>(cell) * static_cast<int>(cell), layers = plan_.layers(),
            columns = plan_.grid.columns.count, states = static_cast<int>(plan_.problem.system.states);
  if (first != band_) {
    const Band band{first, std::min(static_cast<int>(cell), plan_.grid.rows.count - first), layers, columns, states};
    BandData data(band);
    const Handle attractor = attractor_type();
    const std::array<void*, 6> memory = data.memory();
    const std::array<hid_t, 6> types = BandData::types(attractor);
    try {
      for (std::size_t i = 0; i < fields.size(); ++i) {
        const Handle dataset(H5Dopen2(open_->file, fields[i].name, H5P_DEFAULT), H5Dclose);
        transfer(dataset, types[i], band, fields[i].of_states, memory[i], read_part);
      }
    } catch (const std::runtime_error&) {
      throw std::runtime_error("this map is damaged: its datasets cannot be read");
    }
    points_.clear();
    for (int row = 0; row < band.rows; ++row)
      for (int layer = 0; layer < layers; ++layer)
        for (int column = 0; column < columns; ++column)
          points_.push_back(data.get(band.place(layer, row, column), static_cast<std::size_t>(states)));
    band_ = first;
  }
  const auto begin = points_.begin() + static_cast<std::ptrdiff_t>(number - first) * layers * columns;
  return {begin, begin + static_cast<std::ptrdiff_t>(layers) * columns};
}

}  // namespace graze::apps
