// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/console/interrupt.hpp>
#include <graze/apps/console/output_file.hpp>
#include <graze/apps/drawing/draw_files.hpp>
#include <graze/apps/text/number.hpp>
#include <graze/lib/numerics/parallel.hpp>

#include <fmt/format.h>

#include <atomic>
#include <exception>
#include <mutex>
#include <optional>

namespace graze::apps {

bool draw_into_files(const std::vector<Drawing>& drawings, const Console& console,
                     const std::function<void(const std::string& sentence)>& complain,
                     const std::function<void(std::size_t k)>& drawn) {
  if (!drawings.empty() && !can_draw()) {
    console.err << fmt::format("graze: {}; {} left out\n", cannot_draw,
                               drawings.size() == 1 ? drawings.front().file + " is"
                                                    : counted(drawings.size(), "picture") + " are");
    return true;
  }
  std::vector<std::optional<std::string>> failures(drawings.size());
  std::atomic<bool> is_interrupted = false;
  std::mutex telling;
  in_parallel_on(console.thread_count(), drawings.size(), [&](std::size_t k) {
    const auto& [file, picture] = drawings[k];
    try {
      if (is_interrupted) throw Interrupted("it was not drawn, since drawing was interrupted");
      failures[k] = write_whole(file, draw(picture(), ending(file)));
    } catch (const std::exception& error) {
      if (dynamic_cast<const Interrupted*>(&error)) is_interrupted = true;
      failures[k] = fmt::format("{}: {}", file, error.what());
    }
    if (!drawn) return;
    const std::lock_guard lock(telling);
    drawn(k);
  });
  for (const auto& failure : failures)
    if (failure) complain(*failure);
  return !is_interrupted;
}

}  // namespace graze::apps
