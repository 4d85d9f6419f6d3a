"""Job "read": an STL is read, its vertices merged, and it is checked as a solid.

trimesh says whether it is watertight, a volume, its Euler number and bodies. `morion verify` says the
same, and traces the camera's rays against it and holds its vertices against the design as well,
which is in its time. Whole processes.
"""

import json
import tempfile
from pathlib import Path

from common import Row, installed


def job(bench):
    if not installed("read", {"trimesh": "trimesh"}):
        return [], None
    with tempfile.TemporaryDirectory() as folder:
        bench.process([bench.morion, "build", "conquistador", "--quiet", "--out", folder])
        file = Path(folder) / "conquistador" / "mirror.stl"
        command = [
            bench.morion,
            "verify",
            file,
            "--profile",
            "conquistador",
            "--quiet",
            "--format",
            "json",
        ]

        def ours():
            seconds, printed = bench.process(command)
            (trace,) = json.loads(printed)["trace"]
            return seconds, trace["solid"]

        programs = {
            "morion": ours,
            "trimesh": lambda: bench.said(bench.peer("read_peers.py", file)),
        }
        made = bench.turns(programs)
        size = file.stat().st_size
    if "trimesh" not in made:
        return [], None
    solid, peer = made["morion"][-1][1], made["trimesh"][-1][1]
    agrees = (
        (peer["watertight"], peer["volume"])
        == (solid["closed"], solid["oriented"] and solid["manifold"])
        and peer["euler"] == solid["euler"]
        and peer["components"] == solid["components"]
        and abs(peer["volume_mm3"] / solid["volume_mm3"] - 1) <= 1e-6
    )
    off = abs(peer["volume_mm3"] / solid["volume_mm3"] - 1)
    both = (
        f"an STL of {peer['triangles']} triangles ({1e-6 * size:.0f} MB), whole processes: closed, "
        f"{peer['components']} body, Euler number {peer['euler']}, volumes equal to {off:.0e}; "
        "Morion also traces it and holds it against the design"
    )
    times = {name: [seconds for seconds, _ in runs] for name, runs in made.items()}
    return [Row("read", "trimesh", times["trimesh"], times["morion"], both, agrees)], None
