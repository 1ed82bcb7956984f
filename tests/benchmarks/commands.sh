#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Installs what is needed, builds the release in a folder of its own, and times whole commands (commands.py says how; its
# arguments can be given), for example
#   bash tests/benchmarks/commands.sh --only sweep-up/hertz --rounds 3 --alone
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

bash apps/install_packages.sh benchmarks
build=build-benchmarks
cmake --preset release -B "$build" -DGRAZE_BUILD_TESTS=OFF -DGRAZE_BUILD_BENCHMARKS=ON >&2
cmake --build "$build" --target graze --parallel "$(nproc)" >&2
python3 tests/benchmarks/commands.py "$build/apps/graze" "$@" | tee "$build/commands.txt"
