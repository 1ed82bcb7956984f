#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# check.sh PROGRAM DATA: the command, its schema and its picture work like those of graze, which are there too.
set -euo pipefail
program=$(realpath "$1") data=$(realpath "$2")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"$program" settled "$data/problems/hertz-damped.toml" --json settled.json --plot settled.svg --quiet
grep -q '"schema": "graze.settled/1"' settled.json
"$program" plot settled.json --output again.svg --quiet
cmp settled.svg again.svg
"$program" schema settled | grep -q '"required"'
"$program" --help | grep -q 'the state on which a motion settles'
"$program" orbit "$data/problems/hertz-damped.toml" --quiet | grep -q 1/1
