#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Installs what is missing, builds the release with its benchmarks in a folder of its own, runs them, and prints one table of
# ratios. Arguments go to Google Benchmark, for example
#   bash tests/benchmarks/run.sh --benchmark_filter=period/hertz
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

bash apps/install_packages.sh benchmarks
build=build-benchmarks
cmake --preset release -B "$build" -DGRAZE_BUILD_TESTS=OFF -DGRAZE_BUILD_BENCHMARKS=ON >&2
cmake --build "$build" --target graze_benchmarks --parallel "$(nproc)" >&2
# Repetitions are interleaved at random, so that other work on the machine meets all solvers alike.
"$build/tests/benchmarks/graze_benchmarks" --benchmark_min_time=0.05 --benchmark_repetitions=3 \
  --benchmark_enable_random_interleaving=true --benchmark_out="$build/benchmarks.json" --benchmark_out_format=json "$@" >&2
python3 tests/benchmarks/table.py "$build/benchmarks.json" | tee "$build/benchmarks.txt"
