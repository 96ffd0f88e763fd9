# Scans looked for in drone maps without a start pose (docs/localization.md).
TABLES += ["localization-site", "localization-simulated"]
DOCS.add("localization")
LOCATED = config["localization"]
LOCATED_FILES = LOCATED["inputs"]
LOCATED_ABSENT = why_absent(LOCATED_FILES) or lacks("locate_table")
LOCATED_SITES = [f"{scene}-{seed}" for scene in LOCATED["scenes"] for seed in LOCATED["seeds"]]

rule located_hash:
    input: files(LOCATED_FILES)
    output: "hashes/located-site.txt"
    shell: "cat {input:q} | sha256sum | cut -c1-64 > {output}"

# Exit code 1 of locate_table: a scan was found in a wrong place; the table says so.
LOOK = """
        out=$(realpath -m {output})
        (cd {params.folder:q} && {params.locate_table} {params.sites}) > $out.new || [ $? -eq 1 ]
        sed '1,/^###/{{/^###/!d}}' $out.new > $out
        rm $out.new
        """
LOCATE_TABLE = program("locate_table")

rule locate_in_site:
    input: files(LOCATED_FILES)
    output: "located/site.md"
    params: folder=DATA, sites=LOCATED["site"], locate_table=LOCATE_TABLE, tool=hash_of(LOCATE_TABLE)
    threads: config["threads"]
    shell: LOOK

rule locate_in_simulated:
    input: [f"located/{site}/site.yaml" for site in LOCATED_SITES]
    output: "located/simulated.md"
    params: folder="located", sites=LOCATED_SITES, locate_table=LOCATE_TABLE, tool=hash_of(LOCATE_TABLE)
    threads: config["threads"]
    shell: LOOK

rule localization_site:
    input: [] if LOCATED_ABSENT else ["located/site.md", "hashes/located-site.txt"]
    output: table("localization-site")
    params: absent=LOCATED_ABSENT, conventions="CPU seconds on one thread."
    shell:
        """
        if [ -n "{params.absent}" ]; then printf '*skipped: %s*\\n' {params.absent:q} > {output}; exit; fi
        {{ cat located/site.md; bash {FOOTER} {VERSION:q} {params.conventions:q} hashes/located-site.txt; }} > {output}
        """

rule localization_simulated:
    input: [] if lacks("locate_table") else ["located/simulated.md"]
    output: table("localization-simulated")
    params: absent=lacks("locate_table"), conventions="CPU seconds on one thread."
    shell:
        """
        if [ -n "{params.absent}" ]; then printf '*skipped: %s*\\n' {params.absent:q} > {output}; exit; fi
        {{ cat {input}; bash {FOOTER} {VERSION:q} {params.conventions:q}; }} > {output}
        """

rule simulate_located:
    output: "located/{scene}-{seed}/site.yaml"
    params: program=PLANEGRAPH_HASH
    shell:
        "{PLANEGRAPH} simulate --scene={wildcards.scene} --seed={wildcards.seed} "
        "--output_dir=located/{wildcards.scene}-{wildcards.seed} --quiet"
