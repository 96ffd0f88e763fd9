#!/usr/bin/env bash
# Runs clang-tidy over the sources of a build tree (a preset's; default build/ci).
# Usage: check_tidy.sh [BUILD_DIR [REGEX of files]]
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
tree=${1:-$ROOT/build/ci}
files=${2:-"^$ROOT/(src|factors|tools|benchmarks|tests)/.*\\.cc\$"}
runner=$(command -v run-clang-tidy-14 || command -v run-clang-tidy) || { echo "clang-tidy is not here" >&2; exit 1; }
cd "$ROOT"
# Flags of GCC that clang does not know stand in the build tree.
"$runner" -quiet -p "$tree" -j "$JOBS" -extra-arg=-Wno-unknown-warning-option "$files"
