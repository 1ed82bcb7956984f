// SPDX-License-Identifier: GPL-3.0-or-later
// Running gnuplot as a child. Script, picture and complaints go through temporary files, so that neither side can wait for the
// other.
#include <graze/apps/picture.hpp>

#include <fmt/format.h>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <stdexcept>

namespace graze::apps {

namespace {

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

File temporary_file() {
  File file(std::tmpfile(), std::fclose);
  if (!file) throw std::runtime_error(fmt::format("no temporary file can be made for gnuplot: {}", std::strerror(errno)));
  return file;
}

std::string content(std::FILE* file) {
  std::rewind(file);
  std::string text;
  char buffer[65536];
  while (const std::size_t size = std::fread(buffer, 1, sizeof buffer, file)) text.append(buffer, size);
  return text;
}

bool on_path(const char* program) {
  const char* path = std::getenv("PATH");
  std::string_view rest = path ? path : "/usr/bin:/bin";
  for (;;) {
    const std::size_t colon = rest.find(':');
    const std::filesystem::path candidate = std::filesystem::path(rest.substr(0, colon)) / program;
    if (::access(candidate.c_str(), X_OK) == 0) return true;
    if (colon == std::string_view::npos) return false;
    rest.remove_prefix(colon + 1);
  }
}

constexpr const char* missing = "pictures are drawn by gnuplot, which is not installed (Debian: apt install gnuplot-nox)";

}  // namespace

void check_picture_file(const std::string& file) {
  const std::string format = ending(file);
  if (format != "png" && format != "svg" && format != "pdf")
    throw std::invalid_argument(fmt::format("{}: a picture's name must end in .png, .svg or .pdf", file));
  if (!on_path("gnuplot")) throw std::invalid_argument(fmt::format("{}: {}", file, missing));
}

std::string draw(const Picture& picture, const std::string& format) {
  const std::string script = gnuplot_script(picture, format);
  const File input = temporary_file(), output = temporary_file(), complaints = temporary_file();
  if (std::fwrite(script.data(), 1, script.size(), input.get()) != script.size() || std::fflush(input.get()) != 0)
    throw std::runtime_error(
        fmt::format("the script for gnuplot cannot be written to the temporary folder: {}", std::strerror(errno)));
  std::rewind(input.get());

  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_init(&actions);
  posix_spawnattr_init(&attributes);
  posix_spawn_file_actions_adddup2(&actions, ::fileno(input.get()), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, ::fileno(output.get()), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, ::fileno(complaints.get()), STDERR_FILENO);
  // A process group of its own: Ctrl-C must not take the picture of what was computed.
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  char name[] = "gnuplot";
  char* const arguments[] = {name, nullptr};
  pid_t child = 0;
  const int error = ::posix_spawnp(&child, "gnuplot", &actions, &attributes, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  if (error == ENOENT) throw std::runtime_error(missing);
  if (error != 0) throw std::runtime_error(fmt::format("gnuplot cannot be started: {}", std::strerror(error)));

  int state = 0;
  while (::waitpid(child, &state, 0) < 0 && errno == EINTR) {
  }
  std::string drawn = content(output.get());
  if (!WIFEXITED(state) || WEXITSTATUS(state) != 0 || drawn.empty()) {
    std::string said = content(complaints.get());
    said.erase(0, said.find_first_not_of(" \n\t"));
    throw std::runtime_error(fmt::format("gnuplot drew nothing: {}", said.empty() ? "it did not say why" : said.substr(0, 300)));
  }
  return drawn;
}

}  // namespace graze::apps
