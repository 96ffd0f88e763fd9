#!/usr/bin/env bash
# Builds the site of docs/ and of the public headers, and checks its links. Any warning makes it fail.
# Usage: bash tools/scripts/docs.sh [FOLDER]   (default out/docs; the site is FOLDER/index.html)
# Exit code 77: doxygen (or its theme) is not here.
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
out=$(realpath -m "${1:-$ROOT/out/docs}")
theme=${DOXYGEN_AWESOME:-/usr/share/doxygen-awesome-css}
command -v doxygen >/dev/null || { echo "doxygen is not here: the site is not built"; exit 77; }
[ -f "$theme/doxygen-awesome.css" ] || { echo "doxygen-awesome-css is not here: the site is not built"; exit 77; }

cd "$ROOT"
version=$(sed -n 's/^project(Planegraph VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
mkdir -p "$(dirname "$out")"
work=$(mktemp -d "$(dirname "$out")/.docs.XXXXXX")
trap 'rm -rf "$work"' EXIT
(
  cat docs/site/Doxyfile
  echo "OUTPUT_DIRECTORY = \"$work\""
  echo "PROJECT_NUMBER = \"$version\""
  echo "HTML_EXTRA_STYLESHEET = \"$theme/doxygen-awesome.css\" \"$theme/doxygen-awesome-sidebar-only.css\" docs/site/style.css"
) | doxygen -

# Doxygen gives a Markdown file two pages: what is written there, and an empty one about the file, to which its name leads.
(
  cd "$work/html"
  for about in *_8md.html; do
    page=${about%_8md.html}
    [ "$page" != README ] || page=third_party  # the only README among the pages
    page=${page//__/_}
    printf 's|\([^A-Za-z_]\)%s|\1%s.html|g\n' "${about//./\\.}" "${page,,}"
    rm "$about"
  done >../names.sed
  find . -name '*.html' -o -name '*.js' | xargs sed -i -f ../names.sed
)

# Links to files of the site that are not there. (Doxygen checks what it knows; plain links pass through it.)
broken=$(cd "$work/html" && grep -oHE '(href|src)="[^"#]+' ./*.html | grep -vE '"(https?|mailto|javascript):' |
  sed 's/:\(href\|src\)="/ /' | sort -u | while read -r page link; do [ -e "$link" ] || echo "$page: no $link"; done)
[ -z "$broken" ] || { printf 'broken links:\n%s\n' "$broken" >&2; exit 1; }
rm -rf "$out"
mv "$work/html" "$out"
echo "site: $out/index.html"
