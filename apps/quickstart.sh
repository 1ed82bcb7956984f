#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# From nothing to a picture: installs missing packages, builds graze, follows the orbit of the damped-Hertz
# oscillator from eta = 0.95 to 0.90 through its period doubling.
# usage: quickstart.sh [FOLDER]      FOLDER gets the picture and the JSON file; build/quickstart if not given
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
out="$(realpath -m "${1:-$root/build/quickstart}")"
cd "$root"
mkdir -p "$out"

bash apps/install_packages.sh run
# Without the tests, unless this build folder already has them.
grep -qs '^GRAZE_BUILD_TESTS:BOOL=ON' build/CMakeCache.txt || tests=-DGRAZE_BUILD_TESTS=OFF
cmake --preset release ${tests:+"$tests"}
cmake --build build --target graze --parallel "$(nproc)"

echo
build/apps/graze continue data/problems/hertz-damped.toml --param eta --from 0.95 --to 0.90 \
  --plot "$out/hertz-damped.png" --json "$out/hertz-damped.json"
echo
echo "Picture: $out/hertz-damped.png"
echo "Numbers: $out/hertz-damped.json"
