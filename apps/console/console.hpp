// SPDX-License-Identifier: GPL-3.0-or-later
// Context of every command beside its own options: --quiet and --threads, and the streams for results and notes.
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
  int threads = 0;     ///< 0: all available processors

  /// Number of threads: the requested number, or the number of processors available to this process.
  int thread_count() const { return threads > 0 ? threads : std::max(1, oneapi::tbb::info::default_concurrency()); }

  /// A line on stderr, unless --quiet.
  void note(const std::string& text) const {
    if (!quiet) err << "graze: " << text << "\n";
  }
};

/// "stdout: cannot be written: No space left on device"; `error`: errno after the failed write.
inline std::string cannot_write_stdout(int error) {
  return std::string("stdout: cannot be written") + (error ? std::string(": ") + std::strerror(error) : "");
}

}  // namespace graze::apps
