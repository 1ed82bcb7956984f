// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/console/file_lock.hpp>

#include <fmt/format.h>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace graze::apps {

FileLock::FileLock(const std::string& file, const std::string& busy) : file_(file) {
  for (;;) {
    descriptor_ = ::open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor_ < 0) throw std::invalid_argument(fmt::format("{}: cannot be written: {}", file_, std::strerror(errno)));
    // A file system without locks fails with another errno; the program then runs without a lock.
    if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      ::close(descriptor_);
      throw std::invalid_argument(busy);
    }
    // A program that has just ended removes its file; a lock on that removed file would exclude nobody.
    if (is_there()) return;
    ::close(descriptor_);
  }
}

FileLock::~FileLock() {
  if (is_there()) ::unlink(file_.c_str());
  ::close(descriptor_);  // closing unlocks it
}

bool FileLock::is_there() const {
  struct stat locked = {};
  struct stat there = {};
  return ::fstat(descriptor_, &locked) == 0 && ::stat(file_.c_str(), &there) == 0 && there.st_ino == locked.st_ino &&
         there.st_dev == locked.st_dev;
}

}  // namespace graze::apps
