# Where things are, and what the rules share. Nothing here runs anything but `planegraph help` and `version`.

ROOT = os.path.dirname(workflow.basedir)
HERE = workflow.basedir


def place(key, fallback):
    """A folder that the user names, by the configuration or the environment."""
    named = config.get(key) or os.environ.get("PLANEGRAPH_" + key.upper())
    return os.path.abspath(named) if named else fallback


DATA = place("data", "")
BUILD = place("build", os.path.join(ROOT, "build/release"))
OUT = place("out", os.path.join(ROOT, "out/benchmarks"))
TABLES = []  # names of the tables, as the parts of the kit add them
DOCS = set()  # pages of docs/ with tables

# Rules run in OUT; whatever jobs parse this file again do so with the same places.
config.update(data=DATA, build=BUILD, out=OUT)


def program(name):
    for folder in ("tools", "benchmarks", "benchmarks/kit"):
        path = os.path.join(BUILD, folder, name)
        if os.access(path, os.X_OK):
            return path
    return ""


def hash_of(path):
    """Of a program: a rule with it among its parameters runs again when the bytes of the program change, not its date."""
    if not path:
        return "absent"
    with open(path, "rb") as stream:
        return hashlib.sha256(stream.read()).hexdigest()[:12]


PLANEGRAPH = program("planegraph")
JSON_TABLE = program("json_table")
if not PLANEGRAPH or not JSON_TABLE:
    raise WorkflowError(
        f"{BUILD} has no planegraph and json_table: cmake --preset release -DPLANEGRAPH_BUILD_BENCHMARKS=ON, "
        "cmake --build --preset release, or --config build=FOLDER")
PLANEGRAPH_HASH = hash_of(PLANEGRAPH)
JSON_TABLE_HASH = hash_of(JSON_TABLE)


def output_of(*command):
    return subprocess.run(command, capture_output=True, text=True).stdout


VERSION = output_of(PLANEGRAPH, "version").strip()
COMMANDS = {line.split()[0] for line in output_of(PLANEGRAPH, "help").splitlines() if line.startswith("  ")}


def data(path):
    return os.path.join(DATA, path)


def files(patterns):
    """The files in the data folder that match; empty where there is no data folder or one pattern finds nothing."""
    found = [sorted(path for path in glob.glob(data(pattern)) if os.path.isfile(path)) for pattern in patterns]
    return [path for paths in found for path in paths] if DATA and all(found) else []


def why_absent(patterns):
    """Empty where the files are there, else the reason that the tables give."""
    if not DATA:
        return "no data folder was named"
    missing = [pattern for pattern in patterns if not files([pattern])]
    return "not in the data folder: " + ", ".join(missing) if missing else ""


def lacks(name):
    """Why a table is skipped whose program was not built; empty where it was."""
    return "" if program(name) else f"the build has no {name} (-DPLANEGRAPH_BUILD_BENCHMARKS=ON)"


def table(name):
    return f"tables/{name}.md"



FOOTER = os.path.join(HERE, "kit/footer.sh")  # the line under a table: versions, machine, hashes, conventions


def columns(name):
    return os.path.join(HERE, name)
