// SPDX-License-Identifier: GPL-3.0-or-later
// Ctrl-C, the time of --time, and what else asks the program to end: a flag that long computations look at, so that what they
// have so far is kept. The third Ctrl-C ends the program at once.
#pragma once

#include <optional>
#include <stdexcept>
#include <string>

namespace graze::apps {

/// Lets SIGINT, SIGTERM and (unless it is ignored, as under nohup) SIGHUP set the flag.
void watch_interrupts();

/// The time that --time gives a command, in seconds from now on; none: as much as it takes. When it is used up the command ends
/// as it would at Ctrl-C, but for its exit code.
class TimeBudget {
 public:
  explicit TimeBudget(std::optional<double> seconds);
  ~TimeBudget();
  TimeBudget(const TimeBudget&) = delete;
  TimeBudget& operator=(const TimeBudget&) = delete;
};

/// Handed to the libraries as `cancelled`: a signal has come, or the time is used up.
bool interrupted();

/// Whether it is the time, and no signal.
bool is_out_of_time();

/// How a sentence begins on what was interrupted: "interrupted", or "the 5 s of --time were used up".
std::string interruption();

/// How many signals have come.
int interruptions();

/// What was under way when a further signal came, after the computing was done. The program ends with 130.
struct Interrupted : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Sets or clears the flag, as a signal would; for tests.
void set_interrupted(bool value);

}  // namespace graze::apps
