#!/usr/bin/env python3
"""Asks Embree what a camera sees of a target of triangles, and holds Morion's pixel errors against it.

usage: check_targets.py OUT NAME...

OUT/NAME.toml is a profile of a pinhole camera on the axis with a view in perspective of [target.mesh], whose middle is the
axis, and OUT/NAME/mirror.stl the file that was built of it. Embree finds the facet of the file that each pixel's ray
meets and the facet of the target that the reflected ray meets; where on their planes is found here, in double precision. RMS,
95th percentile and maximum of the pixel errors must be those of OUT/NAME/report.json within CLOSE pixels. Prints one line
per profile.

Before the first profile it is proven that the check can fail: with the target 1 mm to the side, it must.
"""

import json
import pathlib
import sys
import tomllib

import numpy as np
import trimesh
from check_rays import camera_rays, corners_of, mirrored, seen_by_embree
from verdicts import told

CLOSE = 2e-4  # px: one ray through an edge more or less


def meeting(corners, facet, origins, directions):
    """Where rays meet the planes of facets."""
    a, b, c = np.moveaxis(corners[facet], 1, 0)
    normal = np.cross(b - a, c - a)
    t = np.einsum("ij,ij->i", normal, a - origins) / np.einsum("ij,ij->i", normal, directions)
    return origins + t[:, None] * directions


def one(out, name, aside=0.0):
    profile = tomllib.loads((out / f"{name}.toml").read_text())
    report = json.loads((out / name / "report.json").read_text())
    layout, target = report["layout"], profile["target"]["mesh"]
    middle = np.array([0, 0, layout["mean_mm"]])
    room = trimesh.load_mesh(out / target["file"], process=False)
    room = room.triangles * target.get("unit_mm", 1) + middle + [aside, 0, 0]
    viewpoint = middle + target.get("viewpoint_mm", [0, 0, 0])

    corners = corners_of(out / name / "mirror.stl")
    origins, directions = camera_rays(profile, layout, corners)
    facet = seen_by_embree(corners, origins, directions)
    seen = facet >= 0
    at = meeting(corners, facet[seen], origins[seen], directions[seen])
    leaving = mirrored(corners[facet[seen]], directions[seen])
    met = seen_by_embree(room, at, leaving)
    missed = int((met < 0).sum())
    shown = meeting(room, met, at, leaving) - viewpoint

    width, height = profile["camera"]["pinhole"]["pixels"]
    focal = 0.5 * width / np.tan(np.radians(0.5 * profile["projection"]["perspective"]["hfov_deg"]))
    x, y = np.meshgrid(np.arange(width) + 0.5 - width / 2, height / 2 - np.arange(height) - 0.5)
    pixels = np.stack([x.ravel(), y.ravel()], 1)[seen]
    error = np.linalg.norm(focal * shown[:, :2] / shown[:, 2:] - pixels, axis=1)
    found = [np.sqrt(np.mean(error**2)), np.sort(error)[int(np.ceil(0.95 * len(error))) - 1], error.max()]
    told_by = report["trace"][0]["pixel_error_px"]
    wrong = [
        f"{key}: {told_by[key]} px, by Embree {value}"
        for key, value in zip(("rms", "p95", "max"), found)
        if not abs(told_by[key] - value) <= CLOSE
    ]
    if missed or len(error) < 10_000:
        wrong.append(f"{missed} rays miss the target, of {len(error)}")
    return f"{len(error)} pixels, {found[0]:.6f} px RMS, {found[2]:.6f} px at most", wrong


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    out, names = pathlib.Path(sys.argv[1]), sys.argv[2:]

    def complaints(name):
        figures, wrong = one(out, name)
        if name == names[0]:
            if one(out, name, aside=1.0)[1]:
                figures += ", a target 1 mm aside fails"
            else:
                wrong.append("a target 1 mm aside passes")
        return figures, wrong

    sys.exit(told("embree, targets", names, complaints))


if __name__ == "__main__":
    main()
