# Every pair of the sets by itself, without a guess (docs/registration.md).
TABLES += ["registration", "closures", "segmentation"]
DOCS.add("registration")
PAIRS = config["registration"]["inputs"]
PAIRS_ABSENT = why_absent(PAIRS) or lacks("register_table")

rule pairs_hash:
    input: files(PAIRS)
    output: "hashes/pairs.txt"
    shell: "cat {input:q} | sha256sum | cut -c1-64 > {output}"

# Exit code 1: a pair counts as wrong; the table says so.
rule registration_table:
    input: [] if PAIRS_ABSENT else [*files(PAIRS), "hashes/pairs.txt"]
    output: pairs=table("registration"), closures=table("closures")
    params:
        absent=PAIRS_ABSENT, data=DATA, register_table=program("register_table"), tool=hash_of(program("register_table")),
        conventions="Poses take points of the first scan to the second; errors in the second's axes.",
    shell:
        """
        if [ -n "{params.absent}" ]; then
          printf '*skipped: %s*\\n' {params.absent:q} | tee {output.pairs} > {output.closures}; exit
        fi
        {params.register_table} {params.data:q} > {output.pairs}.all || [ $? -eq 1 ]
        sed '/^| run /,$d' {output.pairs}.all > {output.pairs}
        sed -n '/^| run /,$p' {output.pairs}.all > {output.closures}
        rm {output.pairs}.all
        for file in {output}; do
          bash {FOOTER} {VERSION:q} {params.conventions:q} hashes/pairs.txt >> $file
        done
        """

# Against PCL's region growing, where the build has PCL.
rule segmentation_table:
    output: table("segmentation")
    params:
        program=program("segmentation_vs_pcl"), tool=hash_of(program("segmentation_vs_pcl")),
        conventions="Four simulated scans, two yards and two halls; planes of at least 100 points, a true and a found one match "
        "where the intersection over union of their points is at least one half; PCL with 30 neighbours, 3 deg.",
    shell:
        """
        if [ -z "{params.program}" ]; then echo '*skipped: the build has no PCL*' > {output}; exit; fi
        {{ {params.program}; bash {FOOTER} {VERSION:q} {params.conventions:q}; }} > {output}
        """

# Times of the search for correspondences, ours and Xiao's on the same planes.
TABLES.append("matching")

rule matching_table:
    output: table("matching")
    params:
        program=program("matching_benchmark"), tool=hash_of(program("matching_benchmark")), absent=lacks("matching_benchmark"),
        conventions="CPU milliseconds on one thread, means of Google Benchmark, on two simulated pairs of scans: the 30 largest planes of each "
        "(where it has so many), and all of them; in parentheses how many take part, source x target.",
    shell:
        """
        if [ -n "{params.absent}" ]; then printf '*skipped: %s*\\n' {params.absent:q} > {output}; exit; fi
        {params.program} --benchmark_format=json > {output}.json 2>/dev/null
        {{ awk -F '[:,"/ ]+' '
             /"name": "[A-Z]/ {{ if (!($3 in seen)) {{ order[++names] = $3; seen[$3] = 1 }} key = $3 " " $5 " " $7 }}
             /"cpu_time"/ {{ split($0, part, ": *"); time[key] = part[2] + 0 }}
             /"source_planes"/ {{ split($0, part, ": *"); source[key] = part[2] + 0 }}
             /"target_planes"/ {{ split($0, part, ": *"); target[key] = part[2] + 0 }}
             END {{
               text["MakeScanModel"] = "ours: a scan prepared"
               text["MatchWithoutGuess"] = "ours: hypotheses, verified (`FindHypotheses`)"
               text["RegisterWithoutGuess"] = "ours: and all of them refined, with the decision (`Register`)"
               text["RegisterByXiao"] = "Xiao, planes of 2 m^2 and more"
               text["RegisterByXiaoWithAllPlanes"] = "Xiao, all planes"
               print "| | hall, 30 planes | yard, 30 planes | hall, all planes | yard, all planes |"
               print "|---|---|---|---|---|"
               for (n = 1; n <= names; ++n) {{
                 line = "| " text[order[n]] " |"
                 for (k = 0; k < 4; ++k) {{
                   key = order[n] " " k % 2 " " (k < 2 ? 30 : 1000)
                   planes = key in source ? sprintf(" (%d x %d)", source[key], target[key]) : ""
                   line = line sprintf(" %.1f%s |", time[key], planes)
                 }}
                 print line
               }}
             }}' {output}.json
           bash {FOOTER} {VERSION:q} {params.conventions:q}; }} > {output}
        rm {output}.json
        """

# On the 30 largest planes of every scan of the data sets.
TABLES.append("matching-sets")

rule matching_sets_table:
    input: [] if PAIRS_ABSENT else [*files(PAIRS), "hashes/pairs.txt"]
    output: table("matching-sets")
    params:
        absent=why_absent(PAIRS) or lacks("matching_table"), data=DATA, program=program("matching_table"),
        tool=hash_of(program("matching_table")),
        conventions="CPU milliseconds on one thread, the least of up to 50 runs, mean over the pairs; the 30 largest planes of every scan. Matching: "
        "`FindHypotheses`, the planes that its best pose makes one, and the closed form. Xiao: all 30 planes take part. Near: within 0.5 m and "
        "3 deg of the reference. Ratio: Xiao to matching, of the sums; then of single pairs. The scans are those of the pairs' table.",
    shell:
        """
        if [ -n "{params.absent}" ]; then printf '*skipped: %s*\\n' {params.absent:q} > {output}; exit; fi
        {{ {params.program} {params.data:q}; bash {FOOTER} {VERSION:q} {params.conventions:q} hashes/pairs.txt; }} > {output}
        """
