// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/console/progress.hpp>

#include <fmt/format.h>

#include <unistd.h>

#include <algorithm>
#include <iostream>

namespace graze::apps {

namespace {

using SteadyClock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds bar_interval(100);  // as fast as the eye
constexpr std::chrono::seconds line_interval(5);        // keeps a log file short

}  // namespace

Progress::Progress(std::ostream& err, bool quiet, std::string what)
    : err_(err), quiet_(quiet), terminal_(&err == &std::cerr && isatty(STDERR_FILENO) == 1), what_(std::move(what)),
      next_(SteadyClock::now()) {
  if (terminal_)
    next_ += bar_interval;
  else
    next_ += line_interval;
}

Progress::~Progress() {
  if (drawn_) err_ << "\r\033[K" << std::flush;
}

void Progress::update(double fraction, const std::function<std::string()>& detail) {
  if (quiet_ || SteadyClock::now() < next_) return;
  const double share = std::clamp(fraction, 0.0, 1.0);
  if (terminal_) {
    constexpr int width = 24;
    const int filled = static_cast<int>(share * width);
    const std::string bar = fraction < 0.0 ? ""
                                           : fmt::format(" [{}{}] {:3.0f} %", std::string(filled, '#'),
                                                         std::string(width - filled, '.'), 100.0 * share);
    err_ << "\r\033[K" << what_ << bar << "  " << detail() << std::flush;
    drawn_ = true;
    next_ = SteadyClock::now() + bar_interval;
  } else {
    err_ << "graze: " << what_ << (fraction < 0.0 ? "" : fmt::format(", {:.0f} %", 100.0 * share)) << ": " << detail()
         << std::endl;
    next_ = SteadyClock::now() + line_interval;
  }
}

}  // namespace graze::apps
