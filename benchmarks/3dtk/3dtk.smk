# 3DTK's sample scans: ours and 3DTK's own results against each other.
TABLES.append("3dtk")
DOCS.add("comparisons")
OTHERS_3DTK = config["sets"].get("3dtk", {}).get("others", {})
ROWS_3DTK = [START, *config["configurations"], *OTHERS_3DTK]

rule error_against_3dtk:
    input: estimate=lambda wildcards: trajectory("3dtk", wildcards.configuration),
        reference=lambda wildcards: SETS["3dtk"]["others"][wildcards.reference]
    output: "runs/3dtk/{configuration}/against-{reference}.json"
    params:
        what=lambda wildcards, input: f"--estimate={input.estimate} --reference={input.reference}",
        flags=config["evaluation"]["trajectory"] + " --align=first", program=PLANEGRAPH_HASH,
    shell: MEASURE

# Differences point by point are told far better than the figures of two maps by themselves.
rule sharpness_less_graph:
    input: estimate=lambda wildcards: trajectory("3dtk", wildcards.configuration), graph="runs/3dtk/graph/poses.tum"
    output: "runs/3dtk/{configuration}/less-graph.json"
    params:
        what=lambda wildcards, input: f"--estimate={input.graph} --compare={input.estimate} '--scans=" + SETS["3dtk"]["scans"] + "'",
        flags=config["evaluation"]["sharpness"], program=PLANEGRAPH_HASH,
    shell: MEASURE

rule table_3dtk:
    input:
        measures=[f"runs/3dtk/{configuration}/{kind}" for name in present(["3dtk"]) for configuration in ROWS_3DTK
                  for kind in ["sharpness.json", "less-graph.json", *(f"against-{other}.json" for other in OTHERS_3DTK)]],
        hashes=hashes(["3dtk"]), columns=columns("3dtk/3dtk.tsv"),
    output: table("3dtk")
    params:
        rows=[row(f"`{configuration}`", "3dtk", configuration) for configuration in ROWS_3DTK], tool=JSON_TABLE_HASH,
        conventions="ATE: rmse after an alignment on the first pose; RPE over consecutive scans; both over three poses. `start` is "
        "the odometry of the `.pose` files, `slam6d-plain` 3DTK's slam6D as it is commonly used, `slam6d-p2pl` with all points, "
        "point-to-plane. Neither is truth: they differ from each other by as much as the rows say. MME and thickness (median, mean) as in results.md; `more than graph`: "
        "mean thickness less that of `graph`, over the points that both use, with its 95 % interval (jackknife over blocks).",
    shell:
        "{{ {JSON_TABLE} {input.columns} poses {params.rows:q}; "
        "bash {FOOTER} {VERSION:q} {params.conventions:q} {input.hashes}; }} > {output}"
