"""Job "curved": the camera's rays against bicubic faces, reflected, and by Morion with shadow tests.

Morion meets the faces of its STEP file, as it is read back, and tests every reflected ray for shadow by proof; batoid
meets one Bicubic, with the heights of the upper panel in every fourth pixel, and reflects, without shadow tests or edges.
Both have the same vertical rays and one core; preparations are not counted.
"""

from common import Row, installed

# In every process the fastest of so many counts: single passes last 10 ms.
PASSES = 9


def job(bench):
    folder = bench.target / "peers" / "curved"

    def ours():
        bench.process(
            bench.cargo_bench("trace", "--step", "-", "--dump", folder, "--runs", PASSES)
        )
        line = (folder / "morion.txt").read_text().split("curved_pairs_1 ")[1]
        # Of one ray, so that numbers of rays may differ.
        return 1e-6 / float(line.split()[0])

    def theirs():
        _, said = bench.said(bench.peer("curved_peers.py", folder, PASSES))
        return said["seconds"] / said["rays"], said

    programs = {"morion": ours}
    programs |= {peer: theirs for peer in installed("curved", {"batoid": "batoid"})}
    made = bench.turns(programs)
    rows = []
    for peer in list(made)[1:]:
        said = made[peer][-1][1]
        both = (
            f"seconds a ray; {said['rays']} of batoid's rays within {said['off_mm']:.1e} mm of Morion's; "
            "Morion with shadow tests, one core"
        )
        seconds = [seconds for seconds, _ in made[peer]]
        rows.append(Row("curved", "batoid Bicubic", seconds, made["morion"], both, said["off_mm"] < 1e-4))
    return rows, None
