#!/usr/bin/env python3
"""Reads the rows of a study by Python's csv and by Arrow, and writes them as Parquet.

usage: check_sweep.py MORION

A study of numbers, of texts that are hard on a table, and of points that fail. Every field of rows.csv is that of rows.ndjson; Arrow
reads the lines of JSON with one type for each column, and what it writes as Parquet is the same when it is read again.
"""

import csv
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

import pyarrow.json
import pyarrow.parquet

STUDY = """
profile = "panoramic"
[[axis]]
key = "part.width_mm"
values = [40, -1, 60.5]
[[axis]]
key = "summary"
values = ["plain", "=1+1", "a,\\"b\\"", "two\\nlines", "-x", "\u00b1\u00b0"]
[[axis]]
key = "part.base_mm"
values = [3, 3, 3, 4, 4, 4]
paired_with = "summary"
[[column]]
key = "design.pixel_error_px.rms"
goal = "least"
[[column]]
key = "design.minimax"
[[column]]
key = "design.method"
"""


def as_field(value):
    """A value of JSON as a field of CSV."""
    if value is None:
        return ""
    if isinstance(value, str):
        return ("'" if value[:1] in tuple("=+-@") else "") + value
    return json.dumps(value)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    morion = shutil.which(sys.argv[1]) or sys.exit(f"no program {sys.argv[1]}")
    with tempfile.TemporaryDirectory() as home:
        home = pathlib.Path(home)
        (home / "study.toml").write_text(STUDY, encoding="utf-8")
        run = [str(pathlib.Path(morion).resolve()), "sweep", "study.toml", "--quiet"]
        subprocess.run(run, cwd=home, check=True, stdout=subprocess.DEVNULL)
        folder = home / "out/sweep/study"
        lines = [json.loads(line) for line in (folder / "rows.ndjson").read_text(encoding="utf-8").splitlines()]
        with (folder / "rows.csv").open(newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        if len(lines) != 18 or len(rows) != 18:
            sys.exit(f"sweep: {len(lines)} lines and {len(rows)} rows in the place of 18")
        for line, row in zip(lines, rows):
            if list(line) != list(row) or any(as_field(line[key]) != row[key] for key in row):
                sys.exit(f"sweep: {line} is {row} in the CSV")
        table = pyarrow.json.read_json(folder / "rows.ndjson")
        pyarrow.parquet.write_table(table, home / "rows.parquet")
        again = pyarrow.parquet.read_table(home / "rows.parquet")
    if not again.equals(table) or again.to_pylist() != lines:
        sys.exit("sweep: Parquet has other rows than the lines of JSON")
    failed = sum(line["status"] != "made" for line in lines)
    print(f"sweep: {len(lines)} rows, {failed} of them failed, are the same as CSV, as lines of JSON and as Parquet")


if __name__ == "__main__":
    main()
