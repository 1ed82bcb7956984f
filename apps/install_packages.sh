#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Installs the Debian packages that graze needs and that are missing. If none is missing it does nothing, and
# needs neither root nor a network.
# usage: install_packages.sh [run] [tests] [benchmarks]
#   run          to build the program and draw pictures (always included)
#   tests        to build and run the tests
#   benchmarks   to build and run the benchmarks
set -euo pipefail

packages=(g++ cmake ninja-build pkg-config libeigen3-dev libgsl-dev libnlopt-dev libnlopt-cxx-dev libcli11-dev
  libtomlplusplus-dev nlohmann-json3-dev libfmt-dev libtbb-dev libxsimd-dev libhdf5-dev zlib1g-dev libopenmpi-dev openmpi-bin
  libmimalloc-dev fonts-dejavu-core)
command -v gnuplot > /dev/null || packages+=(gnuplot-nox) # any flavour that provides the command will do
for purpose in "$@"; do
  case "$purpose" in
    run) ;;
    tests) packages+=(catch2 hdf5-tools python3-h5py python3-jsonschema python3-numpy python3-scipy) ;;
    benchmarks) packages+=(libbenchmark-dev libboost-dev libsundials-dev) ;;
    *) echo "install_packages.sh: unknown purpose '$purpose'; known are run, tests, benchmarks" >&2; exit 2 ;;
  esac
done

if ! command -v dpkg-query > /dev/null || ! command -v apt-get > /dev/null; then
  echo "install_packages.sh: not a Debian system, nothing installed; graze needs the packages that Debian calls" \
    "${packages[*]}" >&2
  exit 0
fi

missing=()
for package in "${packages[@]}"; do
  status="$(dpkg-query -W -f '${Status}' "$package" 2> /dev/null || true)"
  [[ $status == *" installed" ]] || missing+=("$package")
done
[[ ${#missing[@]} -gt 0 ]] || exit 0

as_root=()
if [[ $EUID -ne 0 ]]; then
  # Without a terminal sudo must not ask for a password.
  if command -v sudo > /dev/null && { [[ -t 0 ]] || sudo -n true 2> /dev/null; }; then
    as_root=(sudo)
  else
    echo "install_packages.sh: these packages are missing and only root can install them:" \
      "apt-get install ${missing[*]}" >&2
    exit 1
  fi
fi

apt() {
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq -o Dpkg::Use-Pty=0 \
    -o DPkg::Lock::Timeout=300 -o Acquire::Retries=3 "$@" < /dev/null >&2
}
echo "Installing ${missing[*]}" >&2
apt update
apt install --yes --no-install-recommends "${missing[@]}"
