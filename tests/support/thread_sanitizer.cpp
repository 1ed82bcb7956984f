// SPDX-License-Identifier: GPL-3.0-or-later
// oneTBB is not compiled for ThreadSanitizer, which takes its tasks and their memory for races. (Handover in parallel.hpp tells
// it how the data of the tasks pass from thread to thread.)
// NOLINTNEXTLINE(bugprone-reserved-identifier)
extern "C" const char* __tsan_default_suppressions() { return "called_from_lib:libtbb.so\nrace:tbb::detail\nrace:libtbb.so\n"; }
