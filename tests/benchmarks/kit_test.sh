#!/usr/bin/env bash
# kit_test.sh SOURCE BUILD WORK: runs a tiny part of the benchmark kit: nothing but simulated sites. Exit code 77: snakemake is
# not here.
set -euo pipefail
source=$1 build=$2 work=$3
command -v snakemake >/dev/null || { echo "snakemake is not here: the benchmark kit is not tried"; exit 77; }
rm -rf "$work"
mkdir -p "$work/data" "$work/home"
export HOME=$work/home XDG_CACHE_HOME=$work/home  # snakemake keeps a cache of sources
unset PLANEGRAPH_DATA PLANEGRAPH_BUILD PLANEGRAPH_OUT
fail() { echo "failed: $*" >&2; exit 1; }

# json_table by itself: medians and spreads, missing values, fixed cells, skipped rows.
mkdir -p "$work/table/a" "$work/table/b"
printf 'error\tx.json\tate.values\t1\t1000\nname\tx.json\tname\t0\t1\n?95 %%\tx.json\tci\t2\t1\n?none\tx.json\tnone\t2\t1\n' > "$work/table/columns.tsv"
echo '{"ate": {"values": [0.003, 0.001, 0.002]}, "name": "first", "ci": [1, 2]}' > "$work/table/a/x.json"
echo '{"ate": {"values": 0.009}}' > "$work/table/b/x.json"
got=$("$build/benchmarks/kit/json_table" "$work/table/columns.tsv" 'set|by' "one|ours=$work/table/a" "|both=$work/table/a,$work/table/b" \
  'two|peer=|7.5|x' 'three|=!not there')
want='| set | by | error | name | 95 % |
|---|---|---|---|---|
| one | ours | 2.0 [1.0 to 3.0] | first | 1.00 to 2.00 |
|  | both | 2.5 [1.0 to 9.0] | first | &ndash; |
| two | peer | 7.5 | x |  |
| three | *skipped: not there* |  |  |'
[ "$got" = "$want" ] || fail "json_table printed
$got"

cat > "$work/config.yaml" <<'END'
repeats: 2
threads: 1
simulated: {options: "--drone=off --scan_count=2 --beams=181 --sweeps=60", scenes: [yard], seeds: [0, 1]}
configurations: {none: --optimizer=none, graph: --optimizer=graph}
END
kit() {
  (cd "$source/benchmarks" && snakemake -c1 --nolock --configfile "$source/benchmarks/config.yaml" "$work/config.yaml" \
    --config build="$build" out="$work/out" data="$work/data" "$@" 2>&1)
}

kit -n > "$work/plan.log" || fail "the plan of the whole kit: $(tail -5 "$work/plan.log")"
kit -- tables/simulated.md tables/laser.md tables/3dtk.md > "$work/first.log" || fail "$(tail -30 "$work/first.log")"
table=$work/out/tables/simulated.md
[ "$(grep -c '^| *\(yard\)* *| `\(start\|none\|graph\)` |' "$table")" = 3 ] || fail "three rows are expected in $(cat "$table")"
grep -q 'planegraph [0-9]' "$table" || fail "no version under $table"
grep -q '\*skipped: not in the data folder: bedkowski' "$work/out/tables/laser.md" || fail "absent sets are not listed as skipped"

kit -- tables/simulated.md tables/laser.md > "$work/second.log"
grep -q 'Nothing to be done' "$work/second.log" || fail "the second run did something: $(cat "$work/second.log")"

sed -i 's/graph: --optimizer=graph/graph: --optimizer=graph --loss=huber/' "$work/config.yaml"
kit -- tables/simulated.md > "$work/changed.log" || fail "$(tail -30 "$work/changed.log")"
again=$(awk '/^rule map:/ { map = 1 } map && /wildcards: / { sub(/.*configuration=/, ""); print; map = 0 }' "$work/changed.log" | sort | uniq -c)
[ "$(echo $again)" = "2 graph" ] || fail "a flag of graph alone has changed, and these were mapped again: $again"
echo "done"
