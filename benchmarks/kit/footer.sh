#!/usr/bin/env bash
# footer.sh VERSION CONVENTIONS [HASHFILE...]: the line under a table. A hash file is called as its set.
set -euo pipefail
version=$1 conventions=$2
shift 2
processor=$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo 2>/dev/null | head -1)
inputs=
for file in "$@"; do
  inputs+="${inputs:+, }$(basename "$file" .txt) $(cut -c1-12 "$file")"
done
printf '\n*%s, %s cores (%s).%s %s*\n' "$version" "$(getconf _NPROCESSORS_ONLN)" "${processor:-unknown}" \
  "${inputs:+ Input, first digits of SHA-256: $inputs.}" "$conventions"
