// SPDX-License-Identifier: GPL-3.0-or-later
// MapChunk: finished rows of a parameter map, and the bytes in which they are stored and sent:
//     "graze.map.chunk/1\n", fingerprint of the run (u64), first row, rows, layers, columns, states (i32 each), then each of
//     the map's fields for all points (the types u8, integers i32, others f64); finally a checksum (u64) of all bytes before.
// Numbers have the machine's own format: chunks stay on the machine, results are HDF5. Bytes that do not match in every respect
// are rejected.
#pragma once

#include <graze/apps/map/map_plan.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace graze::apps {

struct MapChunk {
  int first_row = 0, rows = 0;
  std::vector<MapPoint> points;  ///< by row, layer, column
};

/// FNV-1a, 64 bits: a change of any single byte changes it.
std::uint64_t checksum(std::string_view bytes);

std::string chunk_bytes(const MapChunk& chunk, const MapPlan& plan, std::uint64_t fingerprint);

/// nullopt: damaged, of another run, or not the chunk with this number.
std::optional<MapChunk> chunk_from(std::string_view bytes, const MapPlan& plan, std::uint64_t fingerprint, int number);

}  // namespace graze::apps
