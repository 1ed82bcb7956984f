// SPDX-License-Identifier: GPL-3.0-or-later
// What every command is given beside its own options: --quiet and --threads, and where notes go.
#pragma once

#include <ostream>
#include <string>

namespace graze::apps {

struct Console {
  std::ostream& out;   ///< results
  std::ostream& err;   ///< progress, notes, errors
  bool quiet = false;  ///< no progress and no notes
  int threads = 0;     ///< 0: as many as the machine has

  /// A line on stderr, unless --quiet.
  void note(const std::string& text) const {
    if (!quiet) err << "graze: " << text << "\n";
  }
};

}  // namespace graze::apps
