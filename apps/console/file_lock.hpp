// SPDX-License-Identifier: GPL-3.0-or-later
// FileLock: one program at a time works where this file is. The lock is the kernel's (flock): it ends with the program, however
// that ends, and the file that kill -9 leaves behind locks nobody out.
#pragma once

#include <string>

namespace graze::apps {

class FileLock {
 public:
  /// Makes the file and locks it. @throws std::invalid_argument with `busy` if another program has locked it, or with the reason
  /// why it cannot be made.
  FileLock(const std::string& file, const std::string& busy);
  /// Removes the file.
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

 private:
  bool is_there() const;

  std::string file_;
  int descriptor_ = -1;
};

}  // namespace graze::apps
