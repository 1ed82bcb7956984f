// SPDX-License-Identifier: GPL-3.0-or-later
// Ctrl-C: a flag that long computations look at, so that what they have so far is kept. The third one ends the program at once.
#pragma once

namespace graze::apps {

/// Lets SIGINT and SIGTERM set the flag.
void watch_interrupts();

/// Handed to the libraries as `cancelled`.
bool interrupted();

/// Sets or clears the flag, as a signal would; for tests.
void set_interrupted(bool value);

}  // namespace graze::apps
