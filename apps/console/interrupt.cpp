// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/console/checkpoint_timer.hpp>
#include <graze/apps/console/interrupt.hpp>
#include <graze/apps/text/number.hpp>

#include <fmt/format.h>

#include <atomic>
#include <csignal>
#include <limits>

namespace graze::apps {

namespace {

std::atomic<int> signals{0};
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler may touch lock-free atomics only");

constexpr double unlimited = std::numeric_limits<double>::infinity();
std::atomic<double> budget{unlimited}, deadline{unlimited};  // in seconds

/// Reads the clock only if there is a deadline.
bool is_late() {
  const double until = deadline.load(std::memory_order_relaxed);
  return until < unlimited && steady_seconds() >= until;
}

extern "C" void on_signal(int signal) {
  // Two signals are not yet impatience: timeout(1) sends one to the program and then one to its process group. SIGHUP never
  // ends the program at once: when a terminal closes, the shell signals its jobs and the kernel signals them again.
  if (signals.fetch_add(1) >= 2 && signal != SIGHUP) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
}

}  // namespace

void watch_interrupts() {
  struct sigaction action = {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;  // a result that is being written is completed
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  // Under nohup SIGHUP is ignored from the start, and the program must continue.
  struct sigaction before = {};
  sigaction(SIGHUP, nullptr, &before);
  if (before.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);
}

TimeBudget::TimeBudget(std::optional<double> seconds) {
  budget = seconds.value_or(unlimited);
  deadline = steady_seconds() + budget;
}

TimeBudget::~TimeBudget() { deadline = budget = unlimited; }

bool interrupted() { return signals.load() > 0 || is_late(); }

bool is_out_of_time() { return signals.load() == 0 && is_late(); }

std::string interruption() {
  return is_out_of_time() ? fmt::format("the {} s of --time were used up", exact(budget)) : "interrupted";
}

int interruptions() { return signals.load(); }

void set_interrupted(bool value) { signals.store(value ? 1 : 0); }

}  // namespace graze::apps
