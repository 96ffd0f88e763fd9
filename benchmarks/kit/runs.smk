# Runs of `planegraph map`, each set with each configuration, and what is measured of them.

def simulated_sets():
    options = config["simulated"]
    return {
        f"simulated-{scene}-{seed}": dict(
            title=f"simulated {scene}, seed {seed}", scene=scene, seed=seed,
            site=f"sites/{scene}-{seed}/site.yaml", scans=f"sites/{scene}-{seed}/scans/scan*.ply",
            start=f"sites/{scene}-{seed}/odometry.tum", reference=f"sites/{scene}-{seed}/truth.tum", align="se3")
        for scene in options["scenes"] for seed in options["seeds"]
    }


SIMULATED = simulated_sets()


def real_set(name):
    """Its paths in the data folder, or why it is skipped."""
    given = dict(config["sets"][name])
    patterns = [given["site"], *given["inputs"]]
    given["absent"] = why_absent(patterns)
    given["inputs"] = files(patterns)
    for key in ("site", "scans", "start", "reference"):
        if key in given:
            given[key] = data(given[key])
    given["others"] = {key: data(path) for key, path in given.get("others", {}).items()}
    return given


REAL = {name: real_set(name) for name in config["sets"]}
SETS = {**REAL, **SIMULATED}
START = "start"  # the configuration of the poses that `map` starts from


def set_of(wildcards):
    return SETS[wildcards.set]


def run_inputs(wildcards):
    one = set_of(wildcards)
    return one["inputs"] if "inputs" in one else [one["site"]]


def trajectory(name, configuration):
    if configuration == START:
        return SETS[name]["start"]
    others = SETS[name].get("others", {})
    return others[configuration] if configuration in others else f"runs/{name}/{configuration}/poses.tum"


rule simulate:
    output: "sites/{scene}-{seed}/site.yaml", "sites/{scene}-{seed}/odometry.tum", "sites/{scene}-{seed}/truth.tum"
    params: options=config["simulated"]["options"], program=PLANEGRAPH_HASH
    shell:
        "{PLANEGRAPH} simulate --scene={wildcards.scene} --seed={wildcards.seed} {params.options} "
        "--output_dir=sites/{wildcards.scene}-{wildcards.seed} --quiet"

# Exit code 3 is a result, too: what is known is written, and the tables show it.
rule map:
    input: run_inputs
    output:
        report="runs/{set}/{configuration}/report.json",
        poses="runs/{set}/{configuration}/poses.tum",
        cpu="runs/{set}/{configuration}/cpu.json",
    params:
        flags=lambda wildcards: config["configurations"][wildcards.configuration],
        site=lambda wildcards: set_of(wildcards)["site"],
        repeats=config["repeats"], threads=config["threads"], program=PLANEGRAPH_HASH,
    threads: config["threads"]
    shell:
        r"""
        folder=$(dirname {output.report}); work=$(mktemp -d "$folder/.map.XXXXXX"); trap 'rm -rf "$work"' EXIT
        TIMEFORMAT='%3U %3S'
        for run in $(seq {params.repeats}); do
          code=0
          {{ time {PLANEGRAPH} map {params.site} {params.flags} --threads={params.threads} --output_dir="$work" --quiet \
            2>"$folder/log.txt" ; }} 2>>"$work/times" || code=$?
          [ "$code" -eq 0 ] || [ "$code" -eq 3 ] || {{ cat "$folder/log.txt" >&2; exit "$code"; }}
        done
        awk '{{ all = all (NR == 1 ? "" : ", ") $1 + $2 }} END {{ print "{{\"cpu_seconds\": [" all "]}}" }}' \
          "$work/times" > {output.cpu}
        cp "$work"/trajectory_*.tum {output.poses}  # of its one robot
        cp "$work/report.json" {output.report}
        """


def estimate(wildcards):
    return trajectory(wildcards.set, wildcards.configuration)


# A measure without a result keeps its reason.
MEASURE = r"""
        code=0
        {PLANEGRAPH} evaluate {params.what} {params.flags} --output={output} --quiet 2>{output}.log || code=$?
        if [ "$code" -eq 3 ] && [ ! -e {output} ]; then printf '{{"reason": "no result"}}\n' > {output}; code=0; fi
        [ "$code" -eq 0 ] || [ "$code" -eq 3 ] || {{ cat {output}.log >&2; exit "$code"; }}
        rm -f {output}.log
        """

rule trajectory_error:
    input: estimate=estimate, reference=lambda wildcards: set_of(wildcards)["reference"]
    output: "runs/{set}/{configuration}/error.json"
    params:
        what=lambda wildcards, input: f"--estimate={input.estimate} --reference={input.reference}",
        flags=lambda wildcards: config["evaluation"]["trajectory"] + " --align=" + set_of(wildcards)["align"],
        program=PLANEGRAPH_HASH,
    shell: MEASURE

rule sharpness:
    input: estimate=estimate, scans=lambda wildcards: sorted(glob.glob(set_of(wildcards)["scans"]))
    output: "runs/{set}/{configuration}/sharpness.json"
    params:
        what=lambda wildcards, input: f"--estimate={input.estimate} '--scans=" + set_of(wildcards)["scans"] + "'",
        flags=config["evaluation"]["sharpness"], program=PLANEGRAPH_HASH,
    shell: MEASURE


def measured(name, configuration):
    """The files that a row of tables is made of."""
    folder = f"runs/{name}/{configuration}/"
    kinds = ["sharpness.json"] * ("inputs" in SETS[name]) + ["error.json"] * ("reference" in SETS[name])
    kinds += ["cpu.json"] * (configuration in config["configurations"])
    return [folder + kind for kind in kinds]


def row(label, name, configuration):
    absent = SETS[name].get("absent")
    return f"{label}=!{absent}" if absent else f"{label}=runs/{name}/{configuration}"


def present(names):
    return [name for name in names if not SETS[name].get("absent")]


def hashes(names):
    return [f"hashes/{name}.txt" for name in present(names)]

# One hash over a set's files, in the order of their names.
rule hash:
    input: run_inputs
    output: "hashes/{set}.txt"
    shell: "cat {input:q} | sha256sum | cut -c1-64 > {output}"
