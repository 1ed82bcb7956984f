#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Builds the release with its benchmarks and runs them; arguments go to Google Benchmark, for example
#   bash tests/benchmarks/run.sh --benchmark_filter=hertz
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

bash apps/install_packages.sh benchmarks
cmake --preset release -DGRAZE_BUILD_BENCHMARKS=ON >&2
cmake --build build --target graze_benchmarks --parallel "$(nproc)" >&2
exec build/tests/benchmarks/graze_benchmarks "$@"
