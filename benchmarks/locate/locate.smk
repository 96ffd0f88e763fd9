# Scans looked for in drone maps without a start pose (docs/localization.md).
TABLES += ["localization-site", "localization-simulated"]
DOCS.add("localization")
LOCATED = config["localization"]
LOCATED_FILES = LOCATED["inputs"]
LOCATED_ABSENT = why_absent(LOCATED_FILES)
LOCATED_SITES = [f"{scene}-{seed}" for scene in LOCATED["scenes"] for seed in LOCATED["seeds"]]

rule located_hash:
    input: files(LOCATED_FILES)
    output: "hashes/located-site.txt"
    shell: "cat {input:q} | sha256sum | cut -c1-64 > {output}"

# Exit code 1 of locate_table: a scan was found in a wrong place; the table says so.
rule localization_site:
    input: [] if LOCATED_ABSENT else [*files(LOCATED_FILES), "hashes/located-site.txt"]
    output: table("localization-site")
    params:
        absent=LOCATED_ABSENT, site=LOCATED["site"], data=DATA,
        locate_table=program("locate_table"), tool=hash_of(program("locate_table")),
        conventions="CPU seconds on one thread.",
    threads: config["threads"]
    shell:
        """
        if [ -n {params.absent:q} ]; then printf '*skipped: %s*\\n' {params.absent:q} > {output}; exit; fi
        out=$(realpath -m {output})
        (cd {params.data:q} && {params.locate_table} {params.site}) > $out.all || [ $? -eq 1 ]
        sed '1,/^###/{{/^###/!d}}' $out.all > $out
        rm $out.all
        bash {FOOTER} {VERSION:q} {params.conventions:q} hashes/located-site.txt >> $out
        """

rule simulate_located:
    output: "located/{scene}-{seed}/site.yaml"
    params: program=PLANEGRAPH_HASH
    shell:
        "{PLANEGRAPH} simulate --scene={wildcards.scene} --seed={wildcards.seed} "
        "--output_dir=located/{wildcards.scene}-{wildcards.seed} --quiet"

rule localization_simulated:
    input: [f"located/{site}/site.yaml" for site in LOCATED_SITES]
    output: table("localization-simulated")
    params:
        sites=LOCATED_SITES, locate_table=program("locate_table"), tool=hash_of(program("locate_table")),
        conventions="CPU seconds on one thread.",
    threads: config["threads"]
    shell:
        """
        out=$(realpath -m {output})
        (cd located && {params.locate_table} {params.sites}) > $out.all || [ $? -eq 1 ]
        sed '1,/^###/{{/^###/!d}}' $out.all > $out
        rm $out.all
        bash {FOOTER} {VERSION:q} {params.conventions:q} >> $out
        """
