// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/console/output_file.hpp>
#include <graze/apps/map/map_band.hpp>
#include <graze/apps/map/map_file.hpp>
#include <graze/apps/map/packed_cell.hpp>
#include <graze/apps/results/input_file.hpp>
#include <graze/apps/text/version.hpp>
#include <graze/lib/numerics/parallel.hpp>

#include <fmt/format.h>
#include <hdf5_hl.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
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

/// Number of values along each axis; empty if it is not a dataset.
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
  if (!std::filesystem::is_regular_file(file)) read_whole(file);  // throws with the reason
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
  for (const MapField& field : plan_.fields) {
    if (H5Lexists(open_->file, field.dataset.c_str(), H5P_DEFAULT) <= 0) throw damaged(field.dataset, "is missing");
    const std::vector<hsize_t> size = size_of(open_->file, field.dataset.c_str()), wanted = all.size(field.of_states());
    if (size != wanted)
      throw damaged(field.dataset,
                    fmt::format("has {} values and should have {}", fmt::join(size, " x "), fmt::join(wanted, " x ")));
  }
}

void MapFile::read(int first) {
  const int layers = plan_.layers(), columns = plan_.grid.columns.count, states = static_cast<int>(plan_.problem.system.states);
  const Band band{first, std::min(static_cast<int>(cell), plan_.grid.rows.count - first), layers, columns, states};
  BandData data(band, plan_.fields);
  const Handle attractor = attractor_type();
  for (std::size_t i = 0; i < plan_.fields.size(); ++i) {
    const MapField& field = plan_.fields[i];
    try {
      const Handle dataset(H5Dopen2(open_->file, field.dataset.c_str(), H5P_DEFAULT), H5Dclose);
      read_part(dataset, type_of(field, attractor), band, field.of_states(), data.memory[i].data());
    } catch (const std::runtime_error&) {
      throw damaged(field.dataset, "cannot be read");
    }
  }
  points_.clear();
  for (int row = 0; row < band.rows; ++row)
    for (int layer = 0; layer < layers; ++layer)
      for (int column = 0; column < columns; ++column) points_.push_back(data.get(band.place(layer, row, column)));
  for (const MapPoint& point : points_)
    if (point.type >= MapType::not_run)
      throw damaged("attractor", fmt::format("holds a {}, which stands for nothing", static_cast<int>(point.type)));
  band_ = first;
}

std::vector<MapPoint> MapFile::row(int number) {
  const int first = number / static_cast<int>(cell) * static_cast<int>(cell);
  if (first != band_) read(first);
  const std::ptrdiff_t size = static_cast<std::ptrdiff_t>(plan_.layers()) * plan_.grid.columns.count;
  const auto begin = points_.begin() + (number - first) * size;
  return {begin, begin + size};
}

using namespace hdf5;

namespace {

constexpr int deflation = 4;  // a higher level takes more time than it saves
constexpr std::size_t least_growth = std::size_t(1) << 16, most_growth = std::size_t(1) << 24;  // bytes, of the file in memory

/// A text type of variable length, which h5py and MATLAB return as a string rather than bytes, and which netCDF can read. From
/// a list of fixed-length texts netCDF 4.9 reads only the first. Octave reads only fixed-length texts, and everything else if
/// requested by name.
Handle text_type() {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  check(H5Tset_size(type, H5T_VARIABLE));
  check(H5Tset_cset(type, H5T_CSET_UTF8));
  return type;
}

void set_attribute(hid_t object, const std::string& name, const std::string& text) {
  const Handle type = text_type(), space = space_of({});
  const Handle attribute(H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  const char* const characters = text.c_str();
  check(H5Awrite(attribute, type, &characters));
}

void set_attribute(hid_t object, const std::string& name, double value) {
  const Handle space = space_of({});
  const Handle attribute(H5Acreate2(object, name.c_str(), H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  check(H5Awrite(attribute, H5T_NATIVE_DOUBLE, &value));
}

/// Creation options for an object of this kind that stores no time stamps.
Handle without_times(hid_t kind) {
  Handle options(H5Pcreate(kind), H5Pclose);
  check(H5Pset_obj_track_times(options, 0));
  return options;
}

/// A dataset without time stamps. `chunk`: its chunk size, compressed; empty: contiguous.
Handle make_dataset(hid_t file, const std::string& name, hid_t type, const std::vector<hsize_t>& size,
                    const std::vector<hsize_t>& chunk) {
  const Handle space = space_of(size), options = without_times(H5P_DATASET_CREATE);
  if (!chunk.empty()) {
    check(H5Pset_chunk(options, static_cast<int>(chunk.size()), chunk.data()));
    check(H5Pset_shuffle(options));
    check(H5Pset_deflate(options, static_cast<unsigned>(deflation)));
  }
  return {H5Dcreate2(file, name.c_str(), type, space, H5P_DEFAULT, options, H5P_DEFAULT), H5Dclose};
}

void describe(hid_t dataset, const std::string& meaning, const std::string& unit = "dimensionless") {
  set_attribute(dataset, "long_name", meaning);
  set_attribute(dataset, "units", unit);
}

void write_all(hid_t dataset, hid_t type, const void* data) {
  // Texts are converted in a buffer, which by default takes a megabyte.
  const Handle options(H5Pcreate(H5P_DATASET_XFER), H5Pclose);
  constexpr std::size_t enough = 4096;
  check(H5Pset_buffer(options, enough, nullptr, nullptr));
  check(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, options, data));
}

/// A dataset that serves as a dimension scale.
Handle make_scale(hid_t file, const std::string& name, const std::vector<double>& values, const std::string& meaning) {
  Handle scale = make_dataset(file, name, H5T_IEEE_F64LE, {values.size()}, {});
  write_all(scale, H5T_NATIVE_DOUBLE, values.data());
  describe(scale, meaning);
  check(H5DSset_scale(scale, name.c_str()));
  return scale;
}

std::vector<double> values_of(const ParameterAxis& axis) {
  std::vector<double> values;
  for (int i = 0; i < axis.count; ++i) values.push_back(axis.at(i));
  return values;
}

std::vector<double> numbers_to(int count) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back(i);
  return values;
}

const std::string& meaning_of(const MapPlan& plan, const std::string& parameter) {
  const auto& parameters = plan.problem.system.parameters;
  return parameters[parameter_index(parameters, parameter)].meaning;
}

/// Name of a parameter's dimension scale: the parameter's, with "_" behind it if something else in the file has that name.
std::string scale_name(const MapPlan& plan, std::string parameter) {
  std::set<std::string> taken = {"layer", "component", "start", "follow", "parameters", "y", "AttractorType"};
  for (const MapField& field : plan.fields) taken.insert(field.dataset);
  for (const ParameterAxis* axis : {&plan.grid.columns, &plan.grid.rows})
    if (axis->parameter != parameter) taken.insert(axis->parameter);
  while (taken.contains(parameter)) parameter += "_";
  return parameter;
}

void write_layers(hid_t file, const MapPlan& plan, hid_t layer, hid_t component) {
  const auto layers = static_cast<hsize_t>(plan.layers()), states = static_cast<hsize_t>(plan.problem.system.states);
  std::vector<double> starts;
  std::vector<const char*> follows;
  for (int i = 0; i < plan.layers(); ++i) {
    const LayerOrigin origin = layer_origin(plan, i);
    for (hsize_t k = 0; k < states; ++k)
      starts.push_back(origin.start ? (*origin.start)[static_cast<Eigen::Index>(k)] : std::nan(""));
    follows.push_back(map_direction_name(origin.follow).data());
  }
  const Handle start = make_dataset(file, "start", H5T_IEEE_F64LE, {layers, states}, {});
  write_all(start, H5T_NATIVE_DOUBLE, starts.data());
  describe(start, "state at forcing phase 0 that the layer starts from; NaN: at rest");
  check(H5DSattach_scale(start, layer, 0));
  check(H5DSattach_scale(start, component, 1));
  const Handle type = text_type(), follow = make_dataset(file, "follow", type, {layers}, {});
  write_all(follow, type, follows.data());
  set_attribute(follow, "long_name",
                std::string("way along the columns in which a row was followed; none: each point by itself"));
  check(H5DSattach_scale(follow, layer, 0));
}

void write_head(hid_t file, const MapPlan& plan, const Json& head) {
  set_attribute(file, "schema", std::string(head.at("schema")));
  set_attribute(file, "graze", std::string(program_version));
  if (is_built_in(plan.problem)) {
    set_attribute(file, "oscillator", plan.problem.oscillator);
    set_attribute(file, "contact", plan.problem.contact);
  } else {
    set_attribute(file, "system", plan.problem.system.name);
  }
  set_attribute(file, "units", std::string("dimensionless"));
  set_attribute(file, "options", flat(head.at("options")));
  set_attribute(file, "head", flat(head));
  const Handle group(H5Gcreate2(file, "parameters", H5P_DEFAULT, without_times(H5P_GROUP_CREATE), H5P_DEFAULT), H5Gclose);
  set_attribute(group, "long_name", std::string("parameters of the model; those of the axes as they were without the map"));
  for (const auto& [name, value] : head.at("parameters").items()) set_attribute(group, name, value.get<double>());
}

/// The numbers of a cell in sequence; beyond the edges of the map they are 0.
std::string numbers_of(const Band& band, const MapField& field, const std::string& memory, int cell_rows, int layer, int column) {
  const std::size_t of_point = field.bytes(static_cast<std::size_t>(band.states));
  const auto columns = static_cast<std::size_t>(band.cell_columns());
  std::string numbers(static_cast<std::size_t>(cell_rows) * columns * of_point, '\0');
  const std::size_t there = std::min(columns, static_cast<std::size_t>(band.columns - column)) * of_point;
  for (int row = 0; row < band.rows; ++row)
    std::memcpy(numbers.data() + static_cast<std::size_t>(row) * columns * of_point,
                memory.data() + band.place(layer, row, column) * of_point, there);
  return numbers;
}

/// `cell_rows`: the rows of the map's cells; the last band may have fewer.
void write_band(const std::vector<Handle>& datasets, const Band& band, const BandData& data, int cell_rows, int threads) {
  struct Cell {
    std::size_t field;
    int layer, column;
    PackedCell packed;
  };
  std::vector<Cell> cells;
  for (std::size_t i = 0; i < data.fields.size(); ++i)
    for (int layer = 0; layer < band.layers; ++layer)
      for (int column = 0; column < band.columns; column += band.cell_columns()) cells.push_back({i, layer, column, {}});
  in_parallel_on(threads, cells.size(), [&](std::size_t k) {
    Cell& one = cells[k];
    const MapField& field = data.fields[one.field];
    const std::string numbers = numbers_of(band, field, data.memory[one.field], cell_rows, one.layer, one.column);
    one.packed = pack(numbers, field.bytes(), deflation);
  });
  for (const auto& [field, layer, column, packed] : cells) {
    std::vector<hsize_t> at = band.offset(data.fields[field].of_states());
    at[0] = static_cast<hsize_t>(layer);
    at[2] = static_cast<hsize_t>(column);
    check(H5Dwrite_chunk(datasets[field], H5P_DEFAULT, packed.skipped, at.data(), packed.bytes.size(), packed.bytes.data()));
  }
}

std::string component_meaning(const Problem& problem) {
  std::string meaning;
  const std::vector<std::string> names = state_headings(problem);
  for (std::size_t i = 0; i < names.size(); ++i)
    meaning += fmt::format("{}{} for {}", i == 0 ? "of the state: " : ", ", i, names[i]);
  return meaning;
}

void write_content(hid_t file, const MapPlan& plan, const Json& head, const MapRows& rows, int threads) {
  write_head(file, plan, head);
  const ParameterGrid& grid = plan.grid;
  const auto states = static_cast<int>(plan.problem.system.states);
  const auto scale_of = [&](const ParameterAxis& axis) {
    return make_scale(file, scale_name(plan, axis.parameter), values_of(axis), meaning_of(plan, axis.parameter));
  };
  const Handle columns = scale_of(grid.columns), rows_scale = scale_of(grid.rows);
  const Handle layer = make_scale(file, "layer", numbers_to(plan.layers()), "number of the layer; see start and follow");
  const Handle component = make_scale(file, "component", numbers_to(states), component_meaning(plan.problem));
  write_layers(file, plan, layer, component);
  const Handle attractor = attractor_type();
  // Named in the file before the datasets are created: netCDF requires both.
  check(H5Tcommit2(file, "AttractorType", attractor, H5P_DEFAULT, without_times(H5P_DATATYPE_CREATE), H5P_DEFAULT));
  const Band all{0, grid.rows.count, plan.layers(), grid.columns.count, states};
  std::vector<Handle> datasets;
  if (!plan.quantities.empty()) {
    const Handle group(H5Gcreate2(file, "y", H5P_DEFAULT, without_times(H5P_GROUP_CREATE), H5P_DEFAULT), H5Gclose);
    set_attribute(group, "long_name", std::string("quantities of the attractors; NaN: not known"));
  }
  for (const MapField& field : plan.fields) {
    const std::vector<hsize_t> size = all.size(field.of_states());
    std::vector<hsize_t> chunk = size;
    chunk[0] = 1;
    chunk[1] = static_cast<hsize_t>(all.cell_rows());
    chunk[2] = static_cast<hsize_t>(all.cell_columns());
    const Handle& dataset = datasets.emplace_back(make_dataset(file, field.dataset, type_of(field, attractor), size, chunk));
    describe(dataset, field.column.meaning, field.column.unit);
    check(H5DSattach_scale(dataset, layer, 0));
    check(H5DSattach_scale(dataset, rows_scale, 1));
    check(H5DSattach_scale(dataset, columns, 2));
    if (field.of_states()) check(H5DSattach_scale(dataset, component, 3));
  }
  // The enumeration again, in the CF convention, for readers that return bare numbers.
  constexpr std::array<unsigned char, map_types - 1> flags = {0, 1, 2, 3, 4};
  check(H5LTset_attribute_uchar(datasets[0], ".", "flag_values", flags.data(), flags.size()));
  set_attribute(datasets[0], "flag_meanings", std::string("undecided periodic chaotic inadmissible lost"));
  // Band by band, each one row of whole cells: this keeps memory use small.
  for (int first = 0; first < grid.rows.count; first += static_cast<int>(cell)) {
    const Band band{first, std::min(static_cast<int>(cell), grid.rows.count - first), plan.layers(), grid.columns.count, states};
    BandData data(band, plan.fields);
    for (int row = 0; row < band.rows; ++row) {
      const std::vector<MapPoint> points = rows(first + row);
      for (int l = 0; l < band.layers; ++l)
        for (int column = 0; column < band.columns; ++column)
          data.put(band.place(l, row, column), points[static_cast<std::size_t>(l * band.columns + column)]);
    }
    write_band(datasets, band, data, all.cell_rows(), threads);
  }
}

/// A file in memory only. It grows in steps that depend on the map's uncompressed size.
Handle make_file(const MapPlan& plan) {
  constexpr double bytes_of_a_point = 8.0;
  const double size = bytes_of_a_point * plan.points();
  const std::size_t growth = std::clamp(static_cast<std::size_t>(size), least_growth, most_growth);
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  check(H5Pset_fapl_core(access, growth, 0));
  return {H5Fcreate("map", H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose};
}

/// The bytes of a file built in memory, without a copy; valid until the file changes.
std::string_view bytes_of(hid_t file) {
  check(H5Fflush(file, H5F_SCOPE_LOCAL));
  void* place = nullptr;
  check(H5Fget_vfd_handle(file, H5P_DEFAULT, &place));
  const ssize_t size = H5Fget_file_image(file, nullptr, 0);
  if (size <= 0) throw std::runtime_error("the HDF5 library refuses");
  return {*static_cast<const char* const*>(place), static_cast<std::size_t>(size)};
}

}  // namespace

std::optional<std::string> write_map_file(const std::string& file, const MapPlan& plan, const Json& head, const MapRows& rows,
                                          int threads) {
  silence();
  try {
    const Handle hdf5 = make_file(plan);
    write_content(hdf5, plan, head, rows, threads);
    if (auto failure = write_whole(file, bytes_of(hdf5))) return failure;
    return sync_folder(folder_of(file));
  } catch (const std::exception& error) {
    return fmt::format("{}: cannot be written: {}", file, error.what());
  }
}

}  // namespace graze::apps
