// SPDX-License-Identifier: GPL-3.0-or-later
#include <benchmark/benchmark.h>

int main(int argc, char** argv) {
  benchmark::AddCustomContext("compiler", GRAZE_BENCHMARK_COMPILER);
  benchmark::AddCustomContext("flags", GRAZE_BENCHMARK_FLAGS);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
