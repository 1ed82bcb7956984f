// SPDX-License-Identifier: GPL-3.0-or-later
// The HDF5 file of a map, whose cells are compressed by our code, as the HDF5 library reads it. Also: the table of all points.
#include "graze_program.hpp"

#include <graze/apps/map/map_file.hpp>
#include <graze/apps/map/map_report.hpp>
#include <graze/apps/map/packed_cell.hpp>
#include <graze/apps/text/table.hpp>

#include <catch2/catch.hpp>

#include <bit>
#include <cmath>
#include <limits>
#include <random>

using namespace graze;
using namespace graze::apps;
using namespace graze::support;

namespace {

/// Two layers with incomplete cells in the last row and column.
MapPlan plan_of_cells() {
  MapPlan plan;
  plan.problem = load_problem(problem("hertz-damped"));
  plan.grid = {{"eta", 0.7, 0.8, 131}, {"r", 1.0, 2.0, 70}};
  plan.follow = "both";
  return plan;
}

/// Any finite number: many of them do not compress.
double any_number(std::mt19937_64& random) {
  for (;;)
    if (const auto number = std::bit_cast<double>(random()); std::isfinite(number)) return number;
}

/// Exponents and states without a pattern; from row `smooth` on, with one.
std::vector<MapPoint> points_of(const MapPlan& plan, int row, int smooth) {
  std::mt19937_64 random(static_cast<std::uint64_t>(row) + 1);
  std::vector<MapPoint> points;
  for (int i = 0; i < plan.layers() * plan.grid.columns.count; ++i) {
    MapPoint point;
    point.type = i % 3 == 0 ? MapType::periodic : MapType::chaotic;
    point.period = i % 3 == 0 ? row + 1 : 0;
    point.impacts = i % 3 == 0 ? i : 0;
    const auto number = [&] { return row < smooth ? any_number(random) : 0.25; };
    point.lambda_1 = row >= smooth && i % 7 == 0 ? -std::numeric_limits<double>::infinity() : number();
    point.standard_error = i % 5 == 0 ? std::nan("") : number();
    point.state = Vector{{number(), row + 0.5}};
    points.push_back(point);
  }
  return points;
}

}  // namespace

TEST_CASE("map file: a file written on any number of threads is read back") {
  const TemporaryFolder folder;
  const MapPlan plan = plan_of_cells();
  const Json head = map_head(plan, {});
  const MapRows rows = [&](int row) { return points_of(plan, row, 64); };
  const std::string one = folder.file("1.h5"), three = folder.file("3.h5");
  REQUIRE_FALSE(write_map_file(one, plan, head, rows, 1));
  REQUIRE_FALSE(write_map_file(three, plan, head, rows, 3));
  CHECK(read_file(one) == read_file(three));
  MapFile map(one);
  int wrong = 0;
  for (int row = 0; row < plan.grid.rows.count; ++row) {
    const std::vector<MapPoint> written = rows(row), read = map.row(row);
    REQUIRE(read.size() == written.size());
    for (std::size_t i = 0; i < read.size(); ++i) {
      const MapPoint &a = written[i], &b = read[i];
      const bool error = std::isnan(a.standard_error) ? std::isnan(b.standard_error) : a.standard_error == b.standard_error;
      const bool same = a.type == b.type && a.period == b.period && a.impacts == b.impacts && a.lambda_1 == b.lambda_1 && error &&
                        a.state == b.state;
      wrong += same ? 0 : 1;
    }
  }
  CHECK(wrong == 0);
}

TEST_CASE("map file: a cell that does not compress is stored uncompressed and marked so for the filters") {
  std::mt19937_64 random(1);
  std::string noise(4096, '\0');
  for (char& byte : noise) byte = static_cast<char>(random() & 0xff);
  const hdf5::PackedCell none = hdf5::pack(noise, 8, 4), zeros = hdf5::pack(std::string(4096, '\0'), 8, 4);
  CHECK(none.skipped == 2);
  REQUIRE(none.bytes.size() == noise.size());
  CHECK(none.bytes[0] == noise[0]);
  CHECK(none.bytes[1] == noise[8]);    // the first bytes of all numbers are stored first
  CHECK(none.bytes[512] == noise[1]);  // of 512 numbers
  CHECK(zeros.skipped == 0);
  CHECK(zeros.bytes.size() < 50);
  CHECK(hdf5::pack(std::string(4096, '\0'), 8, 4).bytes == zeros.bytes);  // with a compressor that was used before
}

TEST_CASE("map file: progress is counted and the table is the same on any number of threads") {
  const MapPlan plan = plan_of_cells();
  const MapRows rows = [&](int row) { return points_of(plan, row, 0); };
  std::vector<MapCounts> counts;
  const MapRows counted = counting(plan, rows, counts);
  for (int row = 0; row < plan.grid.rows.count; ++row) counted(row);
  CHECK(counts == count_map(plan, rows));
  std::size_t points = 0;
  for (const MapCounts& layer : counts)
    for (const auto& [kind, count] : layer) points += count;
  CHECK(static_cast<double>(points) == plan.points());

  std::string one, three;
  map_csv(plan, rows, 1, [&](std::string_view piece) { one += piece; });
  map_csv(plan, rows, 3, [&](std::string_view piece) { three += piece; });
  CHECK(one == three);
  const Table table = parse_csv(one, "map");
  REQUIRE(static_cast<double>(table.rows.size()) == plan.points());
  // Row by row, and within each layer by layer. (layer, r, eta, type, period, impacts, lambda_1, standard_error, x, v)
  CHECK(table.rows[0] == std::vector<std::string>{"0", "1", "0.7", "periodic", "1", "0", "-inf", "", "0.25", "0.5"});
  const std::vector<std::string> last = table.rows.back();
  CHECK(last == std::vector<std::string>{"1", "2", "0.8", "periodic", "70", "261", "0.25", "0.25", "0.25", "69.5"});
}
