#!/usr/bin/env bash
# Maps a site, a small simulated one where none is given, and looks at its report in Chromium.
# Usage: run.sh PLANEGRAPH WORK_FOLDER NODE NPM CHROMIUM [SITE.yaml]   (exit code 77: skipped)
set -euo pipefail
planegraph=$1 work=$2 node=$3 npm=$4 chromium=$5 site=${6:-}
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

skip() { echo "skipped: $1"; exit 77; }
for tool in "$node" "$npm" "$chromium"; do
  [ -x "$tool" ] || skip "Node.js, npm or Chromium is not here"
done

[ -z "$site" ] || [ -e "$site" ] || skip "there is no $site"
mkdir -p "$work/driver"
cp "$here"/*.mjs "$here"/package*.json "$work/driver"
if [ ! -d "$work/driver/node_modules/playwright-core" ]; then
  (cd "$work/driver" && "$npm" ci --ignore-scripts --no-audit --no-fund --fetch-retries=1) ||
    skip "npm cannot fetch playwright-core"
fi
if [ -z "$site" ]; then
  site=$work/site/site.yaml
  "$planegraph" simulate --scene=yard --scan_count=5 --beams=181 --sweeps=90 --output_dir="$work/site" --quiet
fi
# Whether every scan finds its place is not the question here.
"$planegraph" map "$site" --output_dir="$work/result" --quiet || [ $? -eq 3 ]
grep -q 'id="viewer-scene"' "$work/result/report.html" || skip "this build has no viewer"
"$node" "$work/driver/check_report.mjs" "$work/result/report.html" "$chromium" "$work"
