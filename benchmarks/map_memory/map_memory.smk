# The front end of drone maps in bounded memory (docs/architecture.md): copies of a simulated quarter side by side.
TABLES += ["map-memory"]
DOCS.add("architecture")
MAP_MEMORY = config["map_memory"]

rule map_memory_table:
    output: table("map-memory")
    params:
        absent=lacks("map_memory_table"), program=program("map_memory_table"), tool=hash_of(program("map_memory_table")),
        runs=MAP_MEMORY["runs"],
        conventions="27 bytes a point in the file.",
    threads: config["threads"]
    shell:
        """
        if [ -n "{params.absent}" ]; then printf '*skipped: %s*\\n' {params.absent:q} > {output}; exit; fi
        mkdir -p map_memory && rm -f map_memory/lines
        for run in {params.runs:q}; do {params.program} map_memory $run >> map_memory/lines; done
        rm -f map_memory/*.ply
        {{ awk 'NR <= 2 || !/points|---/' map_memory/lines; bash {FOOTER} {VERSION:q} {params.conventions:q}; }} > {output}
        """
