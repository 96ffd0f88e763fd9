# Poses found from no guess at all, simulated (docs/initialization.md).
TABLES += ["initialization"]
DOCS.add("initialization")
INITIALIZATION = config["initialization"]

rule initialization_table:
    output: table("initialization")
    params:
        absent=lacks("initialization_table"), program=program("initialization_table"), tool=hash_of(program("initialization_table")),
        sites=INITIALIZATION["sites"], first_seed=INITIALIZATION["first_seed"], conventions="CPU seconds on one thread, medians.",
    shell:
        """
        if [ -n "{params.absent}" ]; then printf '*skipped: %s*\\n' {params.absent:q} > {output}; exit; fi
        {{ {params.program} {params.sites} {params.first_seed}; bash {FOOTER} {VERSION:q} {params.conventions:q}; }} > {output}
        """
