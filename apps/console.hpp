// SPDX-License-Identifier: GPL-3.0-or-later
// What every command is given beside its own options: --quiet and --threads, and where notes go.
#pragma once

#include <algorithm>
#include <ostream>
#include <string>
#include <thread>

namespace graze::apps {

struct Console {
  std::ostream& out;   ///< results
  std::ostream& err;   ///< progress, notes, errors
  bool quiet = false;  ///< no progress and no notes
  int threads = 0;     ///< 0: as many as the machine has

  /// Threads to use: those asked for, or all that the machine has.
  int thread_count() const { return threads > 0 ? threads : static_cast<int>(std::max(1U, std::thread::hardware_concurrency())); }

  /// A line on stderr, unless --quiet.
  void note(const std::string& text) const {
    if (!quiet) err << "graze: " << text << "\n";
  }
};

}  // namespace graze::apps
