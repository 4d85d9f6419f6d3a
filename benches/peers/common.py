"""What every job needs: our programs, processes in turns, and rows of the table."""

import importlib.util
import json
import os
import platform
import re
import statistics
import subprocess
import sys
import time
from dataclasses import dataclass
from datetime import date
from pathlib import Path

HERE = Path(__file__).resolve().parent


@dataclass
class Row:
    """A peer beside Morion in one job; seconds of every run, in turns."""

    job: str
    peer: str
    theirs: list
    ours: list
    both: str
    # Whether both did the same.
    agrees: bool = True


class Failed(Exception):
    """A program ended with an error."""


class Bench:
    """Where things are, and how often they are run."""

    def __init__(self, root, target, runs, surface):
        self.root, self.target, self.runs, self.surface = root, target, runs, surface
        self.morion = target / "release" / "morion"
        build = ["cargo", "build", "--quiet", "--release", "--locked"]
        subprocess.run(build, cwd=root, check=True)

    def cargo_bench(self, name, *arguments):
        """The benchmark's own process, as it was built by cargo."""
        return ["cargo", "bench", "--quiet", "--locked", "--bench", name, "--", *arguments]

    def peer(self, script, *arguments):
        return [sys.executable, HERE / script, *arguments]

    def turns(self, programs):
        """What each program returned, run by run; Morion, the first, must not fail.

        `programs` are names and functions that return seconds and anything.
        """
        made = {name: [] for name in programs}
        for run in range(self.runs):
            for place, (name, program) in enumerate(programs.items()):
                if name not in made:
                    continue
                try:
                    made[name].append(program())
                    said = f"{made[name][-1][0]:.3f} s"
                except Failed as error:
                    if place == 0:
                        sys.exit(f"run: {error}")
                    del made[name]
                    said = f"skipped: {error}"
                print(f"run {run + 1}: {name}: {said}", file=sys.stderr)
        return made

    def process(self, command):
        """Wall time of a whole process, start-up and all, and what it printed."""
        command = list(map(str, command))
        quiet = {"capture_output": True, "text": True, "stdin": subprocess.DEVNULL}
        start = time.perf_counter()
        done = subprocess.run(command, cwd=self.root, **quiet)
        seconds = time.perf_counter() - start
        if done.returncode != 0:
            last = (done.stderr.strip() or done.stdout.strip()).splitlines()[-1:]
            raise Failed(f"{Path(command[0]).name} ended with {done.returncode}: {' '.join(last)}")
        return seconds, done.stdout

    def said(self, command):
        """The same with the JSON object that it printed last."""
        seconds, printed = self.process(command)
        return seconds, json.loads(printed.splitlines()[-1])


def installed(job, peers):
    """Those of the peers, names and packages, that can be imported; the others are named."""
    found = {}
    for name, package in peers.items():
        if importlib.util.find_spec(package):
            found[name] = package
        else:
            print(f"run: {job}: {name} is not installed and is skipped", file=sys.stderr)
    return found


def heading(runs):
    model = platform.processor()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        found = re.search(r"^model name\s*: (.*)$", cpuinfo.read_text(), re.MULTILINE)
        model = found[1] if found else model
    cores, load = len(os.sched_getaffinity(0)), os.getloadavg()[2]
    return (
        f"{model or platform.machine()}, {cores} logical cores, {date.today()}, "
        f"{runs} runs each in turns, mean load of the last 15 minutes {load:.1f}\n"
    )


def figures(seconds):
    """Median, with the least and the greatest."""
    digits = 3 if statistics.median(seconds) >= 0.1 else 4
    middle, low, high = statistics.median(seconds), min(seconds), max(seconds)
    return f"{middle:.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"


def table(rows):
    lines = [
        "| job | peer | peer median s | Morion median s | ratio | what both did |",
        "|---|---|---|---|---|---|",
    ]
    for row in rows:
        ratio = statistics.median(row.theirs) / statistics.median(row.ours)
        ratio = f"{ratio:.1f}" if ratio < 20 else f"{ratio:.0f}"
        both = row.both if row.agrees else f"DIFFERENT: {row.both}"
        times = f"{figures(row.theirs)} | {figures(row.ours)}"
        lines.append(f"| {row.job} | {row.peer} | {times} | **{ratio}** | {both} |")
    return "\n".join(lines)
