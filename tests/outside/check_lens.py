"""Calibrations of cameras: what OpenCV writes, and the rays that it finds of pixels.

usage: check_lens.py FOLDER

`cv2.FileStorage` writes each lens as YAML, JSON and XML into FOLDER; Morion must read equal numbers from all three. Of
10 000 random places in the frame, Morion's rays and those of `cv2.undistortPoints` or `cv2.fisheye.undistortPoints`
(iterated to rounding) must agree to 1e-9, and `cv2.projectPoints` must bring Morion's rays back to where they came from
to 1e-9 px.

Before the first lens it is proven that the check can fail: with k1 changed by 1e-7 the rays must differ by more.
"""

import os
import pathlib
import subprocess
import sys

import cv2
import numpy as np
from verdicts import told

ROOT = pathlib.Path(__file__).parents[2]
NEAR = 1e-9  # of X / Z and Y / Z, and px: OpenCV's own iteration is what limits it
COUNT = 10_000
ENOUGH = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 1000, 1e-15)

FRAME = [640, 480]
MATRIX = [[612.125, 0, 331.2], [0, 611.4, 236.9], [0, 0, 1]]
WIDE = [[311.3, 0, 322.7], [0, 310.9, 238.1], [0, 0, 1]]
# Model, camera matrix and coefficients.
LENSES = {
    "straight": ("opencv", MATRIX, []),
    "barrel": ("opencv", MATRIX, [-0.29, 0.11, 0.0011, -0.0007]),
    "five": ("opencv", MATRIX, [-0.31, 0.14, -0.0008, 0.0012, -0.03]),
    "pincushion": ("opencv", MATRIX, [0.21, -0.08, 0.0004, 0.0003, 0.05]),
    "rational": ("opencv", WIDE, [0.31, 0.021, 0.0002, -0.0004, 0.0013, 0.66, 0.11, 0.006]),
    "prism": ("opencv", MATRIX, [-0.2, 0.05, 0.001, -0.001, 0.01, 0.02, -0.01, 0.003, 0.002, -0.001, -0.0015, 0.0008]),
    "fourteen": ("opencv", MATRIX, [-0.2, 0.05, 0.001, -0.001, 0.01, 0.02, -0.01, 0.003, 0.002, 0, 0.001, 0, 0, 0]),
    "fisheye": ("fisheye", WIDE, [-0.021, 0.0043, -0.0031, 0.0006]),
    "equidistant": ("fisheye", WIDE, [0, 0, 0, 0]),
    "stretched": ("fisheye", WIDE, [0.05, -0.01, 0.004, -0.0005]),
}


def write(path, model, matrix, coefficients):
    """As OpenCV's sample program for calibrations does."""
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write("calibration_time", "Mon 3 Feb 2025 10:11:12")
    storage.write("image_width", FRAME[0])
    storage.write("image_height", FRAME[1])
    storage.writeComment("flags: +fix_aspectRatio")
    storage.write("camera_matrix", np.array(matrix, float))
    storage.write("distortion_coefficients", np.array([coefficients], float).T)
    storage.write("fisheye_model", int(model == "fisheye"))
    storage.write("avg_reprojection_error", 0.2468)
    storage.release()


def morion(path, folder):
    """What Morion reads, and its rays."""
    # (Of all members, as the gate compiles them: with other features of a common dependency the library would be compiled again.)
    command = ["cargo", "test", "--quiet", "--locked", "--workspace", "--bench", "trace", "--"]
    command += ["--calibration", str(path), "--dump", str(folder)]
    run = subprocess.run(command, cwd=ROOT, env=os.environ, capture_output=True, text=True)
    if run.returncode:
        raise RuntimeError(run.stdout + run.stderr)
    rays = np.fromfile(folder / "rays.f64").reshape(-1, 2)
    return np.fromfile(folder / "calibration.f64"), rays


def undistorted(model, matrix, coefficients, pixels):
    points, matrix = pixels.reshape(-1, 1, 2), np.array(matrix, float)
    if model == "fisheye":
        found = cv2.fisheye.undistortPoints(points, matrix, np.array(coefficients, float), criteria=ENOUGH)
    else:
        found = cv2.undistortPoints(points, matrix, np.array(coefficients, float), criteria=ENOUGH)
    return found.reshape(-1, 2)


def projected(model, matrix, coefficients, rays):
    zero, matrix = np.zeros(3), np.array(matrix, float)
    if model == "fisheye":
        points = np.column_stack([rays, np.ones(len(rays))]).reshape(-1, 1, 3)
        found, _ = cv2.fisheye.projectPoints(points, zero, zero, matrix, np.array(coefficients, float))
    else:
        points = np.column_stack([rays, np.ones(len(rays))])
        found, _ = cv2.projectPoints(points, zero, zero, matrix, np.array(coefficients, float))
    return found.reshape(-1, 2)


def largest(a, b):
    return np.abs(a - b).max()


def complaints(name):
    folder = pathlib.Path(sys.argv[1])
    model, matrix, coefficients = LENSES[name]
    pixels = np.random.default_rng(len(name)).uniform([-0.5, -0.5], np.subtract(FRAME, 0.5), (COUNT, 2))
    pixels.tofile(folder / "pixels.f64")
    (fx, _, cx), (_, fy, cy), _ = matrix
    wanted = np.zeros(6 + (4 if model == "fisheye" else 12 if any(coefficients) else 0))
    wanted[:6] = [*FRAME, fx, fy, cx + 0.5, cy + 0.5]
    given = coefficients[: len(wanted) - 6]
    wanted[6 : 6 + len(given)] = given
    wrong = []
    for ending in ("yaml", "json", "xml"):
        path = folder / f"{name}.{ending}"
        write(path, model, matrix, coefficients)
        read, rays = morion(path, folder)
        if not np.array_equal(read, wanted):
            wrong.append(f"{ending}: read {read}, not {wanted}")
    off = largest(rays, undistorted(model, matrix, coefficients, pixels))
    back = largest(projected(model, matrix, coefficients, rays), pixels)
    if not off <= NEAR:
        wrong.append(f"a ray differs by {off}")
    if not back <= NEAR:
        wrong.append(f"a ray comes back {back} px off")
    return f"{COUNT} rays within {off:.1e}, back within {back:.1e} px", wrong


def main():
    pathlib.Path(sys.argv[1]).mkdir(parents=True, exist_ok=True)
    for name in ("five", "fisheye"):
        model, matrix, coefficients = LENSES[name]
        corner = np.array([[0.0, 0.0]])
        changed = [coefficients[0] + 1e-7, *coefficients[1:]]
        off = largest(undistorted(model, matrix, coefficients, corner), undistorted(model, matrix, changed, corner))
        if not off > NEAR:
            print(f"opencv: {name}: the check cannot fail: k1 + 1e-7 turns a ray by {off} alone: FAILED")
            return 1
    return told("opencv", LENSES, complaints)


if __name__ == "__main__":
    sys.exit(main())
