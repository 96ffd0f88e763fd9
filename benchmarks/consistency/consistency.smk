# How honest the covariances are: the Monte Carlo experiment over simulated sites (docs/observability.md). The sweep keeps its own
# account of what is to be done again, so its folder is not declared as a whole: Snakemake would empty it.
TABLES += ["consistency"]
DOCS.add("observability")
MONTE_CARLO = os.path.join(ROOT, config["consistency"]["experiment"])

rule monte_carlo:
    input: MONTE_CARLO
    output: "monte_carlo/table.md"
    params: program=PLANEGRAPH_HASH
    threads: config["threads"]
    shell:
        "{PLANEGRAPH} sweep {input:q} --output_dir=monte_carlo --threads={threads} --quiet || [ $? -eq 3 ]"

rule consistency_table:
    input: "monte_carlo/table.md"
    output: table("consistency")
    params:
        absent=lacks("consistency_table"), program=program("consistency_table"), tool=hash_of(program("consistency_table")),
        scenes=[f"monte_carlo/runs/{scene}" for scene in config["consistency"]["scenes"]],
        conventions="`planegraph sweep " + config["consistency"]["experiment"] + "`.",
    shell:
        """
        if [ -n "{params.absent}" ]; then printf '*skipped: %s*\\n' {params.absent:q} > {output}; exit; fi
        {{ {params.program} {params.scenes}; bash {FOOTER} {VERSION:q} {params.conventions:q}; }} > {output}
        """
