#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Builds the benchmarks, runs them, and prints one table of ratios. Arguments are passed to Google Benchmark, for example
#   bash tests/benchmarks/run.sh --benchmark_filter=period/hertz
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

build=build-benchmarks
bash tests/benchmarks/build.sh "$build" graze_benchmarks
# Repetitions are interleaved at random, so that other work on the machine affects all solvers equally.
"$build/tests/benchmarks/graze_benchmarks" --benchmark_min_time=0.05 --benchmark_repetitions=3 \
  --benchmark_enable_random_interleaving=true --benchmark_out="$build/benchmarks.json" --benchmark_out_format=json "$@" >&2
python3 tests/benchmarks/table.py "$build/benchmarks.json" | tee "$build/benchmarks.txt"
