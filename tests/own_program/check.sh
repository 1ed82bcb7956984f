#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# check.sh PROGRAM DATA: the command, its schema and its picture work like those of graze, which are there too. Conditions of its
# own give the points and orbits that graze finds in other ways.
set -euo pipefail
program=$(realpath "$1") data=$(realpath "$2") undamped=$(realpath "$(dirname "$0")")/undamped.toml
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

# The point located as multiplier -1 is the period doubling.
"$program" resonances "$undamped" --to 2.1 > points
doubling=$(sed -n 's/^UZ2 multiplier -1: //p' points)
"$program" continue "$undamped" --to 2.1 --switch 0 --quiet | grep -qF "PD1   $doubling"

# The two branches of three times the period are those that a global search finds.
"$program" resonances "$undamped" --to 2.8 > branches
"$program" orbit "$undamped" --set eta=2.8 --period 3 --search --quiet > found
born=$(sed -n 's/^from UZ1: period 3, eta = 2.8, multiplier //p' branches)
[[ $(sort -u <<< "$born" | wc -l) == 2 ]]
for multiplier in $born; do grep -qF " $multiplier" found; done
