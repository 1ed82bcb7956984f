// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/map/map_chunk.hpp>

#include <algorithm>
#include <cstring>

namespace graze::apps {

namespace {

constexpr std::string_view magic = "graze.map.chunk/1\n";

template <class Number> void put(std::string& bytes, Number value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// Takes numbers off the front; the size was checked before.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : rest_(bytes) {}
  template <class Number> Number take() {
    Number value;
    std::memcpy(&value, rest_.data(), sizeof value);
    rest_.remove_prefix(sizeof value);
    return value;
  }

 private:
  std::string_view rest_;
};

}  // namespace

std::uint64_t checksum(std::string_view bytes) {
  std::uint64_t sum = 0xcbf29ce484222325ULL;
  for (const char c : bytes) sum = (sum ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  return sum;
}

std::string chunk_bytes(const MapChunk& chunk, const MapPlan& plan, std::uint64_t fingerprint) {
  const auto states = static_cast<std::int32_t>(plan.problem.system.states);
  std::string bytes(magic);
  put(bytes, fingerprint);
  for (const int number : {chunk.first_row, chunk.rows, plan.layers(), plan.grid.columns.count}) put<std::int32_t>(bytes, number);
  put(bytes, states);
  for (const MapPoint& point : chunk.points) put(bytes, static_cast<std::uint8_t>(point.type));
  for (const MapPoint& point : chunk.points) put<std::int32_t>(bytes, point.period);
  for (const MapPoint& point : chunk.points) put<std::int32_t>(bytes, point.impacts);
  for (const MapPoint& point : chunk.points) put(bytes, point.lambda_1);
  for (const MapPoint& point : chunk.points) put(bytes, point.standard_error);
  for (const MapPoint& point : chunk.points)
    for (const double x : point.state) put(bytes, x);
  put(bytes, checksum(bytes));
  return bytes;
}

std::optional<MapChunk> chunk_from(std::string_view bytes, const MapPlan& plan, std::uint64_t fingerprint, int number) {
  if (number < 0 || number >= plan.chunks()) return std::nullopt;
  MapChunk chunk{plan.first_row(number), plan.rows_of(number), {}};
  const std::size_t states = plan.problem.system.states;
  const std::size_t points = static_cast<std::size_t>(chunk.rows) * static_cast<std::size_t>(plan.layers()) *
                             static_cast<std::size_t>(plan.grid.columns.count);
  constexpr std::size_t of_a_point = 1 + 2 * sizeof(std::int32_t) + 2 * sizeof(double);
  const std::size_t size =
      magic.size() + 2 * sizeof(std::uint64_t) + 5 * sizeof(std::int32_t) + points * (of_a_point + states * sizeof(double));
  if (bytes.size() != size || !bytes.starts_with(magic)) return std::nullopt;
  const std::string_view content = bytes.substr(0, size - sizeof(std::uint64_t));
  if (Reader(bytes.substr(content.size())).take<std::uint64_t>() != checksum(content)) return std::nullopt;
  Reader reader(content.substr(magic.size()));
  if (reader.take<std::uint64_t>() != fingerprint) return std::nullopt;
  for (const int wanted : {chunk.first_row, chunk.rows, plan.layers(), plan.grid.columns.count, static_cast<int>(states)})
    if (reader.take<std::int32_t>() != wanted) return std::nullopt;
  chunk.points.resize(points);
  for (MapPoint& point : chunk.points) {
    const auto type = reader.take<std::uint8_t>();
    if (type >= static_cast<std::uint8_t>(MapType::not_run)) return std::nullopt;
    point.type = static_cast<MapType>(type);
  }
  for (MapPoint& point : chunk.points) point.period = reader.take<std::int32_t>();
  for (MapPoint& point : chunk.points) point.impacts = reader.take<std::int32_t>();
  for (MapPoint& point : chunk.points) point.lambda_1 = reader.take<double>();
  for (MapPoint& point : chunk.points) point.standard_error = reader.take<double>();
  for (MapPoint& point : chunk.points) {
    point.state.resize(static_cast<Eigen::Index>(states));
    for (double& x : point.state) x = reader.take<double>();
  }
  return chunk;
}

}  // namespace graze::apps
