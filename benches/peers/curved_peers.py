#!/usr/bin/env python3
"""Reflects the rays of FOLDER at a Bicubic of batoid, and holds where they meet it against Morion's hits.

usage: curved_peers.py FOLDER RUNS

FOLDER is what `cargo bench --bench trace -- --step - --dump FOLDER` makes of the conquistador: vertical rays in rows, of
which those of the upper panel are taken. The fastest of RUNS counts, on one thread.
"""

import json
import os
import sys
import time
from pathlib import Path

os.environ["OMP_NUM_THREADS"] = "1"

import batoid
import numpy as np

COLUMNS, ROWS = 640, 480
STEP = 4  # pixels between nodes


def main(folder, runs):
    rays = np.fromfile(folder / "rays.f64").reshape(ROWS, COLUMNS, 6)
    found = np.fromfile(folder / "found.f64").reshape(ROWS, COLUMNS, 6)
    heights = rays[:, :, 2] - found[:, :, 2]
    # Rows from the top; the upper panel without those beside the crest, Y rising.
    upper = slice(ROWS // 2 - 2, None, -1)
    rays, heights = rays[upper], heights[upper]
    nodes = np.s_[::STEP, ::STEP]
    xs, ys = rays[0, ::STEP, 0], rays[::STEP, 0, 1]
    surface = batoid.Bicubic(xs, ys, heights[nodes])
    # Between the nodes.
    inner = np.s_[2 * STEP : -2 * STEP, 2 * STEP : -2 * STEP]
    x, y, top = (rays[inner][:, :, k].ravel() for k in range(3))
    down = np.zeros_like(x), np.zeros_like(x), np.full_like(x, -1.0)
    rows = batoid.RayVector(x, y, top, *down)
    times = []
    for _ in range(runs):
        copy = rows.copy()
        began = time.perf_counter()
        batoid.reflect(surface, copy)
        times.append(time.perf_counter() - began)
    off = np.abs(copy.z - heights[inner].ravel()).max()
    print(json.dumps({"seconds": min(times), "rays": len(x), "off_mm": float(off)}))


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]))
