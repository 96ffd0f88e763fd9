# The tables of docs/results.md: every set of scans with every configuration.
TABLES += ["laser", "simulated"]
DOCS.add("results")

LASER_CONVENTIONS = (
    "ATE: rmse of positions after an alignment by SE(3); RPE over consecutive scans. MME and thickness (median of the "
    "smallest principal deviation): raw scans without points nearer than 0.5 m, thinned to 0.05 m voxels, merged under the "
    "poses; radius 0.3 m, neighbourhoods of at least 15 points. `start`: the poses that the run starts from. Brackets: "
    "median [least to greatest], of CPU seconds (user and system, the whole process, report included) over the runs.")


def laser_rows():
    rows = []
    for name in REAL:
        shown = [START] if SETS[name]["absent"] else [START, *config["configurations"]]
        for configuration in shown:
            title = SETS[name]["title"] if configuration == START else ""
            rows.append(row(f"{title}|`{configuration}`", name, configuration))
    return rows


rule laser_table:
    input:
        measures=[path for name in present(REAL) for configuration in [START, *config["configurations"]]
                  for path in measured(name, configuration)],
        hashes=hashes(REAL), columns=columns("laser/laser.tsv"),
    output: table("laser")
    params: rows=laser_rows(), conventions=LASER_CONVENTIONS, tool=JSON_TABLE_HASH
    shell:
        "{{ {JSON_TABLE} {input.columns} 'scans|optimizer' {params.rows:q}; "
        "bash {FOOTER} {VERSION:q} {params.conventions:q} {input.hashes}; }} > {output}"


def seeds_of(scene):
    return [f"simulated-{scene}-{seed}" for seed in config["simulated"]["seeds"]]


def simulated_rows():
    return [(scene if configuration == START else "") + f"|`{configuration}`=" + ",".join(f"runs/{name}/{configuration}" for name in seeds_of(scene))
            for scene in config["simulated"]["scenes"] for configuration in [START, *config["configurations"]]]


rule simulated_table:
    input:
        measures=[path for name in SIMULATED for configuration in [START, *config["configurations"]]
                  for path in measured(name, configuration)],
        columns=columns("laser/simulated.tsv"),
    output: table("simulated")
    params:
        rows=simulated_rows(), tool=JSON_TABLE_HASH,
        conventions="`planegraph simulate`, seeds " + ", ".join(str(seed) for seed in config["simulated"]["seeds"]) +
        ": median [least to greatest] over the seeds" +
        f" (and of CPU seconds over {config['repeats']} runs of each). ATE after an alignment by SE(3), RPE over consecutive scans.",
    shell:
        "{{ {JSON_TABLE} {input.columns} 'scene|optimizer' {params.rows:q}; "
        "bash {FOOTER} {VERSION:q} {params.conventions:q}; }} > {output}"
