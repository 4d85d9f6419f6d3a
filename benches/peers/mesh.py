"""Job "mesh": surfaces with one chord tolerance by Morion, pydelatin, gmsh and OpenCASCADE.

Every mesh is a process of its own, and its seconds are those of the mesher's call; Morion's hold
everything, the proof too, and both panels of a folded mirror. All meshes are measured alike, by
sampling every triangle against the formula.
"""

import json

import numpy as np

from common import Row, installed
from surfaces import Surface, chord_error

CHORD_UM = 1
ALL = ["bowl", "saddle", "bowl-16-to-1", "mixed", "conquistador", "conformal"]
PEERS = {
    "pydelatin": "pydelatin",
    "gmsh-isotropic": "gmsh",
    "gmsh-metric": "gmsh",
    "opencascade": "OCP",
}


def written(path):
    """Vertices and triangles of the binary PLY that Morion's benchmark writes."""
    with open(path, "rb") as file:
        count = {}
        while (line := file.readline().split()) != [b"end_header"]:
            if line[0] == b"element":
                count[line[1]] = int(line[2])
        vertices = np.fromfile(file, "<f8", 3 * count[b"vertex"]).reshape(-1, 3)
        face = np.dtype([("corners", "u1"), ("vertices", "<u4", 3)])
        return vertices, np.fromfile(file, face, count[b"face"])["vertices"]


def job(bench):
    rows = []
    detail = [
        f"Meshes with a chord tolerance of {CHORD_UM} um:\n",
        "| surface | program | triangles | over least | true max um | over least at true | median s |",
        "|---|---|---|---|---|---|---|",
    ]
    peers = installed("mesh", PEERS)
    for name in ALL if bench.surface == "all" else [bench.surface]:
        more, lines = meshed(bench, name, peers)
        rows += more
        detail += lines
    return rows, "\n".join([*detail, ""])


def meshed(bench, name, peers):
    """Rows of one surface, and its lines of the detailed table."""
    folder = bench.target / "peers" / "surfaces" / name
    asked = ["--write", folder, "--chord-um", CHORD_UM, "--runs", 1, "--only", name]

    def ours():
        bench.process(bench.cargo_bench("mesh", *asked))
        (given,) = json.loads((folder / "surfaces.json").read_text())
        return given["seconds"], given

    def theirs(program):
        _, said = bench.said(bench.peer("mesh_peers.py", folder, name, program))
        return said["seconds"], None

    programs = {"morion": ours}
    programs |= {peer: lambda peer=peer: theirs(peer) for peer in peers}
    made = bench.turns(programs)

    surface = Surface(made["morion"][-1][1])
    rows, lines, found = [], [], {}
    for program, runs in made.items():
        if program == "morion":
            vertices, triangles = written(folder / f"{name}.ply")
        else:
            mesh = np.load(folder / f"{name}-{program}.npz")
            vertices, triangles = mesh["vertices"], mesh["triangles"]
        found[program] = len(triangles), 1e3 * chord_error(surface, vertices, triangles)
        seconds = sorted(seconds for seconds, _ in runs)
        over = len(triangles) / surface.least
        share = found[program][1] / CHORD_UM
        lines.append(
            f"| {name} | {program} | {len(triangles)} | {over:.2f} | {found[program][1]:.3f} "
            f"| {over * share:.2f} | {seconds[len(seconds) // 2]:.3f} |"
        )
    count, worst = found["morion"]
    for program in list(made)[1:]:
        both = (
            f"{name} within {CHORD_UM} um: {found[program][0]} triangles, largest error "
            f"{found[program][1]:.3f} um; Morion {count}, {worst:.3f} um"
        )
        times = {key: [seconds for seconds, _ in made[key]] for key in (program, "morion")}
        rows.append(
            Row(
                "mesh",
                program,
                times[program],
                times["morion"],
                both,
                worst <= CHORD_UM * (1 + 1e-9),
            )
        )
    return rows, lines
