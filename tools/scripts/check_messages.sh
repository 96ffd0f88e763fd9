#!/usr/bin/env bash
# Lists the messages of the sources that docs/messages.md does not explain, and fails where there are some. A message is
# every text of three words or more in what is thrown, given as a reason or kept as a warning.
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cd "$ROOT"
page=$(tr -d "\`'\n" < docs/messages.md)
missing=0
while IFS= read -r text; do
  plain=$(printf '%s' "$text" | tr -d "\`'" | sed 's/%%/%/g; s/%[.0-9]*[a-z]\{1,2\}/.../g; s/\\n//g; s/^[^[:alnum:]-]*//; s/[^[:alnum:].)]*$//')
  [ "$(wc -w <<< "$plain")" -ge 3 ] || continue
  case $page in *"$plain"*) ;; *) echo "not on docs/messages.md: $text"; missing=1 ;; esac
done < <(
  find src tools factors -name '*.cc' -o -name '*.h' | sort | xargs cat | grep -v '^ *///\|^ *//' |
    tr '\n' ' ' | sed 's/" *"//g; s/;/;\n/g' |
    grep -E '(Fail|AtLine|AtByte|InFile|UsageError|NoResultError|InputError)\(|reason = |warnings[.>-]*push_back|Format\(|std::cerr <<|LOG\(WARNING\)' |
    grep -oE '(Fail|AtLine|AtByte|InFile|UsageError|NoResultError|InputError|Format)\(.*|reason = .*|push_back\(.*|std::cerr <<.*|WARNING\).*' |
    grep -oE '"([^"\\]|\\.)*"' | sed 's/^"//; s/"$//' | sort -u)
exit $missing
