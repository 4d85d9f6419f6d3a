"""Job "rays": the camera's rays against the facets, with the shadow tests of the reflected ones.

Morion, Embree and Mitsuba 3 trace the same rays against the same triangles, each in a process on one
core, and answer for each ray the facet and whether the reflected ray is in shadow. What depends on
the mesh alone (their tree, our tables) is built before, and the ratio with it is told beside.
"""

import statistics

from common import Row, installed

# In every process the fastest of so many counts: single passes last 10 ms.
PASSES = 9


def job(bench):
    folder = bench.target / "peers" / "rays"

    def ours():
        bench.process(bench.cargo_bench("trace", "--dump", folder, "--runs", PASSES))
        lines = (folder / "morion.txt").read_text().splitlines()
        said = dict(line.split(" ", 1) for line in lines)
        milliseconds = float(said["pairs_1"].split("(")[1].split()[0])
        tables = sum(float(said[f"build_{what}_1"].split()[0]) for what in ("general", "proofs"))
        return 1e-3 * milliseconds, 1e-3 * tables

    def theirs(program):
        _, said = bench.said(bench.peer("rays_peers.py", folder, program, PASSES))
        return said["seconds"], said

    programs = {"morion": ours}
    peers = installed("rays", {"embree": "embreex", "mitsuba": "mitsuba"})
    programs |= {peer: lambda peer=peer: theirs(peer) for peer in peers}
    made = bench.turns(programs)

    rows = []
    our_seconds = [seconds for seconds, _ in made["morion"]]
    tables = statistics.median(tables for _, tables in made["morion"])
    for peer in list(made)[1:]:
        seconds = [seconds for seconds, _ in made[peer]]
        said = made[peer][-1][1]
        built = statistics.median(said["built_seconds"] for _, said in made[peer])
        whole = (statistics.median(seconds) + built) / (statistics.median(our_seconds) + tables)
        different = said["facets_different"], said["shadows_different"]
        both = (
            f"{said['rays']} rays with shadow tests against {said['triangles']} triangles, one core: "
            f"{said['ties']} ties, {different[0]} other facets, {different[1]} other shadows; "
            f"with building {whole:.1f}"
        )
        name = {"embreex": "Embree 4 (embreex)"}.get(said["name"], f"Mitsuba 3 ({said['name']})")
        rows.append(Row("rays", name, seconds, our_seconds, both, different == (0, 0)))
    return rows, None
