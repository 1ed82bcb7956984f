// SPDX-License-Identifier: GPL-3.0-or-later
// Ctrl-C, and what else asks the program to end: a flag that long computations look at, so that what they have so far is kept.
// The third Ctrl-C ends the program at once.
#pragma once

#include <stdexcept>

namespace graze::apps {

/// Lets SIGINT, SIGTERM and (unless it is ignored, as under nohup) SIGHUP set the flag.
void watch_interrupts();

/// Handed to the libraries as `cancelled`.
bool interrupted();

/// How many signals have come.
int interruptions();

/// What was under way when a further signal came, after the computing was done. The program ends with 130.
struct Interrupted : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Sets or clears the flag, as a signal would; for tests.
void set_interrupted(bool value);

}  // namespace graze::apps
