// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/map/packed_cell.hpp>

#define ZLIB_CONST  // zlib does not write to its input
#include <zlib.h>

#include <stdexcept>
#include <utility>

namespace graze::apps::hdf5 {

namespace {

constexpr unsigned deflate_filter = 1U << 1;  // the second of the two filters

/// The first bytes of all numbers, then the second bytes, and so on: this brings similar bytes together.
std::string shuffled(std::string_view numbers, std::size_t size) {
  const std::size_t count = numbers.size() / size;
  std::string bytes(numbers.size(), '\0');
  for (std::size_t byte = 0; byte < size; ++byte)
    for (std::size_t i = 0; i < count; ++i) bytes[byte * count + i] = numbers[i * size + byte];
  return bytes;
}

/// A compressor with its memory of a quarter of a megabyte: one per thread.
class Deflater {
 public:
  ~Deflater() {
    if (level_ != 0) deflateEnd(&stream_);
  }
  /// The compressed bytes; empty: they would not be shorter.
  std::string deflated(const std::string& bytes, int level) {
    begin(level);
    std::string out(bytes.size(), '\0');
    stream_.next_in = reinterpret_cast<const Bytef*>(bytes.data());
    stream_.avail_in = static_cast<uInt>(bytes.size());
    stream_.next_out = reinterpret_cast<Bytef*>(out.data());
    stream_.avail_out = static_cast<uInt>(out.size());
    const bool fits = ::deflate(&stream_, Z_FINISH) == Z_STREAM_END && stream_.avail_out > 0;
    out.resize(fits ? out.size() - stream_.avail_out : 0);
    return out;
  }

 private:
  void begin(int level) {
    if (level == level_) {
      deflateReset(&stream_);
      return;
    }
    if (level_ != 0) deflateEnd(&stream_);
    level_ = 0;
    if (deflateInit(&stream_, level) != Z_OK) throw std::runtime_error("there is no memory to compress in");
    level_ = level;
  }

  z_stream stream_ = {};
  int level_ = 0;  // 0: no stream yet
};

}  // namespace

PackedCell pack(std::string_view numbers, std::size_t size, int level) {
  static thread_local Deflater deflater;
  std::string plain = shuffled(numbers, size), shorter = deflater.deflated(plain, level);
  if (shorter.empty()) return {std::move(plain), deflate_filter};
  return {std::move(shorter), 0};
}

}  // namespace graze::apps::hdf5
