# Poses found from no guess at all, simulated (docs/initialization.md).
TABLES += ["initialization"]
DOCS.add("initialization")
INITIALIZATION = config["initialization"]

# Scene by scene, so that they run side by side.
rule initialization_scene:
    output: "initialization/{scene}.md"
    params:
        absent=lacks("initialization_table"), program=program("initialization_table"), tool=hash_of(program("initialization_table")),
        sites=INITIALIZATION["sites"], first_seed=INITIALIZATION["first_seed"],
    shell: '[ -n "{params.absent}" ] || {params.program} {params.sites} {params.first_seed} {wildcards.scene} > {output}; touch {output}'

rule initialization_table:
    input: [f"initialization/{scene}.md" for scene in INITIALIZATION["scenes"]]
    output: table("initialization")
    params:
        absent=lacks("initialization_table"), conventions="CPU seconds on one thread, medians.",
    shell:
        """
        if [ -n "{params.absent}" ]; then printf '*skipped: %s*\\n' {params.absent:q} > {output}; exit; fi
        {{ awk 'NR <= 2 || FNR > 2' {input}; bash {FOOTER} {VERSION:q} {params.conventions:q}; }} > {output}
        """
