// SPDX-License-Identifier: GPL-3.0-or-later
// MapChunk: some finished rows of a parameter map, and the bytes that they are kept and sent as:
//     "graze.map.chunk/1\n", fingerprint of the run (u64), first row, rows, layers, columns, states (i32 each), then each of
//     the map's fields for all points (the types u8, whole numbers i32, others f64); at last a checksum (u64) of all before.
// Numbers are those of the machine: chunks stay with it, results are HDF5. Whatever does not fit in any way is no chunk.
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

/// FNV-1a, 64 bits: it differs wherever a single byte does.
std::uint64_t checksum(std::string_view bytes);

std::string chunk_bytes(const MapChunk& chunk, const MapPlan& plan, std::uint64_t fingerprint);

/// nullopt: damaged, of another run, or not the chunk with this number.
std::optional<MapChunk> chunk_from(std::string_view bytes, const MapPlan& plan, std::uint64_t fingerprint, int number);

}  // namespace graze::apps
