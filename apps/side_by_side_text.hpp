// SPDX-License-Identifier: GPL-3.0-or-later
// Long lists as text: their items are written side by side on several threads, and joined in their order.
#pragma once

#include <graze/lib/in_parallel.hpp>

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

namespace graze::apps {

/// work(0) ... work(n - 1) on so many threads, in any order.
template <class Work> void on_threads(int threads, std::size_t n, const Work& work) {
  if (threads > 1 && n > 1) {
    oneapi::tbb::task_arena arena(threads);
    arena.execute([&] { in_parallel(n, work); });
  } else {
    for (std::size_t k = 0; k < n; ++k) work(k);
  }
}

/// Appends to `text` what write(0, text) ... write(n - 1, text) append.
template <class Write> void append_items(int threads, std::size_t n, std::string& text, const Write& write) {
  constexpr std::size_t fewest = 16, blocks_of_a_thread = 64;
  constexpr std::size_t end_of_text = 256;  // for what the caller adds: a long text is not to be moved for it
  if (threads <= 1 || n <= fewest) {
    for (std::size_t k = 0; k < n; ++k) write(k, text);
    return;
  }
  const std::size_t together = std::max(fewest, n / (blocks_of_a_thread * static_cast<std::size_t>(threads)));
  std::vector<std::string> blocks((n + together - 1) / together);
  on_threads(threads, blocks.size(), [&](std::size_t i) {
    for (std::size_t k = i * together; k < std::min(n, (i + 1) * together); ++k) write(k, blocks[i]);
  });
  std::size_t size = text.size() + end_of_text;
  for (const std::string& block : blocks) size += block.size();
  text.reserve(size);
  for (const std::string& block : blocks) text += block;
}

}  // namespace graze::apps
