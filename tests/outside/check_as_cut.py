#!/usr/bin/env python3
"""Holds what `morion program` says of a milled mirror against Embree, and against balls that are moved along the programs here.

usage: check_as_cut.py OUT NAME...

OUT/NAME.toml is the profile, OUT/NAME/mirror.obj a mesh of the mirror much finer than its scallops, OUT/NAME/program what
`morion program` wrote, and OUT/NAME/machining.json what `morion machining` foresaw of the same ball and lines.

- Embree on as-cut.stl: counts of rays, ray, pixel and facet errors (RMS) must be those of program.json within SHARE. The picture's law
  and its errors are those of check_pictures.py, the designed mirror's directions those of the normals in mirror.obj.
- That facet error must be what machining.json foresees within FORESEEN, as must that of the balls of finishing.ngc (swept.py), which
  cut the face again, without facets, over PLACES pixels; and both must be alike within FACETS.
- After each program these balls must leave what program.json says, at both places that it names, within LEFT; and nowhere in the
  pixels' places less than it says by more than that.

Prints a line for each; exits 1 if any fails. Before the first mirror it is proven that the check can fail: of an as-cut file that is
0.1 % larger, of one that lies half a stepover beside its place, of a ball 5 % larger, and of one 2 um lower.
"""

import json
import pathlib
import sys
import tomllib

import numpy as np
from check_pictures import rms
from check_rays import corners_of, seen_by_embree
from milled_mirror import Seen, on_plane, reflected, upright
from mirror_obj import mirror_of
from ngc import moves
from swept import lowest
from verdicts import told

SHARE = 1e-4  # of each figure: rays through edges
FORESEEN = 0.02  # of the error, first order in the stepover
FACETS = 0.02  # of the error: eight facets from line to line, and rows of them beside the cusps
LEFT = 1.0  # um, and what the mesh is off
PLACES = 20_000
STEPS = 8  # of a ray to the cut


def by_balls(seen, path, ball, at, which):
    """Places and directions of rays in what balls along the program leave, from the mirror's places on."""
    at, leaving = at.copy(), np.zeros_like(at)
    for _ in range(STEPS):
        z, centres = lowest(path, ball, at[which, :2])
        foot = np.column_stack([at[which, :2], z])
        normal = (centres - foot) / ball
        at[which] = on_plane(seen.origins[which], seen.ways[which], foot, normal)
    leaving[which] = reflected(seen.ways[which], normal)
    return at, leaving


def apart(pairs):
    """What is wrong: names, what was found, what is said, and the share of that and the least by which both may differ."""
    return [
        f"{name} {found:.7g} for {said:.7g}"
        for name, found, said, share, least in pairs
        if not abs(found - said) <= share * abs(said) + least
    ]


def by_embree(seen, corners, said):
    """The RMS facet error of an as-cut file, what is met where, figures in short, and what is wrong."""
    facet, at, leaving, clear = seen.meet(corners)
    ray, image = (rms(error) for error in seen.errors(at, leaving, clear))
    facets = rms(seen.displaced(at, leaving, clear))
    pairs = [
        ("rays", len(facet), said["rays"], 0, 2),
        ("hits", int(clear.sum()), said["hit"], 0, 5),
        ("ray error", 1e3 * ray, said["ray_error_mrad"]["rms"], SHARE, 0),
        ("pixel error", image, said["pixel_error_px"]["rms"], SHARE, 0),
        ("facet error", facets, said["facet_error_px"]["rms"], SHARE, 0),
    ]
    off = max(abs(found / said - 1) for _, found, said, *_ in pairs[2:])
    figures = f"{int(clear.sum())} rays, pixel error {image:.4f} px, facet error {facets:.4f} px, within {off:.1e} of Morion's"
    return facets, (at, leaving, clear), figures, apart(pairs)


def some(clear):
    which = np.flatnonzero(clear)
    return np.random.default_rng(1).choice(which, min(PLACES, len(which)), replace=False)


def by_program(seen, folder, ball, met):
    """RMS facet errors over some pixels, by balls along the finishing program and by the as-cut file."""
    at, leaving, clear = met
    which = some(clear)
    path, _ = moves(folder / "program" / "finishing.ngc")
    balls = by_balls(seen, np.array(path), ball, seen.mirror[0], which)
    return [rms(seen.displaced(*of, which)) for of in (balls, (at, leaving))]


def left(seen, folder, report, allowed_um, clear, lower_um=0.0):
    """What each program leaves at the places of program.json and over some pixels: figures in short, and what is wrong."""
    operations, top = report["operations"], report["stock"]["size_mm"][2]
    named = [o["left"][key] for o in operations for key in ("least_at_mm", "most_at_mm")]
    pixels = seen.mirror[0][some(clear), :2]
    places = np.concatenate([named, pixels])
    above = np.column_stack([places, np.full(len(places), top + 1)])
    down = np.broadcast_to([0, 0, -1.0], above.shape)
    facet = seen_by_embree(seen.corners, above, down)
    three = seen.corners[facet]
    mirror = on_plane(above, down, three[:, 0], np.cross(three[:, 1] - three[:, 0], three[:, 2] - three[:, 0]))
    lean = upright(seen, facet, mirror)[:, 2]
    heights, figures, wrong = np.full(len(places), top), [], []
    for k, operation in enumerate(operations):
        name, said = operation["operation"], operation["left"]
        path, _ = moves(folder / "program" / operation["file"])
        heights = np.minimum(heights, lowest(np.array(path), operation["ball_mm"], places)[0])
        um = 1e3 * (heights - mirror[:, 2]) * lean - lower_um
        figures.append(f"{name} {um[len(named):].min():.2f} to {um[len(named):].max():.2f}")
        least, most = um[2 * k : 2 * k + 2]
        pairs = [(least, said["least_um"]), (most, said["most_um"])]
        wrong += apart([(f"{name} leaves", found, um_said, 0, allowed_um) for found, um_said in pairs])
        if not um[len(named) :].min() >= said["least_um"] - allowed_um:
            wrong.append(f"{name} leaves {um[len(named):].min():.2f} um, not {said['least_um']:.2f}")
    return ", ".join(figures), wrong


class Mirror:
    """A milled mirror's files."""

    def __init__(self, out, name):
        self.folder = out / name
        profile = tomllib.loads((out / f"{name}.toml").read_text())
        report = json.loads((self.folder / "report.json").read_text())
        self.said = json.loads((self.folder / "program" / "program.json").read_text())
        self.seen = Seen(profile, report["layout"], *mirror_of(self.folder / "mirror.obj"))
        self.cut = corners_of(self.folder / "program" / "as-cut.stl")
        self.allowed_um = LEFT + report["mesh"]["chord_um"]["bound"]

    def by_embree(self, cut):
        return by_embree(self.seen, cut, self.said["as_cut"]["trace"])

    def foreseen(self, facets, met, larger=1.0):
        """By the study of the same ball and lines, against facets and against balls that are so much larger."""
        ball = self.said["program"]["ball_mm"] * larger
        by_balls, by_facets = by_program(self.seen, self.folder, ball, met)
        balls = facets * by_balls / by_facets
        study = json.loads((self.folder / "machining.json").read_text())["pixel_error_px"]["rms"]
        wrong = apart(
            [
                ("foreseen_px", self.said["foreseen_px"]["rms"], study, 1e-9, 0),
                ("facet error", facets, study, FORESEEN, 0),
                ("facet error of balls", balls, study, FORESEEN, 0),
                ("facet error", facets, balls, FACETS, 0),
            ]
        )
        return f"{study:.4f} px foreseen, {facets / study:.4f} of it by facets, {balls / study:.4f} by balls", wrong

    def left(self, clear, lower_um=0.0):
        return left(self.seen, self.folder, self.said, self.allowed_um, clear, lower_um)

    def must_fail(self, facets, met):
        """Complaints, if altered files and cutters pass."""
        aside = 0.5 * self.said["operations"][-1]["stepover_mm"]
        angle = np.radians(self.said["angle_deg"])
        shift = aside * np.array([-np.sin(angle), np.cos(angle), 0])
        altered = {
            "a file 0.1 % larger": self.by_embree(1.001 * self.cut)[-1],
            "a file half a stepover aside": self.by_embree(self.cut + shift)[-1],
            "a ball 5 % larger": self.foreseen(facets, met, 1.05)[1],
            "a ball 2 um lower": self.left(met[2], 2.0)[1],
        }
        return [f"{what} passes" for what, wrong in altered.items() if not wrong]


def main(out, *names):
    out, checks = pathlib.Path(out), {}
    for name in names:
        checks |= {f"{name}, {what}": (name, what) for what in ("rays", "forecast", "left")}
    mirrors = {}

    def complaints(check):
        name, what = checks[check]
        if name not in mirrors:
            mirrors.clear()
            mirrors[name] = mirror = Mirror(out, name)
            mirror.found = mirror.by_embree(mirror.cut)
        mirror = mirrors[name]
        facets, met, figures, wrong = mirror.found
        if what == "rays":
            blind = mirror.must_fail(facets, met) if name == names[0] else None
            return figures + (", altered files fail" if blind == [] else ""), wrong + (blind or [])
        return mirror.foreseen(facets, met) if what == "forecast" else mirror.left(met[2])

    return told("as cut", checks, complaints)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]) if len(sys.argv) > 2 else __doc__)
