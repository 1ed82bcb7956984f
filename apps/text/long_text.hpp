// SPDX-License-Identifier: GPL-3.0-or-later
// Long texts, passed on piece by piece while they are produced. The texts of long lists are produced on several threads.
#pragma once

#include <graze/lib/numerics/parallel.hpp>

#include <oneapi/tbb/parallel_pipeline.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <utility>

namespace graze::apps {

/// Receives the pieces of a text, one at a time and in order. An exception from the sink ends the production of the text.
using TextSink = std::function<void(std::string_view piece)>;
/// A text that passes its pieces to a sink.
using LongText = std::function<void(const TextSink& sink)>;

/// The whole text.
inline std::string whole_text(const LongText& text) {
  std::string all;
  text([&all](std::string_view piece) { all += piece; });
  return all;
}

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
