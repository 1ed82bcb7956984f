// SPDX-License-Identifier: GPL-3.0-or-later
// The one place that includes HDF5.
#include <graze/apps/input_file.hpp>
#include <graze/apps/map_file.hpp>
#include <graze/apps/output_file.hpp>
#include <graze/apps/version.hpp>

#include <fmt/format.h>
#include <hdf5.h>
#include <hdf5_hl.h>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <stdexcept>

namespace graze::apps {

namespace {

constexpr hsize_t cell = 64;       // a chunk of the file is so many rows and columns
constexpr unsigned deflation = 4;  // more takes longer than it saves

/// An identifier of the HDF5 library, closed in the end.
class Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Handle(hid_t id, Close close) : id_(id), close_(close) {
    if (id < 0) throw std::runtime_error("the HDF5 library refuses");
  }
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(Handle&& other) noexcept : id_(other.id_), close_(other.close_) { other.id_ = -1; }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }  // NOLINT(google-explicit-constructor): it stands for the number

 private:
  hid_t id_;
  Close close_;
};

void check(herr_t result) {
  if (result < 0) throw std::runtime_error("the HDF5 library refuses (is the disc full?)");
}

/// Errors are reported by us.
void silence() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

Handle space_of(const std::vector<hsize_t>& size) {
  return {size.empty() ? H5Screate(H5S_SCALAR) : H5Screate_simple(static_cast<int>(size.size()), size.data(), nullptr), H5Sclose};
}

/// Of variable length, which h5py and MATLAB give as a string, not as bytes, and netCDF reads.
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

Handle attractor_type() {
  Handle type(H5Tenum_create(H5T_STD_U8LE), H5Tclose);
  for (unsigned char i = 0; i < static_cast<unsigned char>(MapType::not_run); ++i)
    check(H5Tenum_insert(type, map_type_name(static_cast<MapType>(i)).data(), &i));
  return type;
}

/// To make an object of a kind so that it keeps no times.
Handle without_times(hid_t kind) {
  Handle options(H5Pcreate(kind), H5Pclose);
  check(H5Pset_obj_track_times(options, 0));
  return options;
}

/// A dataset without times. `chunk`: its chunks, compressed; empty: contiguous.
Handle make_dataset(hid_t file, const std::string& name, hid_t type, const std::vector<hsize_t>& size,
                    const std::vector<hsize_t>& chunk) {
  const Handle space = space_of(size), options = without_times(H5P_DATASET_CREATE);
  if (!chunk.empty()) {
    check(H5Pset_chunk(options, static_cast<int>(chunk.size()), chunk.data()));
    check(H5Pset_shuffle(options));
    check(H5Pset_deflate(options, deflation));
  }
  return {H5Dcreate2(file, name.c_str(), type, space, H5P_DEFAULT, options, H5P_DEFAULT), H5Dclose};
}

void describe(hid_t dataset, const std::string& meaning) {
  set_attribute(dataset, "long_name", meaning);
  set_attribute(dataset, "units", std::string("dimensionless"));
}

/// One field of all points: how its numbers are put into memory, and how it is kept.
struct Field {
  const char* name;
  const char* meaning;
  bool of_states;
};
constexpr std::array<Field, 6> fields = {Field{"attractor", "what the motion settles on", false},
                                         {"period", "n of z = p/n, in forcing periods; 0: not periodic", false},
                                         {"impacts", "p of z = p/n; 0 also where not periodic", false},
                                         {"lambda_1", "first Lyapunov exponent per unit of dimensionless time", false},
                                         {"standard_error", "of lambda_1; 0: exact, from the multipliers", false},
                                         {"state", "(x, x') on the attractor at forcing phase 0", true}};

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

using Transfer = herr_t (*)(hid_t dataset, hid_t type, hid_t memory, hid_t file, void* data);

void transfer(hid_t dataset, hid_t type, const Band& band, bool of_states, void* data, Transfer how) {
  const std::vector<hsize_t> at = band.offset(of_states), size = band.size(of_states);
  const Handle memory = space_of(size), in_file(H5Dget_space(dataset), H5Sclose);
  check(H5Sselect_hyperslab(in_file, H5S_SELECT_SET, at.data(), nullptr, size.data(), nullptr));
  check(how(dataset, type, memory, in_file, data));
}

herr_t write_part(hid_t dataset, hid_t type, hid_t memory, hid_t file, void* data) {
  return H5Dwrite(dataset, type, memory, file, H5P_DEFAULT, data);
}

herr_t read_part(hid_t dataset, hid_t type, hid_t memory, hid_t file, void* data) {
  return H5Dread(dataset, type, memory, file, H5P_DEFAULT, data);
}

void write_all(hid_t dataset, hid_t type, const void* data) {
  check(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data));
}

/// A dataset that stands for a dimension.
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

std::vector<double> numbers_to(int count) { return values_of({"", 0.0, count - 1.0, count}); }

const std::string& meaning_of(const MapPlan& plan, const std::string& parameter) {
  const auto& parameters = plan.problem.system.parameters;
  return parameters[parameter_index(parameters, parameter)].meaning;
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
  set_attribute(file, "oscillator", plan.problem.oscillator);
  set_attribute(file, "contact", plan.problem.contact);
  set_attribute(file, "units", std::string("dimensionless"));
  set_attribute(file, "options", head.at("options").dump());
  set_attribute(file, "head", head.dump());
  const Handle group(H5Gcreate2(file, "parameters", H5P_DEFAULT, without_times(H5P_GROUP_CREATE), H5P_DEFAULT), H5Gclose);
  set_attribute(group, "long_name", std::string("parameters of the model; those of the axes as they were without the map"));
  for (const auto& [name, value] : head.at("parameters").items()) set_attribute(group, name, value.get<double>());
}

void write_content(hid_t file, const MapPlan& plan, const Json& head, const MapRows& rows) {
  write_head(file, plan, head);
  const ParameterGrid& grid = plan.grid;
  const auto states = static_cast<int>(plan.problem.system.states);
  const Handle columns =
      make_scale(file, grid.columns.parameter, values_of(grid.columns), meaning_of(plan, grid.columns.parameter));
  const Handle rows_scale = make_scale(file, grid.rows.parameter, values_of(grid.rows), meaning_of(plan, grid.rows.parameter));
  const Handle layer = make_scale(file, "layer", numbers_to(plan.layers()), "number of the layer; see start and follow");
  const Handle component = make_scale(file, "component", numbers_to(states), "of the state: 0 for x, 1 for x'");
  write_layers(file, plan, layer, component);
  const Handle attractor = attractor_type();
  // With a name in the file, before those of the datasets: netCDF asks for both.
  check(H5Tcommit2(file, "AttractorType", attractor, H5P_DEFAULT, without_times(H5P_DATATYPE_CREATE), H5P_DEFAULT));
  const std::array<hid_t, 6> kept = {attractor, H5T_STD_I32LE, H5T_STD_I32LE, H5T_IEEE_F64LE, H5T_IEEE_F64LE, H5T_IEEE_F64LE};
  const Band all{0, grid.rows.count, plan.layers(), grid.columns.count, states};
  std::vector<Handle> datasets;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::vector<hsize_t> size = all.size(fields[i].of_states);
    std::vector<hsize_t> chunk = size;
    chunk[0] = 1;
    chunk[1] = std::min(chunk[1], cell);
    chunk[2] = std::min(chunk[2], cell);
    datasets.push_back(make_dataset(file, fields[i].name, kept[i], size, chunk));
    describe(datasets[i], fields[i].meaning);
    check(H5DSattach_scale(datasets[i], layer, 0));
    check(H5DSattach_scale(datasets[i], rows_scale, 1));
    check(H5DSattach_scale(datasets[i], columns, 2));
    if (fields[i].of_states) check(H5DSattach_scale(datasets[i], component, 3));
  }
  // The enumeration once more, as CF has it, for readers that give it as bare numbers.
  constexpr std::array<unsigned char, map_types - 1> flags = {0, 1, 2, 3, 4};
  check(H5LTset_attribute_uchar(datasets[0], ".", "flag_values", flags.data(), flags.size()));
  set_attribute(datasets[0], "flag_meanings", std::string("undecided periodic chaotic inadmissible lost"));
  // Band by band, each a row of whole chunks: none is compressed twice, and little is held in memory.
  for (int first = 0; first < grid.rows.count; first += static_cast<int>(cell)) {
    const Band band{first, std::min(static_cast<int>(cell), grid.rows.count - first), plan.layers(), grid.columns.count, states};
    BandData data(band);
    for (int row = 0; row < band.rows; ++row) {
      const std::vector<MapPoint> points = rows(first + row);
      for (int l = 0; l < band.layers; ++l)
        for (int column = 0; column < band.columns; ++column)
          data.put(band.place(l, row, column), points[static_cast<std::size_t>(l * band.columns + column)]);
    }
    const std::array<void*, 6> memory = data.memory();
    const std::array<hid_t, 6> types = BandData::types(attractor);
    for (std::size_t i = 0; i < fields.size(); ++i)
      transfer(datasets[i], types[i], band, fields[i].of_states, memory[i], write_part);
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

std::optional<std::string> write_map_file(const std::string& file, const MapPlan& plan, const Json& head, const MapRows& rows) {
  namespace fs = std::filesystem;
  silence();
  const fs::path path(file);
  const std::string temporary = (path.parent_path() / fmt::format(".{}.part", path.filename().string())).string();
  const auto fail = [&](const std::string& why) {
    ::unlink(temporary.c_str());
    return std::optional(fmt::format("{}: cannot be written: {}", file, why));
  };
  try {
    const Handle hdf5(H5Fcreate(temporary.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose);
    write_content(hdf5, plan, head, rows);
    check(H5Fflush(hdf5, H5F_SCOPE_LOCAL));
  } catch (const std::exception& error) {
    return fail(error.what());
  }
  const int descriptor = ::open(temporary.c_str(), O_RDONLY | O_CLOEXEC);
  const bool synchronised = descriptor >= 0 && ::fsync(descriptor) == 0;
  if (descriptor >= 0) ::close(descriptor);
  if (!synchronised || ::rename(temporary.c_str(), file.c_str()) != 0) return fail(std::strerror(errno));
  return sync_folder(path.parent_path().empty() ? "." : path.parent_path().string());
}

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
