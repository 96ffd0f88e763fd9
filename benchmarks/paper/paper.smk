# The paper's tables I to V for one site (docs/paper_tables.md), and its test of localization as table VI.
TABLES += ["paper", "paper-localization"]
DOCS.add("paper_tables")
PAPER = config["paper"]
PAPER_FILES = [PAPER["site"], *PAPER["inputs"]]
PAPER_ABSENT = why_absent(PAPER_FILES) or lacks("paper_tables")

rule paper_hash:
    input: files(PAPER_FILES)
    output: "hashes/paper-site.txt"
    shell: "cat {input:q} | sha256sum | cut -c1-64 > {output}"

rule paper_tables:
    input: [] if PAPER_ABSENT else [*files(PAPER_FILES), "hashes/paper-site.txt"]
    output: table("paper")
    params:
        absent=PAPER_ABSENT, site=data(PAPER["site"]), paper_tables=program("paper_tables"), tool=hash_of(program("paper_tables")),
        conventions="Times are wall-clock seconds on one thread, the least of 5 runs.",
    shell:
        """
        if [ -n "{params.absent}" ]; then printf '*skipped: %s*\\n' {params.absent:q} > {output}; exit; fi
        {{ {params.paper_tables} {params.site:q} | sed '1{{/^$/d}}'
           bash {FOOTER} {VERSION:q} {params.conventions:q} hashes/paper-site.txt; }} > {output}
        """

# The scans of the short run, each by itself, out of the table of all scans.
rule paper_localization:
    input: table("localization-site")
    output: table("paper-localization")
    shell:
        """
        awk -F ' *[|] *' '
          BEGIN {{ print "| scan | covered by the map | result | best pose off, m | deg | *paper* |"; print "|---|---|---|---|---|---|" }}
          /^#### .*each scan alone/ {{ alone = 1 }}
          /^#### / && !/each scan alone/ {{ alone = 0 }}
          /skipped/ {{ print "| " $0 " | | | | | |" }}
          alone && $2 ~ "^sortie1/" {{
            print "| " $2 " | " $3 " | " $4 " | " $5 " | " $6 " | *" (n++ < 5 ? "located" : "too little overlap") "* |" }}
        ' {input} > {output}
        {{ echo; tail -1 {input}; }} >> {output}
        """
