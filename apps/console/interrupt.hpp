// SPDX-License-Identifier: GPL-3.0-or-later
// Interruption by Ctrl-C, by the time limit --time, or by other signals: a flag that long computations poll, so that their
// results so far are kept. The third Ctrl-C ends the program at once.
#pragma once

#include <optional>
#include <stdexcept>
#include <string>

namespace graze::apps {

/// Lets SIGINT, SIGTERM and (unless it is ignored, as under nohup) SIGHUP set the flag.
void watch_interrupts();

/// The time limit --time of a command, in seconds from now; nullopt: no limit. At the limit the command ends as at Ctrl-C,
/// except for its exit code.
class TimeBudget {
 public:
  explicit TimeBudget(std::optional<double> seconds);
  ~TimeBudget();
  TimeBudget(const TimeBudget&) = delete;
  TimeBudget& operator=(const TimeBudget&) = delete;
};

/// Passed to the libraries as `cancelled`: a signal has arrived, or the time is used up.
bool interrupted();

/// Whether the time limit, rather than a signal, ended the command.
bool is_out_of_time();

/// The beginning of a sentence on the interruption: "interrupted", or "the 5 s of --time were used up".
std::string interruption();

/// Number of signals so far.
int interruptions();

/// Names the operation in progress when a further signal arrived after the computation. The program ends with 130.
struct Interrupted : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Sets or clears the flag, as a signal would; for tests.
void set_interrupted(bool value);

}  // namespace graze::apps
