# The cost variants against each other, where the build has `planegraph sweep` and the experiment's file is there. Its sites are
# relative to the data folder, from which it runs.
SWEEP_EXPERIMENT = os.path.join(ROOT, config["sweep"]["experiment"])
if "sweep" in COMMANDS and DATA and os.path.exists(SWEEP_EXPERIMENT):
    TABLES.append("sweep")

rule sweep:
    input: SWEEP_EXPERIMENT
    output: directory("sweep")
    params: data=DATA, program=PLANEGRAPH_HASH
    threads: config["threads"]
    shell: "out=$(realpath -m {output}); cd {params.data:q} && {PLANEGRAPH} sweep {input} --output_dir=$out --quiet || [ $? -eq 3 ]"

rule sweep_table:
    input: "sweep"
    output: table("sweep")
    params: conventions="`planegraph sweep`, see the experiment's file."
    shell:
        """
        {{ awk -F , '{{ line = "|"; rule = "|"; for (k = 1; k <= NF; ++k) {{ line = line " " $k " |"; rule = rule "---|" }}
                     print line; if (NR == 1) print rule }}' {input}/*.csv
           bash {FOOTER} {VERSION:q} {params.conventions:q}; }} > {output}
        """
