// SPDX-License-Identifier: GPL-3.0-or-later
// Progress on stderr: a bar that is drawn over itself when stderr is a terminal, a plain line now and then when it is not,
// nothing with --quiet. Update it as often as you like; it looks at the clock.
#pragma once

#include <chrono>
#include <functional>
#include <ostream>
#include <string>

namespace graze::apps {

class Progress {
 public:
  Progress(std::ostream& err, bool quiet, std::string what);
  ~Progress();  ///< wipes the bar
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `fraction` in [0, 1], or negative where the end is not known; `detail` is called only when something is printed.
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
