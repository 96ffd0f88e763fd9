#!/usr/bin/env bash
# Writes the code of docs/examples/ into the pages that show it.
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cd "$ROOT/docs"
for pair in new_factor.md:examples/height.cc api_example.md:examples/api_example.cc; do
  page=${pair%%:*} file=${pair#*:}
  awk -v mark="File: \`docs/$file\`" -v file="$file" '
    index($0, mark) {found = 1}
    found && /^```/ && !inside && !done {print; while ((getline line < file) > 0) print line; inside = 1; next}
    inside && /^```/ {inside = 0; done = 1}
    !inside' "$page" > "$page.new"
  mv "$page.new" "$page"
done
