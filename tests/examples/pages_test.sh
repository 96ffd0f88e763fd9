#!/usr/bin/env bash
# The pages show the examples as they are compiled: the block of C++ after "File: examples/NAME" is that file.
# Usage: pages_test.sh DOCS
set -euo pipefail
cd "$1"
failed=0
for pair in new_factor.md:examples/height.cc api_example.md:examples/api_example.cc; do
  page=${pair%%:*} file=${pair#*:}
  shown=$(awk -v mark="File: \`docs/$file\`" 'index($0, mark) {found = 1} found && /^```/ {if (inside) exit; inside = 1; next} inside' "$page")
  if [ "$shown" != "$(cat "$file")" ]; then
    echo "$page does not show $file as it is (bash tools/scripts/show_examples.sh mends it):"
    diff <(echo "$shown") "$file" | head -20 || true
    failed=1
  fi
done
exit $failed
