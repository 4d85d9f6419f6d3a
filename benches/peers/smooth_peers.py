#!/usr/bin/env python3
"""Traces the trials of a Monte Carlo run by batoid or Optiland.

usage: smooth_peers.py SYSTEM.json TRIALS.csv batoid|optiland RMS.npy

SYSTEM.json is the mirror that smooth.py describes, TRIALS.csv Morion's: the decentre and tilt of each
part are read from it and nothing else. Each made part's mirror is traced at the pixels that stand for
the picture; the content that a ray sees belongs to an image point (the parabolic law), and its
distance from that of the mirror as designed is the displacement. Writes its RMS of every trial, px,
and the directions of the mirror as designed.

- batoid: a Paraboloid, or the sum of it and a Zernike, in a CoordSys.
- Optiland: a reflecting surface of a StandardGeometry or PolynomialGeometry with a CoordinateSystem.

The trials are shared out among as many processes of one thread as there are cores: a thousand rays
are too few to share out.
"""

import csv
import json
import math
import multiprocessing
import os
import sys
import warnings

os.environ |= dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")

import numpy as np

from smooth import pixels


def turned(tilt):
    """Turned about X, then about Y."""
    (sx, sy), (cx, cy) = np.sin(tilt), np.cos(tilt)
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    return np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]]) @ about_x


class Batoid:
    def __init__(self, system, points):
        import batoid

        self.batoid, self.vertex = batoid, np.array([0, 0, system["vertex_mm"]])
        self.surface = batoid.Paraboloid(-system["focal_mm"])
        if any(system["zernike_mm"]):
            departure = batoid.Zernike(np.array(system["zernike_mm"]), R_outer=system["radius_mm"])
            self.surface = batoid.Sum([self.surface, departure])
        count = len(points)
        down = np.zeros(count), np.zeros(count), np.full(count, -1.0)
        top = np.full(count, system["top_mm"])
        self.rays = batoid.RayVector(*points.T, top, *down)

    def directions(self, shift, tilt):
        turn = turned(tilt)
        place = self.batoid.CoordSys(shift + turn @ self.vertex, turn)
        rays = self.rays.copy()
        self.batoid.reflect(self.surface, rays, coordSys=place)
        return rays.v @ turn.T


class Optiland:
    def __init__(self, system, points):
        warnings.simplefilter("ignore")
        from optiland.optic import Optic
        from optiland.rays import RealRays

        self.make, self.vertex = RealRays, np.array([0, 0, system["vertex_mm"]])
        optic = Optic()
        shape = {"radius": -system["focal_mm"], "conic": -1, "material": "mirror", "is_stop": True}
        if any(system["zernike_mm"]):
            # The part of each that the paraboloid has is its own.
            shape |= {"surface_type": "polynomial", "coefficients": np.array(system["departure"])}
        optic.surfaces.add(index=0, thickness=np.inf)
        optic.surfaces.add(index=1, thickness=-1, **shape)
        optic.surfaces.add(index=2)
        self.surface = optic.surfaces[1]
        count = len(points)
        top, none = np.full(count, system["top_mm"]), np.zeros(count)
        # Intensity and wavelength, um, are asked for.
        self.rays = [
            *points.T,
            top,
            none,
            none,
            np.full(count, -1.0),
            np.ones(count),
            np.full(count, 0.55),
        ]

    def directions(self, shift, tilt):
        place = self.surface.geometry.cs
        place.x, place.y, place.z = shift + turned(tilt) @ self.vertex
        place.rx, place.ry = tilt
        rays = self.surface.trace(self.make(*self.rays), record=False)
        return np.column_stack([rays.L, rays.M, rays.N])


def main():
    with open(sys.argv[1]) as file:
        system = json.load(file)
    with open(sys.argv[2]) as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        axes = ["decentre_x_um", "decentre_y_um", "tilt_x_mrad", "tilt_y_mrad"]
        errors = 1e-3 * np.array([[float(row[axis]) for axis in axes] for row in rows])
    points = pixels(system)
    mirror = {"batoid": Batoid, "optiland": Optiland}[sys.argv[3]](system, points)

    def content(directions):
        return system["focal_mm"] * directions[:, :2] / (1 + directions[:, 2:])

    # What is compiled at the first call is compiled once for all processes.
    designed = mirror.directions(np.zeros(3), np.zeros(2))
    at = content(designed)

    def traced(share, answers):
        rms = []
        for x, y, *tilt in share:
            off = content(mirror.directions(np.array([x, y, 0.0]), np.array(tilt))) - at
            rms.append(math.sqrt((off * off).sum() / len(off)) / system["pixel_mm"])
        answers.send(rms)

    # Forked, they have everything.
    context, working = multiprocessing.get_context("fork"), []
    for share in np.array_split(errors, len(os.sched_getaffinity(0))):
        answers, end = context.Pipe(duplex=False)
        worker = context.Process(target=traced, args=(share, end))
        worker.start()
        # So that a worker that fails ends the reading.
        end.close()
        working.append(answers)
    rms = [figure for answers in working for figure in answers.recv()]
    np.savez(sys.argv[4], rms=rms, directions=designed)
    print(json.dumps({"trials": len(rms), "pixels": len(points)}))


if __name__ == "__main__":
    main()
