// SPDX-License-Identifier: GPL-3.0-or-later
// Peak performance of the machine: independent chains of a multiplication and an addition each, in registers alone. The result
// is the time in nanoseconds for a thousand operations: one at a time (double), two (SSE2, part of every x86-64), four (AVX2)
// and eight (AVX-512). With separate rounding they are two operations; fused (rows fused-lanes=N) they are one. The lower
// bound in period.cpp is counted in these.
#include <benchmark/benchmark.h>

namespace {

constexpr int chains = 12, rounds = 500;

/// Fused where the processor supports it (the compiler contracts them unless this is prevented).
template <bool Fused, class Number> [[gnu::always_inline]] inline void multiply_and_add(benchmark::State& state, int lanes) {
  Number factor = Number{} + 0.999, addend = Number{} + 0.1;
  benchmark::DoNotOptimize(factor);
  benchmark::DoNotOptimize(addend);
  Number a = factor, b = a + 1.0, c = a + 2.0, d = a + 3.0, e = a + 4.0, f = a + 5.0, g = a + 6.0, h = a + 7.0, i = a + 8.0,
         j = a + 9.0, k = a + 10.0, l = a + 11.0;
  // (Separate variables without a loop stay in registers.)
  const auto next = [&factor, &addend ](Number & x) __attribute__((always_inline)) {
    Number product = x * factor;
    if constexpr (!Fused) asm volatile("" : "+x"(product));
    x = product + addend;
  };
  for (auto _ : state) {
    for (int round = 0; round < rounds; ++round) {
      next(a), next(b), next(c), next(d), next(e), next(f), next(g), next(h), next(i), next(j), next(k), next(l);
      asm volatile("" : "+x"(a));  // not computed at compile time
    }
  }
  Number all = a + b + c + d + e + f + g + h + i + j + k + l;
  benchmark::DoNotOptimize(all);
  const double operations = (Fused ? 1.0 : 2.0) * chains * rounds * lanes;
  state.counters["seconds"] =
      benchmark::Counter(operations / 1000.0, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

using Two [[gnu::vector_size(16)]] = double;
void scalar(benchmark::State& state) { multiply_and_add<false, double>(state, 1); }
void sse2(benchmark::State& state) { multiply_and_add<false, Two>(state, 2); }
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
using Four [[gnu::vector_size(32)]] = double;
using Eight [[gnu::vector_size(64)]] = double;
[[gnu::target("avx2")]] void avx2(benchmark::State& state) { multiply_and_add<false, Four>(state, 4); }
[[gnu::target("avx512f")]] void avx512(benchmark::State& state) { multiply_and_add<false, Eight>(state, 8); }
[[gnu::target("avx2,fma")]] void fused_scalar(benchmark::State& state) { multiply_and_add<true, double>(state, 1); }
[[gnu::target("avx2,fma")]] void fused_avx2(benchmark::State& state) { multiply_and_add<true, Four>(state, 4); }
[[gnu::target("avx512f,fma")]] void fused_avx512(benchmark::State& state) { multiply_and_add<true, Eight>(state, 8); }
#endif

const bool registered = [] {
  benchmark::RegisterBenchmark("peak/lanes=1/graze", scalar);
  benchmark::RegisterBenchmark("peak/lanes=2/graze", sse2);
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
  if (__builtin_cpu_supports("avx2")) benchmark::RegisterBenchmark("peak/lanes=4/graze", avx2);
  if (__builtin_cpu_supports("avx512f")) benchmark::RegisterBenchmark("peak/lanes=8/graze", avx512);
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    benchmark::RegisterBenchmark("peak/fused-lanes=1/graze", fused_scalar);
    benchmark::RegisterBenchmark("peak/fused-lanes=4/graze", fused_avx2);
    if (__builtin_cpu_supports("avx512f")) benchmark::RegisterBenchmark("peak/fused-lanes=8/graze", fused_avx512);
  }
#endif
  return true;
}();

}  // namespace
