// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/console/output_file.hpp>

#include <fmt/format.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <future>
#include <stdexcept>
#include <utility>

namespace graze::apps {

namespace {

namespace fs = std::filesystem;

/// An error code; 0: success.
using Errno = int;

std::string cannot_write(const std::string& file, Errno error) {
  return fmt::format("{}: cannot be written: {}", file, std::strerror(error));
}

/// The error of a call that returns 0 or sets errno.
Errno errno_after(int returned) { return returned == 0 ? 0 : errno; }

Errno write_all(int descriptor, std::string_view content) {
  while (!content.empty()) {
    const ssize_t written = ::write(descriptor, content.data(), content.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    content.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

/// The file to which a name refers. Links are followed, so that a link stays a link, even if its target does not exist yet.
fs::path resolved(const std::string& file) {
  constexpr int most_links = 40;
  std::error_code error;
  fs::path target = fs::canonical(file, error);
  if (!error) return target;
  if (is_special(file)) return file;  // a pipe behind /dev/stdout has no name
  fs::path path = file;
  for (int i = 0; i < most_links && fs::is_symlink(path, error); ++i) path = path.parent_path() / fs::read_symlink(path, error);
  return fs::is_symlink(path, error) ? fs::path(file) : path;
}

fs::path folder_above(const fs::path& path) { return path.parent_path().empty() ? fs::path(".") : path.parent_path(); }

/// Ending of temporary files; mkstemp chooses the letters.
constexpr std::string_view temporary_ending = ".XXXXXX";

/// Opens a temporary file beside `path`; -1 with errno if it cannot be created.
int open_temporary(const fs::path& path, std::string& name) {
  name = (path.parent_path() / fmt::format(".{}{}", path.filename().string(), temporary_ending)).string();
  const int descriptor = ::mkstemp(name.data());
  if (descriptor < 0) return -1;
  // mkstemp creates private files; a result gets the permissions of the file it replaces, or those of any new file.
  struct stat existing = {};
  mode_t rights = 0;
  if (::stat(path.c_str(), &existing) == 0) {
    rights = existing.st_mode & 07777;
  } else {
    const mode_t mask = ::umask(0);
    ::umask(mask);
    rights = 0666 & ~mask;
  }
  ::fchmod(descriptor, rights);
  return descriptor;
}

/// Creates a temporary file and removes it. 0, or errno if it cannot be created.
int try_temporary(const fs::path& path) {
  std::string name;
  const int descriptor = open_temporary(path, name);
  if (descriptor < 0) return errno;
  ::close(descriptor);
  ::unlink(name.c_str());
  return 0;
}

struct CannotWrite {
  Errno error;
};

void check(Errno error) {
  if (error) throw CannotWrite{error};
}

/// A file that is being written.
class WholeFile {
 public:
  explicit WholeFile(const std::string& file) : path_(resolved(file)), special_(is_special(path_)) {}
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;
  ~WholeFile() {
    if (on_its_way_.valid()) on_its_way_.wait();
    if (descriptor_ >= 0) ::close(descriptor_);
    if (!temporary_.empty()) ::unlink(temporary_.c_str());
  }

  /// Opens the file at the first piece. @throws CannotWrite, like finish().
  void write(std::string_view piece) {
    open();
    check(write_all(descriptor_, piece));
    written_ += piece.size();
    if (written_ - sent_ >= worth_sending && !special_) send();
  }

  /// Puts the file in the place of the previous one.
  void finish() {
    open();
    arrive();
    // A pipe or a terminal cannot be synchronised (EINVAL), and need not be.
    if (const Errno error = errno_after(::fsync(descriptor_)); !special_) check(error);
    check(errno_after(::close(std::exchange(descriptor_, -1))));
    if (!special_) check(errno_after(::rename(temporary_.c_str(), path_.c_str())));
    temporary_.clear();
  }

 private:
  void open() {
    if (descriptor_ >= 0) return;
    descriptor_ = special_ ? ::open(path_.c_str(), O_WRONLY | O_CLOEXEC) : open_temporary(path_, temporary_);
    if (descriptor_ >= 0) return;
    const Errno error = errno;
    temporary_.clear();  // no temporary file exists
    throw CannotWrite{error};
  }

  /// Starts writing to the disc while the rest is produced, so that finish() waits less. (sync_file_range would leave the data
  /// in the disc's own cache.)
  void send() {
    if (on_its_way_.valid() && on_its_way_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    arrive();
    // On a separate thread, which sleeps until the disc is done; if none can be created, finish() does the work.
    on_its_way_ = std::async(std::launch::async | std::launch::deferred,
                             [descriptor = descriptor_] { return errno_after(::fdatasync(descriptor)); });
    sent_ = written_;
  }
  void arrive() {
    if (on_its_way_.valid()) check(on_its_way_.get());
  }

  static constexpr std::size_t worth_sending = 4 << 20;
  fs::path path_;
  bool special_;
  std::string temporary_;
  int descriptor_ = -1;
  std::size_t written_ = 0, sent_ = 0;
  std::future<Errno> on_its_way_;
};

}  // namespace

bool is_special(const std::string& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  return fs::exists(status) && !fs::is_regular_file(status);
}

void check_writable(const std::string& file) {
  std::error_code error;
  const fs::path path = resolved(file);
  if (fs::is_directory(path, error)) throw std::invalid_argument(file + ": cannot be written: it is a folder");
  if (!is_special(path) && fs::is_symlink(path, error)) throw std::invalid_argument(cannot_write(file, ELOOP));
  const fs::path folder = folder_above(path);
  if (!fs::is_directory(folder, error))
    throw std::invalid_argument(fmt::format("{}: cannot be written: there is no folder {}", file, folder.string()));
  if (fs::exists(path, error) && ::access(path.c_str(), W_OK) != 0) throw std::invalid_argument(cannot_write(file, errno));
  if (is_special(path)) return;
  if (const int failure = try_temporary(path)) throw std::invalid_argument(cannot_write(file, failure));
}

void check_writable_folder(const std::string& folder) {
  if (const int failure = try_temporary(resolved(folder) / "probe"))
    throw std::invalid_argument(
        fmt::format("{}: no files can be made in this folder: {}; give another", folder, std::strerror(failure)));
}

void check_distinct(const std::vector<NamedOutput>& outputs, const std::string& input) {
  const auto same = [](const std::string& a, const std::string& b) {
    std::error_code error;
    if (a.empty() || b.empty() || a == "-" || b == "-" || is_special(a)) return false;
    if (fs::equivalent(a, b, error)) return true;
    return fs::weakly_canonical(fs::absolute(a), error) == fs::weakly_canonical(fs::absolute(b), error);
  };
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const auto& [option, file] = outputs[i];
    if (same(file, input))
      throw std::invalid_argument(
          fmt::format("{} {}: this is the file that is read, {}; give the output another name", option, file, input));
    for (std::size_t j = 0; j < i; ++j)
      if (same(file, outputs[j].file))
        throw std::invalid_argument(fmt::format("{} {} and {} {} are one file; give each output its own name", outputs[j].option,
                                                outputs[j].file, option, file));
  }
}

void check_kind(const std::string& option, const std::string& file, const std::vector<std::string>& endings) {
  const auto among = [ending = fs::path(file).extension().string()](const std::vector<std::string>& list) {
    return std::find(list.begin(), list.end(), ending) != list.end();
  };
  if (among({".json", ".csv", ".h5", ".hdf5", ".png", ".svg", ".pdf", ".toml"}) && !among(endings))
    throw std::invalid_argument(fmt::format("{} {}: such a name is that of another kind of file; give one that ends in {}",
                                            option, file, fmt::join(endings, " or ")));
}

void check_regular(const std::string& option, const std::string& file) {
  if (is_special(file))
    throw std::invalid_argument(
        fmt::format("{} {}: this is a device, a pipe or a folder; give the name of a file, new or to be replaced", option, file));
}

std::optional<std::string> write_whole(const std::string& file, const LongText& content) try {
  WholeFile whole(file);
  content([&whole](std::string_view piece) { whole.write(piece); });
  whole.finish();
  return std::nullopt;
} catch (const CannotWrite& failure) {
  return cannot_write(file, failure.error);
}

std::optional<std::string> write_whole(const std::string& file, std::string_view content) {
  return write_whole(file, [content](const TextSink& sink) { sink(content); });
}

void remove_unfinished(const std::string& folder, const std::string& command) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const fs::path name = entry.path().filename(), of = name.stem();
    const bool of_command = name.string().starts_with("." + command + ".") || name.string().starts_with("." + command + "-");
    const bool of_result = of.extension() == ".json" || of.extension() == ".csv" || of.extension() == ".png";
    if (of_command && of_result && name.extension().string().size() == temporary_ending.size()) fs::remove(entry.path(), error);
  }
}

std::string folder_of(const std::string& file) { return folder_above(resolved(file)).string(); }

std::optional<std::string> sync_folder(const std::string& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return cannot_write(folder, errno);
  // A file system without this function returns EINVAL, and has its own means.
  Errno error = ::fsync(descriptor) != 0 && errno != EINVAL ? errno : 0;
  ::close(descriptor);
  return error ? std::optional(cannot_write(folder, error)) : std::nullopt;
}

void make_folder(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder))
    throw std::invalid_argument(
        fmt::format("{}: cannot be made as a folder: {}", folder, error ? error.message() : "a file has this name"));
}

}  // namespace graze::apps
