// SPDX-License-Identifier: GPL-3.0-or-later
// Runs gnuplot as a child process. Script, picture and error messages pass through temporary files, so that neither process can
// wait for the other.
#include <graze/apps/console/interrupt.hpp>
#include <graze/apps/drawing/picture.hpp>

#include <fmt/format.h>

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <thread>

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

constexpr int not_started = 127;  // exit code of a child that could not execute gnuplot

/// Starts gnuplot with these files as its standard streams. It dies with this program in every case.
pid_t start_gnuplot(int input, int output, int complaints) {
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child < 0) throw std::runtime_error(fmt::format("gnuplot cannot be started: {}", std::strerror(errno)));
  if (child > 0) return child;
  // Between fork and exec only async-signal-safe calls: there may be threads.
  ::setpgid(0, 0);  // Ctrl-C must not destroy the picture of finished results
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() == parent && ::dup2(input, STDIN_FILENO) >= 0 && ::dup2(output, STDOUT_FILENO) >= 0 &&
      ::dup2(complaints, STDERR_FILENO) >= 0)
    ::execlp("gnuplot", "gnuplot", "/dev/stdin", static_cast<char*>(nullptr));  // as a file: gnuplot reads stdin byte by byte
  const char* reason = errno == ENOENT ? "it is not installed" : "the system refuses";
  static_cast<void>(!::write(complaints, reason, std::strlen(reason)));
  ::_exit(not_started);
}

}  // namespace

void check_picture_file(const std::string& file) {
  const std::string format = ending(file);
  if (format != "png" && format != "svg" && format != "pdf")
    throw std::invalid_argument(fmt::format("{}: a picture's name must end in .png, .svg or .pdf", file));
}

bool can_draw() { return on_path("gnuplot"); }

std::string draw(const Picture& picture, const std::string& format) {
  const std::string script = gnuplot_script(picture, format);
  const File input = temporary_file(), output = temporary_file(), complaints = temporary_file();
  if (std::fwrite(script.data(), 1, script.size(), input.get()) != script.size() || std::fflush(input.get()) != 0)
    throw std::runtime_error(
        fmt::format("the script for gnuplot cannot be written to the temporary folder: {}", std::strerror(errno)));
  std::rewind(input.get());

  const int before = interruptions();
  const pid_t child = start_gnuplot(::fileno(input.get()), ::fileno(output.get()), ::fileno(complaints.get()));
  int state = 0;
  for (long nap = 1; ::waitpid(child, &state, WNOHANG) == 0; nap = std::min(2 * nap, 20L)) {
    std::this_thread::sleep_for(std::chrono::milliseconds(nap));
    // The signal that ended the computation still allows the picture of its results; a later one is meant for the drawing.
    if (interruptions() == before) continue;
    ::kill(child, SIGKILL);
    ::waitpid(child, &state, 0);
    throw Interrupted("drawing was interrupted");
  }
  if (WIFEXITED(state) && WEXITSTATUS(state) == not_started)
    throw std::runtime_error(fmt::format("gnuplot cannot be started: {}", content(complaints.get())));
  std::string drawn = content(output.get());
  if (!WIFEXITED(state) || WEXITSTATUS(state) != 0 || drawn.empty()) {
    std::string said = content(complaints.get());
    said.erase(0, said.find_first_not_of(" \n\t"));
    throw std::runtime_error(fmt::format("gnuplot drew nothing: {}", said.empty() ? "it did not say why" : said.substr(0, 300)));
  }
  return drawn;
}

}  // namespace graze::apps
