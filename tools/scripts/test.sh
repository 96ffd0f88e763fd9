#!/usr/bin/env bash
# Installs what is missing, builds everything and runs all tests. The last line is the summary of the tests.
# Usage: bash tools/scripts/test.sh [--long]
#   --long  then also the tests under sanitizers, clang-tidy, and each fuzz target for a minute
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
case "${1:-}" in
  "") long=no ;;
  --long) long=yes ;;
  *) echo "usage: test.sh [--long]" >&2; exit 1 ;;
esac

failed=0
summaries=()

# run_tests PRESET: runs its tests and keeps their summary line for the end.
run_tests() {
  local log=$ROOT/build/$1/ctest.log
  ctest --preset "$1" --parallel "$JOBS" --progress 2>&1 | tee "$log" || failed=1
  summaries+=("$(grep 'tests passed' "$log" || echo "$1: no test ran")")
}

fuzz() {
  local target name
  for target in "$ROOT"/build/fuzz/tests/fuzz/fuzz_*; do
    [ -x "$target" ] || continue
    name=$(basename "$target")
    step "Fuzzing: $name"
    mkdir -p "$ROOT/build/fuzz/corpus/$name"
    "$target" -max_total_time="${FUZZ_SECONDS:-60}" -rss_limit_mb=2048 -print_final_stats=1 \
      -artifact_prefix="$ROOT/build/fuzz/$name-" \
      "$ROOT/build/fuzz/corpus/$name" "$ROOT/tests/fuzz/corpus/${name#fuzz_}" || failed=1
  done
}

cd "$ROOT"
step "Installing packages"
install_packages build viewer test browser pcl
[ "$long" = no ] || install_packages long
step "Building"
if [ "$long" = yes ]; then build ci; else build_once ci; fi
step "Testing"
run_tests ci
if [ "$long" = yes ]; then
  step "Building with sanitizers"
  build asan-ubsan
  step "Testing with sanitizers"
  run_tests asan-ubsan
  step "clang-tidy"
  bash "$SCRIPTS/check_tidy.sh" "$ROOT/build/ci" || failed=1
  step "Building the fuzz targets"
  build fuzz fuzzers
  fuzz
fi

step "Summary"
[ "$failed" = 0 ] || echo "something failed: see above"
printf '%s\n' "${summaries[@]}"
exit "$failed"
