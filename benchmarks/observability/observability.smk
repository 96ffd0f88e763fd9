# Directions that the planes leave open, against the true normals of simulated scenes (docs/observability.md).
TABLES += ["observability"]
DOCS.add("observability")
OBSERVABILITY = config["observability"]

rule observability_table:
    output: table("observability")
    params:
        absent=lacks("observability_table"), program=program("observability_table"), tool=hash_of(program("observability_table")),
        sites=OBSERVABILITY["sites"], first_seed=OBSERVABILITY["first_seed"],
        conventions="8 scans of each site; a direction is right within 10 deg.",
    shell:
        """
        if [ -n "{params.absent}" ]; then printf '*skipped: %s*\\n' {params.absent:q} > {output}; exit; fi
        {{ {params.program} observability/site {params.sites} {params.first_seed} || [ $? -eq 3 ]; bash {FOOTER} {VERSION:q} {params.conventions:q}; }} > {output}
        """
