#!/usr/bin/env bash
# localization_page.sh BUILD DATA: prints docs/localization.md. BUILD is a build folder with the benchmarks, DATA the
# folder with hybrid-site-a. Simulates ten sites in a temporary folder.
set -euo pipefail
build=$(realpath "$1"); data=$(realpath "$2")
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
sites=()
for scene in yard quarter; do
  for seed in 0 1 2 3 4; do
    "$build/tools/planegraph" simulate --scene=$scene --seed=$seed --output_dir="$folder/$scene$seed" >/dev/null
    sites+=("$scene$seed")
  done
done
cat <<'TEXT'
# Finding scans in the drone map

Made by `bash benchmarks/locate/localization_page.sh BUILD DATA`, with `-DPLANEGRAPH_BUILD_BENCHMARKS=ON` in BUILD and the data sets in DATA.

Every scan is looked for in the whole map without a start pose, by itself, together with the next scan, and by the paper's search over cells.
The map's scale comes from GPS alone. *Right*: `ok`, within 1 m and 5 deg of the truth in true metres. *Wrong*: `ok`, and not. *Undecided*:
`ambiguous` or `failed`. *Covered*: half of the scan's 0.25 m voxels or more have a point of the map within 0.15 m at the true pose; of two
scans, the mean. Scores are those of `MapEvidence`, for cells the paper's r. A *wrong pose* is a candidate that is not near the truth.

The limits of `MapLocationOptions` were set by looking at hybrid-site-a. Nothing was set by looking at the simulated sites.
TEXT
printf '\n## hybrid-site-a\n\n'
(cd "$data" && "$build/benchmarks/locate_table" hybrid-site-a) || [ $? -eq 1 ]  # 1: a scan was found in a wrong place; the page says so
printf '\n## Simulated yards and quarters (`planegraph simulate`, seeds 0 to 4)\n\n'
(cd "$folder" && "$build/benchmarks/locate_table" "${sites[@]}") || [ $? -eq 1 ]  # 1: a scan was found in a wrong place; the page says so
