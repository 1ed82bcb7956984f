#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Installs missing packages, builds the release with its tests and runs them all. The last line is
# "N passed, N failed"; the exit code is 0 only if none failed.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

result="0 passed, 1 failed" # printed if the tests do not run
trap 'code=$?; echo "$result"; exit "$code"' EXIT

bash apps/install_packages.sh tests
cmake --preset release -DGRAZE_BUILD_TESTS=ON
cmake --build build --parallel "$(nproc)"

code=0
ctest --preset release -j 2 2>&1 | tee build/tests.log || code=$?
summary="$(grep -E 'tests passed, [0-9]+ tests failed out of [0-9]+$' build/tests.log | tail -n 1 || true)"
if [[ $summary =~ passed,\ ([0-9]+)\ tests\ failed\ out\ of\ ([0-9]+)$ ]]; then
  failed="${BASH_REMATCH[1]}"
  result="$((BASH_REMATCH[2] - failed)) passed, $failed failed"
fi
exit "$code"
