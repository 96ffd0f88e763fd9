#!/usr/bin/env bash
# Installs what is missing, builds the program, simulates a small site and maps it.
# Usage: bash tools/scripts/demo.sh [FOLDER]   (the results' folder, default out/demo)
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
out=${1:-$ROOT/out/demo}
planegraph=$ROOT/build/release/tools/planegraph

step "Installing packages"
install_packages build viewer
step "Building"
cd "$ROOT"
build_once release planegraph_tool
step "Simulating the site"
"$planegraph" simulate --scene=yard --output_dir="$out/site"
step "Mapping it"

"$planegraph" map "$out/site/site.yaml" --output_dir="$out/result"
step "Done"
echo "report: $out/result/report.html"
echo "map:    $out/result/map.ply"
