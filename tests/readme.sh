#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Runs the examples of README.md and of the pages it links to, and compares their output character by character:
#   the first ```cpp block of README.md, built against the installed package, with the ```text block that follows it;
#   each ```console block of each page: every line `$ command`, with the lines that follow it as its output.
# The commands of a page run in bash, in order, in a separate folder, with graze on PATH. The folder has the data/ of the source
# tree, and each ```toml block of the page that begins with a line `# NAME.toml` as that file.
# A ```c++ block whose first line is `// FILE` is a part of that file, a C++ source of the tests.
# Relative links of the pages must lead to existing files and headings.
# usage: readme.sh GRAZE_PROGRAM WORK_FOLDER      (the package is found by CMAKE_PREFIX_PATH)
set -euo pipefail
source_folder="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
program="$(realpath "$1")"
work="$(realpath -m "$2")"
cd "$source_folder"
pages=(README.md lib/README.md tests/benchmarks/README.md data/guide/*.md)

fail() { echo "$page: $*" >&2; exit 1; }

# block LANGUAGE [AFTER]: the first block of the page in that language, or the first one that begins after line AFTER.
block() {
  awk -v fence='```'"$1" -v after="${2:-0}" '
    !inside && NR > after && $0 == fence { inside = 1; next }
    inside && $0 == "```" { closed = 1; exit }
    inside { print }
    END { exit !closed }' "$source_folder/$page" || fail "no complete \`\`\`$1 block${2:+ after line $2}"
}

# same WHAT EXPECTED ACTUAL
same() {
  diff -u --label "$page" --label "$1" <(printf '%s\n' "$2") <(printf '%s\n' "$3") ||
    fail "shows another output than '$1' gives (above: - $page, + as computed)"
}

# Writes the files of the page, and prints its console blocks one after the other.
unpack() {
  awk -v folder="$session" '
    block == "toml" && first && /^# [a-z-]+\.toml$/ { file = folder "/" $2 }
    block && /^```$/ { block = file = ""; next }
    block == "toml" && file { print > file }
    block == "console" && first && !/^\$ / { print "a console block begins with: " $0 > "/dev/stderr"; exit 1 }
    block == "console" { print }
    { first = 0 }
    !block && /^```/ { block = substr($0, 4); if (!block) block = "plain"; first = 1 }
    END { if (block) { print "a block is not closed" > "/dev/stderr"; exit 1 } }' "$source_folder/$page"
}

check() {
  [[ -n $command ]] || return 0
  local actual
  actual="$(cd "$session" && bash -c "$command" < /dev/null)" || fail "'$command' exits with $?"
  same "$command" "${expected%"${expected##*[!$'\n']}"}" "$actual"
  commands=$((commands + 1))
}

# Headings in the form used by links.
headings() { sed -n '/^```/,/^```/d; s/^##* //p' "$1" | tr '[:upper:]' '[:lower:]' | sed 's/[^a-z0-9 _-]//g; s/ /-/g'; }

check_links() {
  local link target
  while IFS= read -r link; do
    target="${link%%#*}"
    target="${target:+$(dirname "$page")/$target}"
    [[ -e ${target:=$page} ]] || fail "links to $link, which is not there"
    [[ $link != *'#'* ]] || headings "$target" | grep -qxF "${link#*#}" || fail "links to $link; $target has no such heading"
  done < <(grep -oE '\]\([^) ]+\)' "$page" | sed 's/^](//; s/)$//' | grep -v '^https\?:' || true)
}

# Compares each ```c++ block that begins with `// FILE` with that file.
check_excerpts() {
  local line text= file= inside=
  while IFS= read -r line; do
    if [[ -z $inside && $line == '```c++' ]]; then
      inside=first
    elif [[ $inside && $line == '```' ]]; then
      if [[ $file ]]; then
        [[ $text && "$(<"$file")"$'\n' == *$'\n'"$text"* ]] || fail "shows a part of $file that is not there: ${text%%$'\n'*}"
      fi
      text= file= inside=
    elif [[ $inside == first ]]; then
      inside=yes
      [[ ! $line =~ ^//\ (tests/[a-z_/]+\.cpp)$ ]] || file=${BASH_REMATCH[1]}
    elif [[ $inside ]]; then
      text+=$line$'\n'
    fi
  done < "$page"
}

rm -rf "$work"
mkdir -p "$work/program"
page=README.md
block cpp > "$work/program/main.cpp"
cp tests/consumer/CMakeLists.txt "$work/program/"
cmake -S "$work/program" -B "$work/build" >&2
cmake --build "$work/build" >&2
first_line="$(grep -n -m 1 -x '```cpp' "$page")"
expected="$(block text "${first_line%%:*}")"
actual="$("$work/build/consumer")" || fail "the program exits with $?"
same "the C++ program" "$expected" "$actual"

export PATH="${program%/*}:$PATH"
total=0
for page in "${pages[@]}"; do
  check_links
  check_excerpts
  session="$work/session/${page%.md}"
  mkdir -p "$session"
  ln -s "$source_folder/data" "$session/data"
  lines="$(unpack)" || fail "cannot be read"
  command=
  expected=
  commands=0
  while IFS= read -r line; do
    if [[ $line == '$ '* ]]; then
      check
      command="${line:2}"
      expected=
    else
      expected+="$line"$'\n'
    fi
  done <<< "$lines"
  check
  [[ $commands -gt 0 || $page != README.md ]] || fail "has no console block"
  total=$((total + commands))
done
echo "README.md and its pages: the program and $total commands give what they show"
