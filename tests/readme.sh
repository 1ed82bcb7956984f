#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Runs what README.md shows and compares the output, letter by letter:
#   the first ```cpp block, built against the installed package, with the ```text block that follows it;
#   the first ```console block: each line `$ command` (in bash, from the source folder, with graze on PATH),
#   with the lines that follow it.
# usage: readme.sh GRAZE_PROGRAM WORK_FOLDER      (the package is found by CMAKE_PREFIX_PATH)
set -euo pipefail
source_folder="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
program="$(realpath "$1")"
work="$(realpath -m "$2")"
readme="$source_folder/README.md"

fail() { echo "README.md: $*" >&2; exit 1; }

# block LANGUAGE [AFTER]: the first block in that language, or the first one that begins after line AFTER.
block() {
  awk -v fence='```'"$1" -v after="${2:-0}" '
    !inside && NR > after && $0 == fence { inside = 1; next }
    inside && $0 == "```" { closed = 1; exit }
    inside { print }
    END { exit !closed }' "$readme" || fail "no complete \`\`\`$1 block${2:+ after line $2}"
}

# same WHAT EXPECTED ACTUAL
same() {
  diff -u --label "README.md" --label "$1" <(printf '%s\n' "$2") <(printf '%s\n' "$3") ||
    fail "shows another output than '$1' gives (above: - README.md, + as computed)"
}

rm -rf "$work"
mkdir -p "$work/program"
block cpp > "$work/program/main.cpp"
cp "$source_folder/tests/consumer/CMakeLists.txt" "$work/program/"
cmake -S "$work/program" -B "$work/build" >&2
cmake --build "$work/build" >&2
first_line="$(grep -n -m 1 -x '```cpp' "$readme")"
expected="$(block text "${first_line%%:*}")"
actual="$("$work/build/consumer")" || fail "the program exits with $?"
same "the C++ program" "$expected" "$actual"

cd "$source_folder"
export PATH="${program%/*}:$PATH"
command=
expected=
commands=0
check() {
  [[ -n $command ]] || return 0
  local actual
  actual="$(bash -c "$command" < /dev/null)" || fail "'$command' exits with $?"
  same "$command" "${expected%"${expected##*[!$'\n']}"}" "$actual"
  commands=$((commands + 1))
}
session="$(block console)"
while IFS= read -r line; do
  if [[ $line == '$ '* ]]; then
    check
    command="${line:2}"
    expected=
  else
    [[ -n $command ]] || fail "the console block does not begin with a line '\$ command'"
    expected+="$line"$'\n'
  fi
done <<< "$session"
check
[[ $commands -gt 0 ]] || fail "the console block has no line '\$ command'"
echo "README.md: the program and $commands commands give what it shows"
