#!/usr/bin/env python3
"""Asks Embree which pixels obstacles hide, and holds Morion's witness against it, pixel by pixel.

usage: check_obstacles.py OUT NAME...

OUT/NAME.toml is a profile with obstacles before a world far away, OUT/NAME/mirror.stl the file that was built of it,
and OUT/NAME/rays what `cargo test --bench trace -- --profile OUT/NAME.toml --stl OUT/NAME/mirror.stl --dump
OUT/NAME/rays` wrote of the witness.

Obstacles are made into triangles here, from the profile and the places in OUT/NAME/report.json; Embree finds, in
single precision, which of them each camera ray meets before the mirror, and else each reflected ray, which obstacles
of a convex mirror alone can stop. The number of the obstacle must be Morion's in every pixel, but for those in
which Embree's answer depends on ROUNDING more or less of all obstacles; of these there may be MOST at the most. Prints
one line per profile.

Before the first profile it is proven that the check can fail: with obstacles 0.05 mm to the side, it must.
"""

import json
import pathlib
import sys
import tomllib

import numpy as np
from check_rays import camera_rays, corners_of, mirrored, seen_by_embree, turned
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh
from verdicts import told

SIDES = 8192  # of a circle: chords cut 1e-6 mm off the largest, of 22 mm
ROUNDING = 3e-5  # mm: single precision's, and that of chords
MOST = 4  # pixels that may depend on it
CLEAR = 1e-3  # mm of a reflected ray's way, on which it leaves the mirror
OBSTRUCTED = 4  # and the obstacle's number: what Morion writes of a hidden pixel


def box(centre, size, axes, grown):
    """Triangles of a box with edges along `axes`."""
    signs = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)])
    corners = centre + (signs * (np.array(size) / 2 + grown)) @ np.array(axes)
    sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return np.array([corners[list(f)] for a, b, c, d in sides for f in ((a, b, c), (a, c, d))])


def rings(start, end, radii, grown):
    """Points of circles about both ends of an axis: by end, by radius, around."""
    start, end = np.array(start, float), np.array(end, float)
    along = (end - start) / np.linalg.norm(end - start)
    start, end = start - grown * along, end + grown * along
    across = np.cross(along, np.eye(3)[np.abs(along).argmin()])
    across /= np.linalg.norm(across)
    turn = np.linspace(0, 2 * np.pi, SIDES, endpoint=False)[:, None]
    around = np.cos(turn) * across + np.sin(turn) * np.cross(along, across)
    return [[place + radius * around for radius in radii] for place in (start, end)]


def band(a, b):
    """Triangles between two circles of equally many points."""
    c, d = np.roll(a, -1, 0), np.roll(b, -1, 0)
    return np.concatenate([np.stack([a, b, c], 1), np.stack([c, b, d], 1)])


def cylinder(of, grown):
    radii = [0, of["radius_mm"] + grown]
    # A wall without thickness neither grows nor shrinks at its ends alone: it is longer.
    (hub, low), (top_hub, high) = rings(of["from_mm"], of["to_mm"], radii, grown)
    wall = band(low, high)
    return np.concatenate([wall, band(hub, low), band(top_hub, high)]) if of.get("solid", True) else wall


def tube(of, grown):
    radii = [of["inner_radius_mm"] - grown, of["outer_radius_mm"] + grown]
    (a, b), (c, d) = rings(of["from_mm"], of["to_mm"], radii, grown)
    return np.concatenate([band(a, c), band(b, d), band(a, b), band(c, d)])


def stl(path, grown):
    """Triangles of a text STL, drawn away from their middle."""
    lines = (line.split() for line in path.read_text().splitlines())
    corners = np.array([[float(x) for x in line[1:]] for line in lines if line[:1] == ["vertex"]])
    away = corners - corners.mean(0)
    corners += grown * away / np.abs(away).max()
    return corners.reshape(-1, 3, 3)


def triangles(folder, obstacle, grown):
    if "box" in obstacle:
        of = obstacle["box"]
        return box(np.array(of["centre_mm"]), of["size_mm"], np.eye(3), grown)
    if "cylinder" in obstacle:
        return cylinder(obstacle["cylinder"], grown)
    if "tube" in obstacle:
        return tube(obstacle["tube"], grown)
    return stl(folder / obstacle["stl"]["file"], grown)


def bodies(folder, profile, layout, grown):
    """Triangles of all obstacles, and last of the camera's body."""
    middle = np.array([0, 0, layout["mean_mm"]])
    found = [triangles(folder, o, grown) + middle for o in profile.get("obstacle", [])]
    (camera,) = profile["camera"].values()
    if "body_mm" in camera:
        along = layout.get("looks_along", [0, 0, -1])
        axes = turned(np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1]]), along)
        # The front face stays where the rays start.
        size = np.array(camera["body_mm"]) + [2 * grown, 2 * grown, 0]
        found.append(box(layout["pupil_mm"] + axes[2] * size[2] / 2, size, axes, 0))
    return found


def first(scene, origins, directions):
    """Number of the body that each ray meets first, or -1, and the distance."""
    met = scene.run(origins.astype(np.float32), directions.astype(np.float32), output=1)
    number = np.where(met["primID"] >= 0, met["geomID"], -1).astype(int)
    return number, np.where(number >= 0, met["tfar"], np.inf)


def hidden(corners, facet, rays, obstacles):
    """Number of the obstacle that hides each ray, or -1."""
    origins, directions = rays
    scene = rtcore_scene.EmbreeScene()
    meshes = [TriangleMesh(scene, body.astype(np.float32)) for body in obstacles]
    assert len(meshes) == len(obstacles)
    # The front of the camera's body goes through the place where rays start.
    before, distance = first(scene, origins + CLEAR * directions, directions)
    on = facet >= 0
    a, b, c = np.moveaxis(corners[facet], 1, 0)
    normal = np.cross(b - a, c - a)
    t = np.einsum("ij,ij->i", normal, a - origins) / np.einsum("ij,ij->i", normal, directions)
    t = np.where(on, t, np.inf)
    number = np.where(distance + CLEAR < t, before, -1)
    leaving = mirrored(corners[facet], directions)
    at = origins + np.where(on, t, 0)[:, None] * directions
    after, _ = first(scene, at + CLEAR * leaving, leaving)
    return np.where((number < 0) & on, after, number)


def one(out, name, aside=0.0):
    profile = tomllib.loads((out / f"{name}.toml").read_text())
    layout = json.loads((out / name / "report.json").read_text())["layout"]
    corners = corners_of(out / name / "mirror.stl")
    origins, directions = camera_rays(profile, layout, corners)
    if layout.get("pupil_mm") is None:
        # From above all obstacles.
        origins[:, 2] = 200
    seen = np.fromfile(out / name / "rays" / "found.f64").reshape(-1, 6)
    facet = seen_by_embree(corners, origins, directions)
    shift = np.array([aside, 0, 0])
    answers = []
    for grown in (0, ROUNDING, -ROUNDING):
        obstacles = [body + shift for body in bodies(out, profile, layout, grown)]
        answers.append(hidden(corners, facet, (origins, directions), obstacles))
    expected = answers[0]
    # Which facet a ray through an edge meets is the matter of check_rays.py.
    open_ = (facet != seen[:, 1].astype(int)) & (seen[:, 1] >= 0)
    tie = (answers[0] != answers[1]) | (answers[0] != answers[2]) | open_
    found = np.where(seen[:, 0] >= OBSTRUCTED, seen[:, 0] - OBSTRUCTED, -1).astype(int)
    wrong = []
    different = int(((found != expected) & ~tie).sum())
    if different:
        wrong.append(f"{different} pixels hidden otherwise")
    if int(tie.sum()) > MOST:
        wrong.append(f"{int(tie.sum())} pixels depend on rounding")
    counts = [int((expected == k).sum()) for k in range(len(obstacles))]
    if min(counts) < 20:
        wrong.append("an obstacle hides next to nothing")
    return f"{len(found)} pixels, behind obstacles {counts}, {int(tie.sum())} ties", wrong


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    out, names = pathlib.Path(sys.argv[1]), sys.argv[2:]

    def complaints(name):
        figures, wrong = one(out, name)
        if name == names[0]:
            if one(out, name, aside=0.05)[1]:
                figures += ", obstacles 0.05 mm aside fail"
            else:
                wrong.append("obstacles 0.05 mm aside pass")
        return figures, wrong

    sys.exit(told("embree, obstacles", names, complaints))


if __name__ == "__main__":
    main()
