// SPDX-License-Identifier: GPL-3.0-or-later
// Parallel loops on the threads of the caller's arena (oneTBB).
#pragma once

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/partitioner.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cstddef>

#ifdef __SANITIZE_THREAD__
extern "C" void __tsan_acquire(void*);
extern "C" void __tsan_release(void*);
#endif

namespace graze {

/// Number of threads available here. (An arena ignores the global limit.)
inline std::size_t available_threads() {
  using oneapi::tbb::global_control;
  const auto in_arena = static_cast<std::size_t>(std::max(1, oneapi::tbb::this_task_arena::max_concurrency()));
  return std::min(in_arena, global_control::active_value(global_control::max_allowed_parallelism));
}

/// n / by, rounded up: number of parts of a given size, or size of a given number of parts.
constexpr std::size_t divide_rounding_up(std::size_t n, std::size_t by) { return (n + by - 1) / by; }

/// Tells ThreadSanitizer that another thread may read after take() the data that this one wrote before give(): it does not see
/// how oneTBB synchronises its threads.
struct Handover {
#ifdef __SANITIZE_THREAD__
  void give() const { __tsan_release(const_cast<Handover*>(this)); }
  void take() const { __tsan_acquire(const_cast<Handover*>(this)); }
#else
  void give() const {}
  void take() const {}
#endif
};

/// Calls loop(one), which calls one(i) on several threads; one(i) calls body(i).
template <class Body, class Loop> void hand_over(const Body& body, const Loop& loop) {
  const Handover begin, end;
  begin.give();
  loop([&](std::size_t i) {
    begin.take();
    body(i);
    end.give();
  });
  end.take();
}

/// Calls body(0) ... body(n - 1) in any order. A thread that waits for the rest takes no other work meanwhile, because it would
/// have to finish that first.
template <class Body> void in_parallel(std::size_t n, const Body& body) {
  if (n == 1) return body(std::size_t{0});
  hand_over(body, [n](const auto& one) {
    oneapi::tbb::this_task_arena::isolate([&] { oneapi::tbb::parallel_for(std::size_t{0}, n, one); });
  });
}

/// Calls body(0) ... body(n - 1), each a job of its own, in any order on an arena of this many threads (at least one). A thread
/// that waits for the rest helps with the loops within other jobs.
template <class Body> void in_parallel_on(int threads, std::size_t n, const Body& body) {
  hand_over(body, [&](const auto& one) {
    oneapi::tbb::task_arena(std::max(1, threads)).execute([&] {
      oneapi::tbb::parallel_for(std::size_t{0}, n, one, oneapi::tbb::simple_partitioner());
    });
  });
}

/// The same on all threads, or in order on this one.
template <class Body> void for_each_index(bool all_threads, std::size_t n, const Body& body) {
  if (all_threads) return in_parallel(n, body);
  for (std::size_t i = 0; i < n; ++i) body(i);
}

}  // namespace graze
