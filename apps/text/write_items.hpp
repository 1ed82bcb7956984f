// SPDX-License-Identifier: GPL-3.0-or-later
// The text of a long list, produced on several threads.
#pragma once

#include <graze/apps/text/long_text.hpp>

#include <oneapi/tbb/parallel_pipeline.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>

namespace graze::apps {

/// Passes the texts that write(0, text) ... write(n - 1, text) append to `sink`, in order.
template <class Write> void write_items(int threads, std::size_t n, const TextSink& sink, const Write& write) {
  constexpr std::size_t fewest = 16, most = 256, blocks_of_a_thread = 64, ahead_of_a_thread = 16;
  const auto width = static_cast<std::size_t>(std::max(threads, 1));
  const std::size_t together = std::clamp(n / (blocks_of_a_thread * width), fewest, most);
  const auto block = [&](std::size_t first) {
    std::string text;
    for (std::size_t k = first; k < std::min(n, first + together); ++k) write(k, text);
    return text;
  };
  if (width == 1 || n <= together) {
    for (std::size_t first = 0; first < n; first += together) sink(block(first));
    return;
  }
  namespace tbb = oneapi::tbb;
  std::size_t next = 0;
  const auto begin = tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order, [&](tbb::flow_control& control) {
    if (next >= n) control.stop();
    return std::exchange(next, next + together);
  });
  const auto make = tbb::make_filter<std::size_t, std::string>(tbb::filter_mode::parallel, block);
  const auto publish = tbb::make_filter<std::string, void>(tbb::filter_mode::serial_in_order, sink);
  tbb::task_arena arena(threads);
  arena.execute([&] { tbb::parallel_pipeline(ahead_of_a_thread * width, begin & make & publish); });
}

}  // namespace graze::apps
