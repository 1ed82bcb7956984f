// SPDX-License-Identifier: GPL-3.0-or-later
// What is the machine's peak? Independent chains of a multiplication and an addition each, in registers alone: nanoseconds for a
// thousand operations, one at a time (double), two (SSE2, what every x86-64 has), four (AVX2) and eight (AVX-512). Rounded
// separately they are two operations, fused (rows fused-lanes=N) they are one. The floor in period.cpp is counted in these.
#include <benchmark/benchmark.h>

namespace {

constexpr int chains = 12, rounds = 500;

template <class Number>
[[gnu::always_inline]] inline void multiply_and_add(benchmark::State& state, int lanes, double operations_each) {
  Number sum[chains];
  Number factor = Number{} + 0.999, addend = Number{} + 0.1;
  asm volatile("" : "+x"(factor), "+x"(addend));  // in registers, too: 14 of 16
  for (int i = 0; i < chains; ++i) sum[i] = Number{} + 1.0 + i;
  for (auto _ : state) {
    for (int round = 0; round < rounds; ++round) {
#pragma GCC unroll 16
      for (int i = 0; i < chains; ++i) {
        sum[i] = sum[i] * factor + addend;
        asm volatile("" : "+x"(sum[i]));  // stays in its register, is not computed ahead
      }
    }
  }
  const double operations = operations_each * chains * rounds * lanes;
  state.counters["seconds"] =
      benchmark::Counter(operations / 1000.0, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

using Two [[gnu::vector_size(16)]] = double;
void scalar(benchmark::State& state) { multiply_and_add<double>(state, 1, 2.0); }
void sse2(benchmark::State& state) { multiply_and_add<Two>(state, 2, 2.0); }
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
using Four [[gnu::vector_size(32)]] = double;
using Eight [[gnu::vector_size(64)]] = double;
[[gnu::target("avx2"), gnu::optimize("fp-contract=off")]] void avx2(benchmark::State& state) {
  multiply_and_add<Four>(state, 4, 2.0);
}
[[gnu::target("avx512f"), gnu::optimize("fp-contract=off")]] void avx512(benchmark::State& state) {
  multiply_and_add<Eight>(state, 8, 2.0);
}
[[gnu::target("avx2,fma"), gnu::optimize("fp-contract=fast")]] void fused_scalar(benchmark::State& state) {
  multiply_and_add<double>(state, 1, 1.0);
}
[[gnu::target("avx2,fma"), gnu::optimize("fp-contract=fast")]] void fused_avx2(benchmark::State& state) {
  multiply_and_add<Four>(state, 4, 1.0);
}
[[gnu::target("avx512f,fma"), gnu::optimize("fp-contract=fast")]] void fused_avx512(benchmark::State& state) {
  multiply_and_add<Eight>(state, 8, 1.0);
}
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
