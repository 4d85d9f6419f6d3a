#!/usr/bin/env python3
"""Asks Embree, OpenCV and ffmpeg about the look-up tables of `morion table`.

usage: check_tables.py MORION OUT [--ffmpeg] NAME...

OUT/NAME.toml is the profile, OUT/NAME/ what was built of it. Tables are made with a node in each pixel.

- Embree: the floor that 1000 random pixels show in the written STL is that of the table, within what the facets displace.
- OpenCV: `cv2.omnidir` has the directions of mirrors with a single viewpoint, whose model follows from the profile alone.
- ffmpeg, where it is asked for: its `remap` with the PGM pair and `cv2.remap` with the NumPy array make the same plan of a rendered picture within one level.

Each check is made of an altered table too, which must fail.
"""

import json
import math
import pathlib
import subprocess
import sys
import tomllib

import cv2
import numpy as np
from check_rays import camera_rays, corners_of, focal_px, mirrored, seen_by_embree
from verdicts import told

COUNT = 1000
SLACK_PX = 0.01  # beyond the facets' own bound: single precision of both sides
NEAR = 3e-6  # rad, of directions in single precision
SAME = 0.999  # of the pixels: nearest ones tie in single precision


def run(*arguments):
    done = subprocess.run(list(map(str, arguments)), capture_output=True, text=True, timeout=900)
    if done.returncode >= 2:
        raise RuntimeError(done.stderr[-400:])


class Table:
    """A table with a node in each pixel, and what it was made of."""

    def __init__(self, morion, out, name, floor_mm):
        self.folder, self.name, self.floor_mm = out / name / "table", name, floor_mm
        profile = out / f"{name}.toml"
        run(morion, "table", profile, "--out", out, "--every", "1", "--floor-mm", floor_mm, "--quiet")
        self.profile = tomllib.loads(profile.read_text())
        self.report = json.loads((out / name / "report.json").read_text())
        numbers = np.load(self.folder / "table.npy").astype(float)
        self.height, self.width, _ = numbers.shape
        self.numbers = numbers.reshape(self.height * self.width, -1)


def vectors(azimuth_deg, elevation_deg):
    azimuth, elevation = np.radians(azimuth_deg), np.radians(elevation_deg)
    level = np.cos(elevation)
    return np.column_stack([level * np.sin(azimuth), level * np.cos(azimuth), np.sin(elevation)])


def floors(table, out, chosen):
    """Places of the floor that Embree sees at these pixels."""
    corners = corners_of(out / table.name / "mirror.stl")
    origins, directions = camera_rays(table.profile, table.report["layout"], corners)
    origins, directions = origins[chosen], directions[chosen]
    facet = seen_by_embree(corners, origins, directions)
    met = corners[facet]
    normal = np.cross(met[:, 1] - met[:, 0], met[:, 2] - met[:, 0])
    along = np.einsum("ij,ij->i", met[:, 0] - origins, normal) / np.einsum("ij,ij->i", directions, normal)
    at = origins + directions * along[:, None]
    leaving = mirrored(met, directions)
    way = (table.floor_mm - at[:, 2]) / leaving[:, 2]
    return (at + leaving * way[:, None])[:, :2]


def by_embree(table, out):
    """How far places of the floor are off at most, px, and what facets displace at most."""
    floor = table.numbers[:, 4:6]
    grid = floor.reshape(table.height, table.width, 2)
    across = np.full_like(grid, np.nan)
    down = np.full_like(grid, np.nan)
    across[:, 1:-1] = 0.5 * (grid[:, 2:] - grid[:, :-2])
    down[1:-1] = 0.5 * (grid[2:] - grid[:-2])
    across, down = across.reshape(-1, 2), down.reshape(-1, 2)
    # (Across a ridge differences are none.)
    area = across[:, 0] * down[:, 1] - across[:, 1] * down[:, 0]
    long = np.maximum(np.linalg.norm(across, axis=1), np.linalg.norm(down, axis=1))
    usable = np.flatnonzero(np.isfinite(area) & (np.abs(area) > 0.02 * long**2))
    chosen = np.random.default_rng(1).choice(usable, min(COUNT, len(usable)), replace=False)
    found = floors(table, out, chosen)
    facet_px = max(trace["facet_error_px"]["max"] for trace in table.report["trace"])

    def off_px(shift):
        off = found - floor[chosen] - shift * across[chosen]
        x = (off[:, 0] * down[chosen, 1] - off[:, 1] * down[chosen, 0]) / area[chosen]
        y = (across[chosen, 0] * off[:, 1] - across[chosen, 1] * off[:, 0]) / area[chosen]
        return np.hypot(x, y)

    # The derivatives themselves change from pixel to pixel: the 99th percentile is held to the bound, all to twice that.
    off, altered = off_px(0.0), off_px(2.0 * facet_px + 0.5)
    bound = facet_px + SLACK_PX
    wrong = []
    if len(chosen) < COUNT // 2:
        wrong.append(f"{len(chosen)} pixels show the floor")
    if not (np.quantile(off, 0.99) <= bound and off.max() <= 2.0 * bound):
        wrong.append(f"off by {np.quantile(off, 0.99):.3f} px, {off.max():.3f} at most, for {bound:.3f}")
    if np.quantile(altered, 0.99) <= bound:
        wrong.append("an altered table passes")
    return f"{len(chosen)} places of the floor within {off.max():.3f} px, facets {facet_px:.3f}", wrong


def by_omnidir(table):
    """The unit-sphere model of a conic with the camera at its other focus (Geyer and Daniilidis): xi = 2 e / (1 + e^2)."""
    (kind, law), *_ = table.profile["projection"].items()
    (camera, lens), *_ = table.profile["camera"].items()
    polar = math.radians(law["outer_polar_deg"])
    radius = 0.5 * table.profile["part"]["width_mm"]
    if kind == "hyperbolic":
        distance = lens["distance_mm"]
        to_viewpoint = radius / math.sin(polar)
        foci = distance + to_viewpoint * math.cos(polar)
        eccentricity = foci / (math.hypot(distance, radius) - to_viewpoint)
        xi, rim_px = 2 * eccentricity / (1 + eccentricity**2), focal_px(lens) * radius / distance
    else:
        xi, rim_px = 1.0, 0.5 * table.width
    gamma = rim_px * (math.cos(polar) + xi) / math.sin(polar)
    matrix = np.array([[gamma, 0, table.width / 2 - 0.5], [0, gamma, table.height / 2 - 0.5], [0, 0, 1]])
    shown = np.flatnonzero(np.isfinite(table.numbers[:, 0]))
    chosen = np.random.default_rng(2).choice(shown, COUNT, replace=False)
    places = np.column_stack([chosen % table.width, chosen // table.width]).astype(float)
    ours = vectors(*table.numbers[chosen, :2].T)

    def apart(xi):
        # Without a rotation; OpenCV gives X / Z and Y / Z, and loses the sign of Z beyond 90 degrees: the sphere's point is taken from it.
        q = cv2.omnidir.undistortPoints(places[None], matrix, np.zeros((1, 4)), np.array([[xi]]), np.eye(3)).reshape(-1, 2)
        seen = np.column_stack([q[:, 0], -q[:, 1], np.ones(len(q))])
        seen /= np.linalg.norm(seen, axis=1)[:, None]
        seen *= np.where(np.einsum("ij,ij->i", seen, ours) < 0, -1.0, 1.0)[:, None]
        return np.linalg.norm(np.cross(seen, ours), axis=1).max()

    found = apart(xi)
    wrong = [] if found <= NEAR else [f"directions {found:.1e} rad apart"]
    if apart(xi * (1 + 1e-4)) <= NEAR:
        wrong.append("another mirror passes")
    return f"{COUNT} directions within {found:.1e} rad of cv2.omnidir, xi {xi:.4f}", wrong


def by_ffmpeg(table, morion, out):
    """A plan of the floor of a rendered picture, by ffmpeg and by OpenCV."""
    run(morion, "render", out / f"{table.name}.toml", "--scene", "grid", "--smooth", "--out", out, "--quiet")
    picture = out / table.name / "render-grid.png"
    wrong, figures = [], []
    for name in ["floor", "panorama"]:
        plan = table.folder / f"{name}.png"
        maps = [table.folder / f"{name}-{axis}.pgm" for axis in "xy"]
        run("ffmpeg", "-v", "error", "-y", "-i", picture, "-i", maps[0], "-i", maps[1], "-lavfi", "[0]format=gbrp[p];[p][1][2]remap", plan)
        theirs = cv2.imread(str(plan)).astype(int)
        places = np.load(table.folder / f"{name}-map.npy")
        columns, rows = np.round(places[..., 0]), np.round(places[..., 1])
        source = cv2.imread(str(picture))
        ours = cv2.remap(source, columns.astype(np.float32), rows.astype(np.float32), cv2.INTER_NEAREST).astype(int)
        seen = places[..., 0] >= 0
        same = np.abs(theirs - ours).max(axis=2)[seen] <= 1
        figures.append(f"{name} {100 * same.mean():.3f} % of {seen.sum()}")
        # Pixels that are shown have neighbours that are: no holes.
        inside = seen[1:-1, 1:-1]
        around = seen[:-2, 1:-1].astype(int) + seen[2:, 1:-1] + seen[1:-1, :-2] + seen[1:-1, 2:]
        if (~inside & (around == 4)).mean() > 1e-4:
            wrong.append(f"{name}: {100 * (~inside & (around == 4)).mean():.2f} % of the pixels are holes")
        if same.mean() < SAME or seen.sum() < 10_000:
            wrong.append(f"{name}: {100 * same.mean():.3f} % of {seen.sum()} pixels within one level")
        shifted = np.abs(np.roll(theirs, 3, axis=1) - ours).max(axis=2)[seen] <= 1
        if shifted.mean() >= SAME:
            wrong.append(f"{name}: a shifted plan passes")
    return "ffmpeg's remap and cv2.remap agree, " + ", ".join(figures), wrong


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    morion, out, names = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3:]
    with_ffmpeg = names[0] == "--ffmpeg"
    names = names[with_ffmpeg:]

    def complaints(name):
        # Where most mirrors look: past the camera, or beside themselves.
        (kind, _), *_ = tomllib.loads((out / f"{name}.toml").read_text())["projection"].items()
        table = Table(morion, out, name, 400)
        checks = [by_embree(table, out)]
        if with_ffmpeg:
            checks.append(by_ffmpeg(table, morion, out))
        if kind in ("hyperbolic", "parabolic"):
            checks.append(by_omnidir(table))
        figures = "; ".join(figures for figures, _ in checks)
        return figures, [why for _, wrong in checks for why in wrong]

    sys.exit(told("tables", names, complaints))


if __name__ == "__main__":
    main()
