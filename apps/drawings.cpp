// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/drawings.hpp>
#include <graze/apps/interrupt.hpp>
#include <graze/apps/long_text.hpp>
#include <graze/apps/output_file.hpp>

#include <fmt/format.h>

#include <atomic>
#include <exception>
#include <optional>

namespace graze::apps {

namespace {

struct Drawn {
  std::optional<Picture> picture;
  std::string text;
  std::exception_ptr failure;
};

}  // namespace

bool draw_into_files(const std::vector<Drawing>& drawings, int threads,
                     const std::function<void(const std::string& sentence)>& complain) {
  std::vector<Drawn> list(drawings.size());
  for (std::size_t i = 0; i < list.size(); ++i) {  // (what a picture is of may be read from a file: one after the other)
    try {
      list[i].picture = drawings[i].picture();
    } catch (...) {
      list[i].failure = std::current_exception();
    }
  }
  std::atomic<bool> is_interrupted = false;
  on_threads(threads, list.size(), [&](std::size_t i) {
    Drawn& drawn = list[i];
    if (!drawn.picture) return;
    try {
      if (is_interrupted) throw Interrupted("it was not drawn, since drawing was interrupted");
      drawn.text = draw(*drawn.picture, ending(drawings[i].file));
    } catch (const Interrupted&) {
      is_interrupted = true;
      drawn.failure = std::current_exception();
    } catch (...) {
      drawn.failure = std::current_exception();
    }
    drawn.picture.reset();
  });
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string& file = drawings[i].file;
    try {
      if (list[i].failure) std::rethrow_exception(list[i].failure);
      if (const auto failure = write_whole(file, list[i].text)) complain(*failure);
    } catch (const std::exception& error) {
      complain(fmt::format("{}: {}", file, error.what()));
    }
  }
  return !is_interrupted;
}

}  // namespace graze::apps
