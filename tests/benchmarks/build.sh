#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Installs the required packages and builds a target of the release with its benchmarks in a separate folder.
# usage: build.sh FOLDER TARGET
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

bash apps/install_packages.sh benchmarks
cmake --preset release -B "$1" -DGRAZE_BUILD_TESTS=OFF -DGRAZE_BUILD_BENCHMARKS=ON >&2
cmake --build "$1" --target "$2" --parallel "$(nproc)" >&2
