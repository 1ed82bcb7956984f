// SPDX-License-Identifier: GPL-3.0-or-later
// PackedCell: a chunk of an HDF5 dataset as the library's filters "shuffle" and "deflate" leave it. They are most of the work of
// writing a map; the library applies them one after the other, here they may run on any thread.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace graze::apps::hdf5 {

struct PackedCell {
  std::string bytes;
  unsigned skipped = 0;  ///< filters that were not applied, bit by bit: the mask of H5Dwrite_chunk
};

/// `numbers`: of `size` bytes each. `level`: of the compression, 1 (fast) to 9. What does not become shorter stays uncompressed.
/// @throws std::runtime_error if there is no memory for it.
PackedCell pack(std::string_view numbers, std::size_t size, int level);

}  // namespace graze::apps::hdf5
