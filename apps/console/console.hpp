// SPDX-License-Identifier: GPL-3.0-or-later
// What every command is given beside its own options: --quiet and --threads, and where notes go.
#pragma once

#include <oneapi/tbb/info.h>

#include <algorithm>
#include <cstring>
#include <ostream>
#include <string>

namespace graze::apps {

struct Console {
  std::ostream& out;   ///< results
  std::ostream& err;   ///< progress, notes, errors
  bool quiet = false;  ///< no progress and no notes
  int threads = 0;     ///< 0: as many as there are processors

  /// Threads to use: those asked for, or as many as there are processors that this process may run on.
  int thread_count() const { return threads > 0 ? threads : std::max(1, oneapi::tbb::info::default_concurrency()); }

  /// A line on stderr, unless --quiet.
  void note(const std::string& text) const {
    if (!quiet) err << "graze: " << text << "\n";
  }
};

/// "stdout: cannot be written: No space left on device"; `error`: errno as the writing left it.
inline std::string cannot_write_stdout(int error) {
  return std::string("stdout: cannot be written") + (error ? std::string(": ") + std::strerror(error) : "");
}

}  // namespace graze::apps
