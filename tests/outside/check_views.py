#!/usr/bin/env python3
"""Asks OpenCV where the corners of a chequered floor are in what `morion unwrap` makes of its picture in a mirror.

usage: check_views.py MORION OUT NAME...

A floor of squares in two colours, an OBJ, is rendered through the shipped mirror NAME with a larger frame, and unwrapped to a plan
(`--ground`). A wall of such squares, so far away that a mirror is a point, is unwrapped to a view in perspective (`--view`), where it must be
what a pinhole camera sees. `cv2.cornerSubPix` finds the corners from places that are up to a pixel beside where they belong; each must be
found within 0.1 px of where it belongs.

Corners are chosen before any is looked for: those whose window is seen, where a pixel of the picture is at least SCALE px of the photo in
every direction, and at most MOST, and whose squares are at least LEAST px across, with angles of at least ANGLE degrees: corners of flat ones are sharp along one line alone.
They are looked for in linear light, as in that of a PNG a pixel half dark and half light is a light one, which moves edges; and smoothed
by BLUR px, as OpenCV takes differences of neighbours for derivatives, which edges within a pixel do not have.

Each check is made of an altered picture too, which must fail: a floor 2 % lower, a view with another field.
"""

import json
import pathlib
import re
import subprocess
import sys

import cv2
import numpy as np
from verdicts import told

OFF = 0.1  # px
SCALE, MOST, LEAST = 1.2, 6.0, 14.0
ANGLE, BLUR = 35, 1.0
COUNT = 40  # corners at least
FAR = 1e8  # mm to the wall
SQUARE_PX, ASLANT = 24, 15  # squares of the wall: their side in the view, and how they are turned in it, degrees

# Edits of the shipped profile; the floor: its Z, squares, range and pixel, mm; and the view: azimuth, elevation and field, degrees, and
# pixels across; none of mirrors that are made for a near target or have too few pixels ahead.
MIRRORS = {
    "hyperbolic": ({r"\[480, 480\]": "[1680, 1680]", "focal_px = 800": "focal_px = 2800"}, (400, 80, 700, 4), ((20, 40, 70), 288)),
    "parabolic": ({r"\[480, 480\]": "[1680, 1680]"}, (300, 60, 600, 3), ((-100, 40, 70), 256)),
    "conquistador": ({r"\[640, 480\]": "[2560, 1920]"}, (100, 20, 320, 1.2), ((35, 5, 45), 360)),
    "robot-floor": ({r"\[1280, 960\]": "[1920, 1440]"}, (620, 80, 1200, 4), None),
    "soccer": ({r"\[320, 240\]": "[1920, 1440]", "pixel_um = 12": "pixel_um = 2"}, (204, 100, 900, 5), None),
}


def run(*arguments):
    done = subprocess.run(list(map(str, arguments)), capture_output=True, text=True, timeout=1800)
    if done.returncode >= 2:
        raise RuntimeError(done.stderr[-400:])
    return done.stdout


def chequered(path, middle, sides, half):
    """An OBJ of squares with these sides, `half` of them to each side of the middle; and their corners, where four meet, in its order."""
    steps = np.arange(-half, half + 1)
    j, i = np.meshgrid(steps, steps, indexing="ij")
    places = middle + i.reshape(-1, 1) * sides[0] + j.reshape(-1, 1) * sides[1]
    path.with_suffix(".mtl").write_text("newmtl light\nKd 0.9 0.9 0.9\nnewmtl dark\nKd 0.05 0.05 0.05\n")
    text = [f"mtllib {path.stem}.mtl"] + ["v {:.12g} {:.12g} {:.12g}".format(*place) for place in places]
    count = len(steps)
    for colour, odd in [("light", 0), ("dark", 1)]:
        text.append(f"usemtl {colour}")
        for row in range(count - 1):
            for column in range(count - 1):
                if (row + column) % 2 == odd:
                    first = row * count + column + 1
                    text.append(f"f {first} {first + 1} {first + count + 1} {first + count}")
    path.write_text("\n".join(text) + "\n")
    inner = (np.abs(i) < half) & (np.abs(j) < half)
    return places[inner.ravel()]


class Mirror:
    """A shipped mirror with a larger frame, in a folder of its own."""

    def __init__(self, morion, out, name):
        self.morion, self.out, self.name = morion, out, name
        edits, (self.z_mm, self.square, self.range_mm, self.mm_per_px), self.view = MIRRORS[name]
        text = (pathlib.Path(__file__).resolve().parents[2] / "profiles" / f"{name}.toml").read_text()
        for found, wanted in edits.items():
            text, count = re.subn(found, wanted, text)
            assert count == 1, found
        self.profile = out / f"{name}.toml"
        self.profile.write_text(text)
        self.folder = out / name

    def photo(self, kind, chequer, unit_mm):
        """The picture of squares in the mirror, by the designed surface; and their corners."""
        model = self.out / f"{self.name}-{kind}.obj"
        corners = chequered(model, *chequer)
        run(self.morion, "render", self.profile, "--scene", model, "--smooth", "--unit-mm", unit_mm, "--out", self.out, "--quiet")
        return self.folder / f"render-{model.stem}-obj.png", corners

    def unwrapped(self, photo, kind, *options):
        """Light, map and report of a picture that the photo is unwrapped to."""
        told = run(self.morion, "unwrap", photo, "--profile", self.profile, "--map", "npy", "--out", self.out, "--format", "json", "--quiet", *options)
        light = linear(cv2.imread(str(self.folder / f"{photo.stem}-{kind}.png"), cv2.IMREAD_GRAYSCALE))
        return light, np.load(self.folder / f"{photo.stem}-{kind}-map.npy").astype(float), json.loads(told)


def linear(encoded):
    """Linear light of sRGB's 8 bits."""
    share = encoded / 255
    light = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    return light.astype(np.float32)


def suited(places, found, sides):
    """Which of the places in a picture can be looked for, see above; and how far the lines beside each are."""
    height, width, _ = places.shape
    seen = places[..., 0] >= 0
    across, down = np.gradient(places, axis=1), np.gradient(places, axis=0)
    jacobian = np.stack([across, down], axis=-1)
    apart, least = np.full(len(found), np.inf), np.full(len(found), np.inf)
    for a in sides[:2]:
        for b in sides[2:]:
            area = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
            one, other = np.linalg.norm(a, axis=1), np.linalg.norm(b, axis=1)
            apart = np.minimum(apart, area / np.maximum(np.maximum(one, other), 1e-9))
            least = np.minimum(least, area / np.maximum(one * other, 1e-9))
    chosen = []
    for k, (x, y) in enumerate(found):
        reach = int(window(apart[k])) + 3
        column, row = int(round(x)), int(round(y))
        if not (reach <= column < width - reach and reach <= row < height - reach):
            continue
        if apart[k] < LEAST or least[k] < np.sin(np.radians(ANGLE)):
            continue
        if not seen[row - reach : row + reach + 1, column - reach : column + reach + 1].all():
            continue
        around = jacobian[row - reach : row + reach + 1, column - reach : column + reach + 1]
        scales = np.linalg.svd(around, compute_uv=False)
        if scales.min() >= SCALE and scales.max() <= MOST:
            chosen.append(k)
    return np.array(chosen, int), apart


def window(apart):
    """Half of the window in which a corner is looked for: its corners are within the four squares, also where these lie aslant."""
    return max(3, min(8, int(apart / 3)))


def off_px(light, wanted, apart):
    """How far from where they belong the corners are found."""
    start = wanted + np.random.default_rng(3).uniform(-0.7, 0.7, wanted.shape)
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 100, 1e-4)
    light = cv2.GaussianBlur(light, (0, 0), BLUR)
    found = []
    for at, distance in zip(start, apart):
        half = window(distance)
        one = np.float32(at).reshape(1, 1, 2)
        found.append(cv2.cornerSubPix(light, one, (half, half), (-1, -1), criteria).reshape(2))
    return np.linalg.norm(np.array(found) - wanted, axis=1)


def judged(kind, picture, altered, at, sides):
    """Figures of the corners, and what is wrong with them; `at` says where in the picture a place belongs."""
    light, places, corners = picture
    wanted = at(corners)
    around = [at(corners + way) - wanted for way in [sides[0], -sides[0], sides[1], -sides[1]]]
    chosen, apart = suited(places, wanted, around)
    wrong = []
    if len(chosen) < COUNT:
        return f"{kind}: {len(chosen)} corners", [f"{kind}: {len(chosen)} corners are too few"]
    off = off_px(light, wanted[chosen], apart[chosen])
    if not off.max() <= OFF:
        wrong.append(f"{kind}: a corner is {off.max():.3f} px off")
    if off_px(altered, wanted[chosen], apart[chosen]).max() <= 2 * OFF:
        wrong.append(f"{kind}: an altered picture passes")
    seen = places[..., 0] >= 0
    enclosed = seen[:-2, 1:-1] & seen[2:, 1:-1] & seen[1:-1, :-2] & seen[1:-1, 2:]
    holes = (enclosed & ~seen[1:-1, 1:-1]).sum()
    if holes:
        wrong.append(f"{kind}: {holes} pixels are holes")
    return f"{kind}: {len(chosen)} corners within {off.max():.3f} px, {np.sqrt((off**2).mean()):.3f} rms", wrong


def ground(mirror):
    square = mirror.square
    sides = np.array([[square, 0, 0], [0, square, 0]])
    half = int(np.ceil(mirror.range_mm / square)) + 1
    photo, corners = mirror.photo("floor", (np.array([0, 0, mirror.z_mm]), sides, half), 1)
    scale = ["--mm-per-px", mirror.mm_per_px, "--range-mm", mirror.range_mm]
    altered, _, _ = mirror.unwrapped(photo, "ground", "--ground", 1.02 * mirror.z_mm, *scale)
    light, places, report = mirror.unwrapped(photo, "ground", "--ground", mirror.z_mm, *scale)
    corner, step = report["ground"]["corner_mm"], [report["ground"]["mm_per_px"], report["ground"]["row_mm"]]
    # As seen from the mirror: along Z rows go down with Y.
    assert step[1] * mirror.z_mm > 0, step

    def at(corners):
        return (corners[:, :2] - corner) / step - 0.5

    return judged("ground", (light, places, corners), altered, at, sides)


def view(mirror):
    (azimuth, elevation, field), width = mirror.view
    a, e, aslant = np.radians([azimuth, elevation, ASLANT])
    ahead = np.array([np.cos(e) * np.sin(a), np.cos(e) * np.cos(a), np.sin(e)])
    right = np.cross(ahead, [0, 0, 1])
    right /= np.linalg.norm(right)
    up = np.cross(right, ahead)
    focal = width / 2 / np.tan(np.radians(field) / 2)
    side = SQUARE_PX / focal
    sides = side * np.array([np.cos(aslant) * right + np.sin(aslant) * up, np.cos(aslant) * up - np.sin(aslant) * right])
    half = int(0.75 * width / SQUARE_PX) + 1
    photo, corners = mirror.photo("wall", (ahead, sides, half), FAR)
    altered, _, _ = mirror.unwrapped(photo, "view", "--view", f"{azimuth},{elevation},{1.02 * field}", "--width", width)
    light, places, report = mirror.unwrapped(photo, "view", "--view", f"{azimuth},{elevation},{field}", "--width", width)
    _, height = report["view"]["pixels"]

    def at(corners):
        depth = corners @ ahead
        x, y = focal * (corners @ right) / depth, focal * (corners @ up) / depth
        return np.column_stack([width / 2 + x, height / 2 - y]) - 0.5

    return judged("view", (light, places, corners), altered, at, sides)


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    morion, out = sys.argv[1], pathlib.Path(sys.argv[2])
    out.mkdir(parents=True, exist_ok=True)

    def complaints(name):
        mirror = Mirror(morion, out, name)
        checks = [ground(mirror)] + ([view(mirror)] if mirror.view else [])
        return "; ".join(figures for figures, _ in checks), [why for _, wrong in checks for why in wrong]

    sys.exit(told("views", sys.argv[3:], complaints))


if __name__ == "__main__":
    main()
