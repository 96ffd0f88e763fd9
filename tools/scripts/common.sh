# Shared by the scripts of this folder: sourced, never run.
set -euo pipefail
SCRIPTS=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
ROOT=$(cd "$SCRIPTS/../.." && pwd)
# A compiler takes up to 2 GiB.
most_jobs=$(awk '/^MemTotal/ {print int($2 / 2097152) + 1}' /proc/meminfo 2>/dev/null || echo 2)
JOBS=${JOBS:-$(($(nproc) < most_jobs ? $(nproc) : most_jobs))}

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

# build_once PRESET [TARGET...]: for those who will not change the sources. From nothing it compiles eight of a module's sources
# as one, in half the time. A compiler cache does better with single ones, and a folder stays as it was begun.
build_once() {
  if [ ! -e "$ROOT/build/$1/CMakeCache.txt" ] && ! command -v ccache >/dev/null; then
    cmake --preset "$1" -S "$ROOT" -DCMAKE_UNITY_BUILD=ON
  fi
  build "$@"
}

# build PRESET [TARGET...]: configures and builds.
build() {
  local preset=$1
  shift
  cmake --preset "$preset" -S "$ROOT"
  cmake --build "$ROOT/build/$preset" --parallel "$JOBS" ${1:+--target "$@"}
}
