# Other programs' figures, fixed and with their source, beside ours measured (docs/comparisons.md).
TABLES += ["peers-mapping", "peers-registration", "peers-segmentation"]
PEERS_SOURCE = (
    "The other programs' figures are fixed: measured by us on 2 cores (AMD EPYC, Debian 12, g++ 12.2 -O3) with Open3D 0.16.1, PCL 1.13.0, "
    "CGAL 5.5.1, TEASER++ f91cfdb7, Ceres 2.1.0, g2o 34013227, GTSAM 0ffe6c93, SE-Sync 9b631b6b; CPU seconds are comparable to about 1.5 times.")
PEER_SETS = ["yard-short", "yard-loop", "storey", "hall"]


def fixed(name):
    """The lines of a table of fixed figures, without its comments."""
    with open(os.path.join(HERE, "peers", name)) as stream:
        return [line.rstrip("\n").split("\t") for line in stream if not line.startswith("#")]


def peer_rows():
    rows = []
    for name in PEER_SETS:
        rows.append(row(SETS[name]["title"] + "|start", name, START))
        rows += [f"|{what}=|" + "|".join(cells) for set_, what, *cells in fixed("mapping.tsv") if set_ == name]
        rows += [row("|ours, `graph`", name, "graph")] if not SETS[name]["absent"] else []
    return rows


rule peers_mapping:
    input:
        measures=[path for name in present(PEER_SETS) for configuration in [START, "graph"] for path in measured(name, configuration)],
        hashes=hashes(PEER_SETS), columns=columns("peers/mapping_columns.tsv"),
    output: table("peers-mapping")
    params:
        rows=peer_rows(), tool=JSON_TABLE_HASH,
        conventions=PEERS_SOURCE + " Both of them start from the same poses: point-to-plane ICP of neighbours from odometry; of all pairs within 20 m "
        "(hall: 4 m) with Open3D's pose graph; 0.1 m voxels (real sets 0.05 m). MME and thickness of theirs: the same scans, 20,000 random "
        "points; ours and the start: every point.",
    shell:
        "{{ {JSON_TABLE} {input.columns} 'scans|by' {params.rows:q}; "
        "bash {FOOTER} {VERSION:q} {params.conventions:q} {input.hashes}; }} > {output}"

# Ours: the rows of the table of all pairs.
rule peers_registration:
    input: ours=table("registration"), fixed=os.path.join(HERE, "peers/registration.tsv")
    output: table("peers-registration")
    params: conventions=PEERS_SOURCE + " Ours: status, and error of the best pose against the reference, which is good to some centimetres for 3dtk_dat."
    shell:
        """
        {{ awk -F '\\t' '
             NR == FNR {{ if (split($0, cell, / *[|] */) > 5) ours[cell[2]] = cell[3] ", " cell[4] " m, " cell[5] " deg"; next }}
             FNR == 1 {{ print "| pair | ours | Open3D RANSAC + FPFH, 3 seeds | Open3D FGR | TEASER++ (mutual FPFH) | PLADE |"
                        print "|---|---|---|---|---|---|"; next }}
             {{ print "| " $1 " | " ($1 in ours ? ours[$1] : "*skipped*") " | " $2 " | " $3 " | " $4 " | " $5 " |" }}
           ' {input.ours} {input.fixed}
           bash {FOOTER} {VERSION:q} {params.conventions:q}; }} > {output}
        """

rule segment:
    input: lambda wildcards: data(f"3dtk_dat/{wildcards.scan}.3d")
    output: "peers/segment/{scan}/segment.json"
    params: repeats=config["repeats"], program=PLANEGRAPH_HASH
    shell:
        """
        folder=$(dirname {output}); TIMEFORMAT='%3U %3S'; rm -f $folder/times
        for run in $(seq {params.repeats}); do
          {{ time {PLANEGRAPH} segment {input} --min_points=100 --threads=1 --output=$folder/planes.json --quiet ; }} 2>> $folder/times
        done
        planes=$(grep -c '^{{"id":' $folder/planes.json)
        awk -v planes=$planes '{{ all = all (NR == 1 ? "" : ", ") $1 + $2 }}
          END {{ print "{{\\"planes\\": " planes ", \\"cpu_seconds\\": [" all "]}}" }}' $folder/times > {output}
        rm $folder/times $folder/planes.json
        """

SEGMENTED = [] if SETS["3dtk"]["absent"] else [cells[0] for cells in fixed("segmentation.tsv")]

rule peers_segmentation:
    input:
        ours=[f"peers/segment/{scan}/segment.json" for scan in SEGMENTED],
        columns=columns("peers/segmentation_columns.tsv"), fixed=os.path.join(HERE, "peers/segmentation.tsv"), hashes=hashes(["3dtk"]),
    output: table("peers-segmentation")
    params:
        rows=[cells[0] + "|" + "|".join(cells[1:]) + "=" +
              (f"peers/segment/{cells[0]}" if SEGMENTED else "!" + SETS["3dtk"]["absent"]) for cells in fixed("segmentation.tsv")],
        conventions=PEERS_SOURCE + " Planes of at least 100 points. Theirs: CPU seconds with normals of 30 neighbours, reading left out; ours: of the whole "
        "process, one thread, reading included.",
        tool=JSON_TABLE_HASH,
    shell:
        "{{ {JSON_TABLE} {input.columns} '3dtk_dat|PCL RegionGrowing|CGAL Region_growing|CGAL Efficient_RANSAC' {params.rows:q}; "
        "bash {FOOTER} {VERSION:q} {params.conventions:q} {input.hashes}; }} > {output}"

# Pose graphs by themselves, where the build has `planegraph optimize`.
if "optimize" in COMMANDS:
    TABLES.append("peers-graphs")
GRAPH_FOLDER = "posegraph/se_sync"

rule optimize:
    input: lambda wildcards: data(f"{GRAPH_FOLDER}/{wildcards.graph}.g2o")
    output: "peers/graphs/{graph}/optimize.json"
    params: flags="--init=chordal --information=isotropic --certify --threads=1", program=PLANEGRAPH_HASH
    shell:
        """
        folder=$(dirname {output}); code=0
        {PLANEGRAPH} optimize {input} {params.flags} --output=$folder/optimum.g2o --json > $folder/result.json || code=$?
        [ $code -eq 0 ] || [ $code -eq 3 ] || exit $code
        rm -f $folder/optimum.g2o; mv $folder/result.json {output}
        """


def graph_row(graph, *cells):
    path = f"{GRAPH_FOLDER}/{graph}.g2o"
    absent = why_absent([path])
    return f"{graph}|" + "|".join(cells) + "=" + (f"!{absent}" if absent else f"peers/graphs/{graph}")


rule peers_graphs:
    input:
        ours=[f"peers/graphs/{graph}/optimize.json" for graph, *_ in fixed("graphs.tsv") if not why_absent([f"{GRAPH_FOLDER}/{graph}.g2o"])],
        columns=columns("peers/graphs_columns.tsv"), fixed=os.path.join(HERE, "peers/graphs.tsv"),
    output: table("peers-graphs")
    params:
        rows=[graph_row(*cells) for cells in fixed("graphs.tsv")], tool=JSON_TABLE_HASH,
        conventions=PEERS_SOURCE + " Seconds of the solve from a chordal start, isotropic weights, median. F: SE-Sync's objective. SE-Sync, GTSAM and ours compute "
        "the start themselves (in their seconds), Ceres and g2o were given it.",
    shell:
        "{{ {JSON_TABLE} {input.columns} 'graph|optimum F|SE-Sync, s|GTSAM LM, s|Ceres example, s|g2o GN csparse, s|g2o LM cholmod, s' {params.rows:q}; "
        "bash {FOOTER} {VERSION:q} {params.conventions:q}; }} > {output}"
