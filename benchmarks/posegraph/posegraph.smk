# Pose graphs by themselves (docs/pose_graphs.md): optima and speed, false closures added to sphere2500, and Bicocca's real ones.
TABLES += ["posegraph", "posegraph-information", "false-closures", "bicocca"]
DOCS.add("pose_graphs")
POSEGRAPH = config["posegraph"]
BICOCCA = POSEGRAPH["bicocca"]
G2O = files([POSEGRAPH["graphs"] + "/*.g2o"])

# One program, two tables, parted by an empty line.
rule posegraph_table:
    input: G2O
    output: table("posegraph"), table("posegraph-information")
    params:
        absent=why_absent([POSEGRAPH["graphs"] + "/*.g2o"]) or lacks("posegraph_table"),
        program=program("posegraph_table"), tool=hash_of(program("posegraph_table")), folder=data(POSEGRAPH["graphs"]),
        conventions="CPU seconds on one thread, medians of five.",
        conventions_information="`final_cost` of `planegraph optimize`.",
    shell:
        """
        if [ -n "{params.absent}" ]; then for t in {output}; do printf '*skipped: %s*\\n' {params.absent:q} > $t; done; exit; fi
        mkdir -p posegraph && {params.program} {params.folder:q} > posegraph/tables
        {{ sed '/^$/,$d' posegraph/tables; bash {FOOTER} {VERSION:q} {params.conventions:q}; }} > {output[0]}
        {{ sed '1,/^$/d' posegraph/tables; bash {FOOTER} {VERSION:q} {params.conventions_information:q}; }} > {output[1]}
        """

# Row by row: none of them keeps a core for long while others wait for two.
rule false_closures:
    input: files([POSEGRAPH["closures"]])
    output: "false_closures/{kind}-{share}.md"
    params: program=program("closures_table"), tool=hash_of(program("closures_table"))
    shell: "{params.program} {input:q} {wildcards.kind} {wildcards.share} > {output}"

NO_CLOSURES = why_absent([POSEGRAPH["closures"]]) or lacks("closures_table")

rule false_closures_table:
    input:
        [] if NO_CLOSURES else [f"false_closures/{kind}-{share}.md" for share in POSEGRAPH["false_shares"] for kind in POSEGRAPH["false_kinds"]]
    output: table("false-closures")
    params: absent=NO_CLOSURES, conventions="CPU seconds on one thread."
    shell:
        """
        if [ -n "{params.absent}" ]; then printf '*skipped: %s*\\n' {params.absent:q} > {output}; exit; fi
        {{ awk '!/^[|]/ {{ if (NR == FNR) print; next }} FNR != NR && /^[|] false closures|^[|]---/ {{ next }} {{ print }}' {input}
           bash {FOOTER} {VERSION:q} {params.conventions:q}; }} > {output}
        """

# The graph of a threshold of place recognition, solved with a loss, its poses at the times of the truth.
rule bicocca_run:
    input: files([BICOCCA["folder"] + "/*"])
    output: optimized="bicocca/{loss}-{threshold}/optimize.json", evaluated="bicocca/{loss}-{threshold}/evaluate.json"
    params: program=PLANEGRAPH_HASH, folder=data(BICOCCA["folder"]), loss=lambda wildcards: BICOCCA["losses"][wildcards.loss]
    shell:
        """
        at=$(dirname {output.optimized})
        {PLANEGRAPH} convert {params.folder:q}/truth.g2o $at/truth.tum --stamps={params.folder:q}/Bicocca_2009-02-25b-GT-extended.csv --quiet
        if [ {params.loss} = given ]; then
          cp {params.folder:q}/B25b_{wildcards.threshold}.g2o $at/out.g2o; echo '{{}}' > {output.optimized}
        else
          {PLANEGRAPH} optimize {params.folder:q}/B25b_{wildcards.threshold}.g2o --output=$at/out.g2o --loss={params.loss} --json --quiet > {output.optimized} || [ $? -eq 3 ]
        fi
        {PLANEGRAPH} convert $at/out.g2o $at/out.tum --stamps={params.folder:q}/B25b_timestamps.txt --quiet
        {PLANEGRAPH} evaluate --reference=$at/truth.tum --estimate=$at/out.tum --max_time_difference=0.06 --output={output.evaluated} --quiet
        rm $at/*.g2o $at/*.tum
        """

def bicocca_runs(file):
    return [f"bicocca/{loss}-{threshold}/{file}" for loss in BICOCCA["losses"] for threshold in BICOCCA["thresholds"]]

rule bicocca_table:
    input: [] if why_absent([BICOCCA["folder"] + "/*"]) else bicocca_runs("evaluate.json")
    output: table("bicocca")
    params:
        absent=why_absent([BICOCCA["folder"] + "/*"]), thresholds=BICOCCA["thresholds"], losses=BICOCCA["losses"],
        conventions="ATE, rmse, m.",
    run:
        def number(path, *keys):
            with open(path) as stream:
                value = json.load(stream)
            for key in keys:
                value = value[key]
            return value
        with open(output[0], "w") as stream:
            if params.absent:
                print(f"*skipped: {params.absent}*", file=stream)
            else:
                print("| |" + "".join(f" {threshold} |" for threshold in params.thresholds), file=stream)
                print("|---|" + "---|" * len(params.thresholds), file=stream)
                for loss, flag in params.losses.items():
                    ates = [number(f"bicocca/{loss}-{t}/evaluate.json", "ate", "rmse") for t in params.thresholds]
                    name = "odometry alone (the files' poses)" if flag == "given" else f"`--loss={flag}`"
                    print(f"| {name} |" + "".join(f" {ate:.3f} |" for ate in ates), file=stream)
        if not params.absent:
            shell("bash {FOOTER} {VERSION:q} {params.conventions:q} >> {output}")
