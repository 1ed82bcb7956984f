// SPDX-License-Identifier: GPL-3.0-or-later
// Progress on stderr: a bar redrawn in place if stderr is a terminal, otherwise a plain line at long intervals, and nothing
// with --quiet. It can be updated at any rate: it limits its own output by the clock.
#pragma once

#include <chrono>
#include <functional>
#include <ostream>
#include <string>

namespace graze::apps {

class Progress {
 public:
  Progress(std::ostream& err, bool quiet, std::string what);
  ~Progress();  ///< erases the bar
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `fraction` in [0, 1], or negative if the end is unknown; `detail` is called only if something is printed.
  void update(double fraction, const std::function<std::string()>& detail);

 private:
  std::ostream& err_;
  bool quiet_;
  bool terminal_;
  bool drawn_ = false;
  std::string what_;
  std::chrono::steady_clock::time_point next_;
};

}  // namespace graze::apps
