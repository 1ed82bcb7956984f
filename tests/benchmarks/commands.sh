#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Builds the program and times whole commands (see commands.py, which also describes the arguments), for example
#   bash tests/benchmarks/commands.sh --only sweep-up/hertz --rounds 3 --alone
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

build=build-benchmarks
bash tests/benchmarks/build.sh "$build" graze
python3 tests/benchmarks/commands.py "$build/apps/graze" "$@" | tee "$build/commands.txt"
