// SPDX-License-Identifier: GPL-3.0-or-later
// PackedCell: a chunk of an HDF5 dataset in the form that the library's filters "shuffle" and "deflate" produce. Filtering is
// most of the work of writing a map. The library filters one chunk after another; here any thread can do it.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace graze::apps::hdf5 {

struct PackedCell {
  std::string bytes;
  unsigned skipped = 0;  ///< bit mask of the filters that were not applied, as H5Dwrite_chunk takes it
};

/// `numbers`: of `size` bytes each. `level`: of the compression, 1 (fast) to 9. A chunk that would not become shorter stays
/// uncompressed. @throws std::runtime_error if memory runs out.
PackedCell pack(std::string_view numbers, std::size_t size, int level);

}  // namespace graze::apps::hdf5
