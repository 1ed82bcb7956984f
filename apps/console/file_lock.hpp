// SPDX-License-Identifier: GPL-3.0-or-later
// FileLock: only one program at a time works at the place of this file. The lock is the kernel's (flock): it ends with the
// program in every case, and a file left behind by kill -9 locks nobody out.
#pragma once

#include <string>

namespace graze::apps {

class FileLock {
 public:
  /// Creates the file and locks it. @throws std::invalid_argument with `busy` if another program has locked it, or with the
  /// reason if it cannot be created.
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
