# Shared by the scripts of this folder: sourced, never run.
set -euo pipefail
SCRIPTS=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
ROOT=$(cd "$SCRIPTS/../.." && pwd)
JOBS=${JOBS:-$(nproc)}

# step TEXT: a headline with the time since the start.
step() { printf '\n== %s (%dm %02ds)\n' "$*" $((SECONDS / 60)) $((SECONDS % 60)); }

# The packages of the groups that are not installed.
missing_packages() {
  local group package program
  for group in "$@"; do
    while read -r package program; do
      [ -z "$program" ] || ! command -v "$program" >/dev/null || continue
      [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || echo "$package"
    done < <(awk -v group="$group" '$1 == group {print $2, $3}' "$SCRIPTS/packages.txt")
  done
}

# install_packages GROUP...: installs what is missing of these groups; without a network if that is nothing.
install_packages() {
  local missing as_root=()
  mapfile -t missing < <(missing_packages "$@")
  if [ ${#missing[@]} -eq 0 ]; then echo "all packages are there"; return; fi
  [ "$(id -u)" -eq 0 ] || as_root=(sudo)
  echo "installing: ${missing[*]}"
  "${as_root[@]}" apt-get update
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "${missing[@]}"
}

# build PRESET [TARGET...]: configures and builds.
build() {
  local preset=$1
  shift
  cmake --preset "$preset" -S "$ROOT"
  cmake --build "$ROOT/build/$preset" --parallel "$JOBS" ${1:+--target "$@"}
}
