# `snakemake docs` puts the tables into the pages of docs/, between the marks that name them. Their prose is written by hand.
PAGES = [os.path.join(ROOT, f"docs/{page}.md") for page in sorted(DOCS)]

rule docs:
    input: [table(name) for name in TABLES]
    output: touch("docs.done")
    params: pages=PAGES, here=HERE
    shell:
        """
        if grep -l 'skipped: [nt]' {input}; then echo 'docs/ shows all sets: name a data folder that has them' >&2; exit 1; fi
        for page in {params.pages}; do
          awk -v folder=tables -f {params.here}/kit/insert_tables.awk $page > $page.new || {{ rm -f $page.new; exit 1; }}
          if cmp -s $page $page.new; then rm $page.new; else mv $page.new $page; fi
        done
        """
