# Spreads the points of a study over jobs and joins them: see README.md.

import tomllib
from pathlib import Path

configfile: f"{workflow.basedir}/sweep.yaml"

STUDY, OUT = str(config["study"]), str(config["out"])
JOBS = int(config["parts"])
MORION = str(config["morion"])
if JOBS < 1:
    raise WorkflowError(f"parts must be 1 or more, found {JOBS}")

# In a pattern of files they would stand for wildcards, and nothing escapes them.
if set("{}") & set(STUDY + OUT):
    raise WorkflowError(f"study and out must have no braces: rename {STUDY} or {OUT}")

FOLDER = f"{OUT}/sweep/{Path(STUDY).stem}"
PROFILE = Path(STUDY).parent / tomllib.loads(Path(STUDY).read_text(encoding="utf-8"))["profile"]
# A shipped profile is no file.
NEEDED = [STUDY] + ([str(PROFILE)] if PROFILE.is_file() else [])

localrules: all

rule all:
    input:
        f"{FOLDER}/sweep.json",

# The journal of a job is not its output: Snakemake would remove it with all its points when the job fails.
rule shard:
    input:
        NEEDED,
    output:
        touch(FOLDER + "/shard-{number}-of-{all}.done"),
    wildcard_constraints:
        number=r"\d+",
        all=r"\d+",
    threads: int(config["threads"])
    shell:
        "{MORION:q} sweep {STUDY:q} --shard {wildcards.number}/{wildcards.all}"
        " --threads {threads} --out {OUT:q} --quiet"

# Exit code 1 is that no point has figures, which is in the report.
rule join:
    input:
        expand(FOLDER + "/shard-{number}-of-{all}.done", number=range(1, JOBS + 1), all=JOBS),
    output:
        f"{FOLDER}/sweep.json",
        f"{FOLDER}/sweep.html",
        f"{FOLDER}/rows.csv",
        f"{FOLDER}/rows.ndjson",
    threads: int(config["threads"])
    shell:
        "{MORION:q} sweep {STUDY:q} --threads {threads} --out {OUT:q} --quiet"
        " || [ $? -eq 1 ]"
