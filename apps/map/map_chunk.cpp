// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/map/map_chunk.hpp>
#include <graze/apps/map/map_columns.hpp>

#include <cstring>
#include <utility>

namespace graze::apps {

namespace {

constexpr std::string_view magic = "graze.map.chunk/1\n";

template <class Number> void put(std::string& bytes, Number value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// Reads numbers from the front; the caller has checked the size.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : rest_(bytes) {}
  template <class Number> Number take() {
    Number value;
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }
  std::string_view take(std::size_t size) {
    const std::string_view taken = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return taken;
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
  for (const MapField& field : plan.fields) {
    const std::size_t size = field.bytes(plan.problem.system.states);
    std::size_t at = bytes.size();
    bytes.resize(at + chunk.points.size() * size);
    for (const MapPoint& point : chunk.points) write_bytes(field, point, &bytes[std::exchange(at, at + size)]);
  }
  put(bytes, checksum(bytes));
  return bytes;
}

std::optional<MapChunk> chunk_from(std::string_view bytes, const MapPlan& plan, std::uint64_t fingerprint, int number) {
  if (number < 0 || number >= plan.chunks()) return std::nullopt;
  MapChunk chunk{plan.first_row(number), plan.rows_of(number), {}};
  const std::size_t states = plan.problem.system.states;
  const std::size_t points = static_cast<std::size_t>(chunk.rows) * static_cast<std::size_t>(plan.layers()) *
                             static_cast<std::size_t>(plan.grid.columns.count);
  std::size_t size = magic.size() + 2 * sizeof(std::uint64_t) + 5 * sizeof(std::int32_t);
  for (const MapField& field : plan.fields) size += points * field.bytes(states);
  if (bytes.size() != size || !bytes.starts_with(magic)) return std::nullopt;
  const std::string_view content = bytes.substr(0, size - sizeof(std::uint64_t));
  if (Reader(bytes.substr(content.size())).take<std::uint64_t>() != checksum(content)) return std::nullopt;
  Reader reader(content.substr(magic.size()));
  if (reader.take<std::uint64_t>() != fingerprint) return std::nullopt;
  for (const int wanted : {chunk.first_row, chunk.rows, plan.layers(), plan.grid.columns.count, static_cast<int>(states)})
    if (reader.take<std::int32_t>() != wanted) return std::nullopt;
  chunk.points.resize(points);
  for (const MapField& field : plan.fields)
    for (MapPoint& point : chunk.points) read_bytes(field, reader.take(field.bytes(states)).data(), states, point);
  for (const MapPoint& point : chunk.points)
    if (point.type >= MapType::not_run) return std::nullopt;
  return chunk;
}

}  // namespace graze::apps
