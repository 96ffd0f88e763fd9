# The cost variants against each other, by `planegraph sweep`. It keeps its own account of what is to be done again, so its folder
# is not declared as a whole: Snakemake would empty it.
SWEEP_EXPERIMENT = os.path.join(ROOT, config["sweep"]["experiment"])
if not why_absent(config["sweep"]["inputs"]):
    TABLES.append("sweep")
DOCS.add("sweep")

rule sweep:
    input: SWEEP_EXPERIMENT, files(config["sweep"]["inputs"])
    output: "sweep/table.md"
    params: data=DATA, program=PLANEGRAPH_HASH
    threads: config["threads"]
    shell:
        "{PLANEGRAPH} sweep {input[0]:q} --data_dir={params.data:q} --output_dir=sweep --threads={threads} --quiet || [ $? -eq 3 ]"

rule sweep_table:
    input: "sweep/table.md"
    output: table("sweep")
    params: conventions="`planegraph sweep benchmarks/sweep/experiment.yaml`; docs/sweep.md says what the columns are."
    shell: "{{ cat {input}; bash {FOOTER} {VERSION:q} {params.conventions:q}; }} > {output}"
