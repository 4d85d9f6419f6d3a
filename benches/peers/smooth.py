"""Job "smooth": Monte Carlo of decentre and tilt, traced off the smooth mirror.

`morion tolerance --part` makes the trials and writes what was drawn and the RMS displacement of each;
batoid and Optiland make the same parts and trace the same pixels. So every trial is compared, not
only their statistics. Two mirrors: the paraboloid of the shipped profile, which the peers meet in
closed form, and one with astigmatism, coma and spherical aberration on it, of which no program knows
more than its polynomial. Whole processes.
"""

import csv
import json
import math
import tomllib

import numpy as np

from common import Row, installed

TRIALS = 5_000
# The largest difference of a trial's displacement, as an angle in the world.
NEAR_RAD = 1e-9
# Noll's terms 6, 7 and 11 of the freeform mirror, mm.
FREEFORM = {6: 0.3, 7: 0.1, 11: 0.05}
DRAWN = {"decentre_x_um": 50, "decentre_y_um": 50, "tilt_x_mrad": 0.5, "tilt_y_mrad": 0.5}
NOT_DRAWN = [
    *("despace_um", "clocking_mrad", "scale_ppm", "temperature_k", "magnification_ppm"),
    *("telecentricity_mrad", "principal_x_px", "principal_y_px", "distortion_ppm"),
    *("waviness_um", "slope_mrad", "stepover_mm", "facets_px"),
    *(f"zernike_{j}_um" for j in range(4, 12)),
]
# Of the mirror's size: pixels that see a place so near the rim stand for nothing.
MARGIN = 0.02
# Of the radius: as far from a disc's rim rays are aimed.
EDGE = 1.01e-4


def polynomial(zernike, radius):
    """Coefficients of x^i y^j of Noll's terms 6, 7 and 11 over a disc."""
    c = np.zeros((5, 5))
    a, b, d = (zernike.get(j, 0.0) for j in (6, 7, 11))
    c[2, 0] += math.sqrt(6) * a / radius**2
    c[0, 2] -= math.sqrt(6) * a / radius**2
    c[0, 1] -= math.sqrt(8) * 2 * b / radius
    for i, j, k in [(2, 1, 1), (0, 3, 1)]:
        c[i, j] += math.sqrt(8) * 3 * k * b / radius**3
    c[0, 0] += math.sqrt(5) * d
    for i, j in [(2, 0), (0, 2)]:
        c[i, j] -= math.sqrt(5) * 6 * d / radius**2
    for i, j, k in [(4, 0, 1), (2, 2, 2), (0, 4, 1)]:
        c[i, j] += math.sqrt(5) * 6 * k * d / radius**4
    return c


def system(profile, zernike):
    """What the peers are told: lengths in mm, the part's frame."""
    radius = 0.5 * profile["part"]["width_mm"]
    # tan(psi / 2) = r / h at the rim.
    focal = radius / math.tan(
        0.5 * math.radians(profile["projection"]["parabolic"]["outer_polar_deg"])
    )
    departure = polynomial(zernike, radius)
    # The lowest place of both mirrors lies on the rim, at the base's height.
    angle = np.linspace(0, 2 * math.pi, 1_000_000, endpoint=False)
    rim = np.polynomial.polynomial.polyval2d(
        radius * np.cos(angle), radius * np.sin(angle), departure
    )
    vertex = profile["part"]["base_mm"] + radius**2 / (2 * focal) - rim.min()
    noll = [zernike.get(j, 0.0) for j in range(max(zernike, default=0) + 1)]
    width, height = profile["camera"]["orthographic"]["pixels"]
    return {
        "focal_mm": focal,
        "radius_mm": radius,
        "vertex_mm": vertex,
        "top_mm": vertex + radius,
        "pixels": [width, height],
        "pixel_mm": 2 * radius / width,
        "zernike_mm": noll,
        "departure": departure.tolist(),
    }


def pixels(system, count=1050):
    """Image points that stand for the picture, mm: Morion's own choice, made again."""
    radius, margin = system["radius_mm"], MARGIN * 2 * system["radius_mm"]
    width, height = system["pixels"]

    def places(spacing):
        def line(length):
            steps = max(1, math.floor(length / spacing + 0.5))
            return np.floor((np.arange(steps) + 0.5) / steps * length) + 0.5

        x, y = np.meshgrid(line(width), line(height))
        q = np.column_stack([x.ravel() - width / 2, height / 2 - y.ravel()]) * system["pixel_mm"]
        around = margin * np.array([[1, 0], [-1, 0], [0, 1], [0, -1], [0, 0]])
        far = np.linalg.norm(q[:, None] + around, axis=2).max(axis=1)
        return q[far <= radius * (1 - EDGE)]

    tried = max(1.0, math.sqrt(width * height / count))
    share = len(places(tried)) * tried * tried
    return places(max(1.0, math.sqrt(share / count)))


def profile_with(text, mirror):
    """The shipped profile with these errors alone, and another mirror if one is given."""
    limits = DRAWN | dict.fromkeys(NOT_DRAWN, 0)
    lines = ["[tolerance]", "compensators = []", "[tolerance.limits]"]
    lines += [f"{key} = {limit}" for key, limit in limits.items()]
    if mirror is not None:
        terms = [
            [int(i), int(j), float(mirror[i, j])] for i, j in zip(*np.nonzero(mirror), strict=True)
        ]
        lines = ["[mirror.polynomial]", f"terms = {json.dumps(terms)}", *lines]
        head, rest = text.split("[method.vector-field]")
        text = head + rest[rest.index("[part]") :]
    return text + "\n" + "\n".join(lines) + "\n"


def job(bench):
    shipped = (bench.root / "profiles" / "parabolic.toml").read_text()
    rows = []
    for name, zernike in {"paraboloid": {}, "freeform": FREEFORM}.items():
        rows += traced(bench, name, shipped, zernike)
    return rows, None


def traced(bench, name, shipped, zernike):
    folder = bench.target / "peers" / "smooth"
    folder.mkdir(parents=True, exist_ok=True)
    told = system(tomllib.loads(shipped), zernike)
    mirror = None
    if zernike:
        mirror = np.array(told["departure"])
        mirror[2, 0] -= 0.5 / told["focal_mm"]
        mirror[0, 2] -= 0.5 / told["focal_mm"]
    profile, described = folder / f"{name}.toml", folder / f"{name}.json"
    profile.write_text(profile_with(shipped, mirror))
    described.write_text(json.dumps(told))
    trials = folder / name / f"trials-0-{TRIALS}.csv"
    command = [
        bench.morion,
        "tolerance",
        profile,
        "--trials",
        f"0..{TRIALS}",
        "--part",
        "--out",
        folder,
        "--quiet",
    ]

    def theirs(peer):
        arguments = described, trials, peer, folder / f"{name}-{peer}.npz"
        return bench.said(bench.peer("smooth_peers.py", *arguments))

    peers = installed("smooth", {"batoid": "batoid", "optiland": "optiland"})
    programs = {"morion": lambda: bench.process(command)}
    made = bench.turns(programs | {peer: lambda peer=peer: theirs(peer) for peer in peers})

    with open(trials) as file:
        lines = csv.DictReader(line for line in file if not line.startswith("#"))
        ours = np.array([float(line["rms_px"]) for line in lines])
    rows = []
    seconds = {program: [seconds for seconds, _ in runs] for program, runs in made.items()}
    # d psi is 2 / h of d r on the axis, and less elsewhere.
    radians_per_px = 2 * told["pixel_mm"] / told["focal_mm"]
    for peer in list(made)[1:]:
        found = np.load(folder / f"{name}-{peer}.npz")
        count = len(found["directions"])
        off = np.abs(found["rms"] - ours).max() * radians_per_px
        pair = np.mean(ours), np.mean(found["rms"])
        spread = np.std(ours), np.std(found["rms"])
        both = (
            f"{name}: {TRIALS} trials of decentre and tilt at {count} pixels: RMS displacement "
            f"{pair[1]:.6f} +- {spread[1]:.6f} px, Morion {pair[0]:.6f} +- {spread[0]:.6f}; "
            f"differing by no more than {off:.0e} rad in any"
        )
        if not zernike:
            r = np.hypot(*pixels(told).T)
            psi = np.arctan2(np.hypot(*found["directions"][:, :2].T), found["directions"][:, 2])
            off_law = np.abs(psi - 2 * np.arctan(r / told["focal_mm"])).max()
            both += f"; as designed within {off_law:.0e} rad of the law"
        rows.append(Row("smooth", peer, seconds[peer], seconds["morion"], both, off <= NEAR_RAD))
    return rows
