// SPDX-License-Identifier: GPL-3.0-or-later
// Fuzzer: randomly damaged inputs of the program. Each input must end in success or in std::invalid_argument with one
// sentence, in bounded time.
//
//     fuzz [--kind NAME] [--count N] [--first K] [--seed S] [--seconds T] [--keep DIR]  N mutations of each kind (default 2000)
//     fuzz --kind NAME FILE ...                                                          these inputs alone
//
// First come the files of corpus/NAME, which once failed, then mutations of them and of valid inputs. Expensive kinds have
// fewer inputs. An input that fails is written to DIR (default: the current folder). A crash or a hang ends the program after
// it has written the input. Input K of a seed does not depend on the inputs before it.
#include "inputs.hpp"

#include <graze/lib/equations/source.hpp>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>

using namespace graze::fuzz;
namespace fs = std::filesystem;

namespace {

constexpr std::size_t most_reported = 20;  // sorts of failures of a kind

struct Options {
  std::string kind, keep = ".";
  std::size_t count = 2000, first = 0;
  std::uint64_t seed = 1;
  unsigned seconds = 20;
  std::vector<std::string> files;
};

// For the signal handler: the current input, and the name of the file to which it is written.
const std::string* current = nullptr;
char kept_as[4096];

extern "C" void keep_current_input(int signal) {
  if (current != nullptr) {
    const int file = ::open(kept_as, O_WRONLY | O_CREAT | O_TRUNC, 0644);
    static_cast<void>(!::write(file, current->data(), current->size()));
    const char text[] = "fuzz: it crashed or took too long; the input is in ";
    static_cast<void>(!::write(2, text, sizeof text - 1));
    static_cast<void>(!::write(2, kept_as, std::char_traits<char>::length(kept_as)));
    static_cast<void>(!::write(2, "\n", 1));
  }
  ::_exit(128 + signal);
}

void catch_signals() {
  static char stack[65536];  // the usual stack may be used up
  stack_t other = {};
  other.ss_sp = stack;
  other.ss_size = sizeof stack;
  ::sigaltstack(&other, nullptr);
  struct sigaction action = {};
  action.sa_handler = keep_current_input;
  action.sa_flags = SA_ONSTACK;
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGPROF}) ::sigaction(signal, &action, nullptr);
}

#if !defined(__SANITIZE_ADDRESS__)
/// Limits the memory, so that an excessive request fails instead of the machine.
void limit_memory() {
  const rlimit limit{4UL << 30U, 4UL << 30U};
  ::setrlimit(RLIMIT_AS, &limit);
}
#else
void limit_memory() {}
#endif

/// Empty: the message is a valid sentence. The message on an equation shows its line and marks the place below.
std::string fault_of(const std::string& message, bool shows_line) {
  if (message.empty()) return "a message without words";
  for (const char* internal : {"json.exception", "std::", "basic_string", "vector::", "map::at", "bad_alloc"})
    if (message.find(internal) != std::string::npos) return "internals in a message: " + message;
  if (message == "stoi" || message == "stod") return "the words of the library alone: " + message;
  const auto breaks = std::count(message.begin(), message.end(), '\n');
  if (breaks != 0 && !(shows_line && breaks == 2)) return "a message of several lines: " + message;
  return {};
}

/// Limits the processor time, because the machine may be busy. 0: no limit.
void allow_time(unsigned seconds) {
  itimerval timer = {};
  timer.it_value.tv_sec = static_cast<time_t>(seconds);
  ::setitimer(ITIMER_PROF, &timer, nullptr);
}

/// Empty: no fault.
std::string fault_of(const Kind& kind, const std::string& input, const Options& options) {
  std::string fault;
  current = &input;
  allow_time(options.seconds);
  try {
    kind.take(input);
  } catch (const std::invalid_argument& error) {
    fault = fault_of(error.what(), dynamic_cast<const graze::equations::EquationError*>(&error) != nullptr);
  } catch (const std::exception& error) {
    fault = fmt::format("another exception: {}", error.what());
  }
  allow_time(0);
  current = nullptr;
  return fault;
}

std::string content(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// A fault without the parts that depend on the input.
std::string failure_class(const std::string& fault) {
  std::string text;
  bool quoted = false;
  for (const char c : fault) {
    if (c == '"' || c == '\'') quoted = !quoted;
    if (!quoted && !std::isdigit(static_cast<unsigned char>(c))) text += c;
  }
  return text.substr(0, 80);
}

/// The number of failures.
std::size_t fuzz(const Kind& kind, const Options& options) {
  const auto begin = std::chrono::steady_clock::now();
  std::map<std::string, std::size_t> faults;
  std::size_t failures = 0, inputs = 0;
  const auto take = [&](const std::string& input, const std::string& name) {
    std::snprintf(kept_as, sizeof kept_as, "%s/fuzz-%s-%s", options.keep.c_str(), kind.name.c_str(), name.c_str());
    ++inputs;
    const std::string fault = fault_of(kind, input, options);
    if (fault.empty()) return;
    ++failures;
    if (++faults[failure_class(fault)] > 1 || faults.size() > most_reported) return;
    std::ofstream(kept_as, std::ios::binary) << input;
    fmt::print(stderr, "fuzz: {} {}: {}\n", kind.name, name, fault.substr(0, 400));
  };
  std::vector<std::string> seeds;
  if (!options.files.empty()) {
    for (const std::string& file : options.files) take(content(file), fs::path(file).filename());
  } else {
    seeds = kind.seeds();
    for (std::size_t k = 0; k < seeds.size(); ++k)
      if (options.first == 0) take(seeds[k], fmt::format("seed-{}", k));
    std::vector<fs::path> corpus;
    std::error_code none;
    for (const fs::directory_entry& entry : fs::directory_iterator(fs::path(GRAZE_FUZZ_CORPUS) / kind.name, none))
      corpus.push_back(entry.path());
    std::sort(corpus.begin(), corpus.end());
    for (const fs::path& file : corpus) {
      take(content(file), file.filename());
      seeds.push_back(content(file));
    }
    const std::size_t count = (options.count + kind.cost - 1) / kind.cost;
    for (std::size_t k = options.first; k < options.first + count; ++k) {
      Dice dice(options.seed * 0x100000001b3ULL + k);
      std::string input = mutated(seeds, kind.form, kind.words, dice);
      if (kind.mend) kind.mend(input, dice);
      take(input, fmt::format("{}-{}", options.seed, k));
    }
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  fmt::print("{:<18} {:>8} inputs {:>8.1f} s {:>6} failures\n", kind.name, inputs, seconds, failures);
  std::fflush(stdout);
  return failures;
}

Options options_of(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (!name.starts_with("--")) {
      options.files.push_back(name);
      continue;
    }
    if (++i == argc) throw std::invalid_argument(name + " lacks its value");
    const std::string value = argv[i];
    if (name == "--kind")
      options.kind = value;
    else if (name == "--keep")
      options.keep = value;
    else if (name == "--count")
      options.count = std::stoul(value);
    else if (name == "--first")
      options.first = std::stoul(value);
    else if (name == "--seed")
      options.seed = std::stoul(value);
    else if (name == "--seconds")
      options.seconds = static_cast<unsigned>(std::stoul(value));
    else
      throw std::invalid_argument(fmt::format("there is no option {}", name));
  }
  if (!options.files.empty() && options.kind.empty()) throw std::invalid_argument("give the kind of these files by --kind");
  return options;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const Options options = options_of(argc, argv);
    ::setenv("PATH", "/nonexistent", 1);  // pictures are not drawn: gnuplot is not under test
    limit_memory();
    catch_signals();
    std::size_t failures = 0;
    bool any = false;
    for (const Kind& kind : kinds()) {
      if (!options.kind.empty() && kind.name != options.kind) continue;
      any = true;
      failures += fuzz(kind, options);
    }
    if (!any) throw std::invalid_argument(fmt::format("there is no kind {}", options.kind));
    return failures == 0 ? 0 : 1;
  } catch (const std::exception& error) {
    fmt::print(stderr, "fuzz: {}\n", error.what());
    return 2;
  }
}
