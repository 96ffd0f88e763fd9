#!/usr/bin/env bash
# Checks (or with --fix mends) the formatting of all sources with clang-format 14. Exit code 77: there is no such
# clang-format here.
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
for formatter in clang-format-14 clang-format ""; do
  [ -n "$formatter" ] || { echo "clang-format 14 is not here: not checked"; exit 77; }
  "$formatter" --version 2>/dev/null | grep -q 'version 14\.' && break
done
cd "$ROOT"
mapfile -t sources < <(find include src factors tools benchmarks tests docs '(' -name '*.cc' -o -name '*.h' ')' 2>/dev/null | sort)
if [ "${1:-}" = --fix ]; then
  "$formatter" -i "${sources[@]}"
else
  "$formatter" --dry-run -Werror "${sources[@]}"
fi
