#!/usr/bin/env python3
"""Follows camera rays through STL and STEP files, with the camera where report.json says, and holds
the picture against the profile's projection.

usage: check_pictures.py MORION COUNT [SEED]

Makes COUNT random profiles (telecentric and pinhole cameras; strips, conquistadors, discs, annuli;
sections and refits; worlds far away, cylinders and planes), has the program MORION build each, and
asks Embree what each pixel sees in the STL, and OpenCASCADE what places of the picture see in the
STEP file. Camera and target are where `layout` in report.json puts them; laws, layouts and errors are
written again here, from docs/theory.md (T2, T17, T19 to T22, T36). Counts of rays, ray and pixel errors
of the STL, filled share and the errors of the design must agree with the report within SHARE.
Prints one line per profile; exits 1 if any disagrees.

Before that it is proven that the check can fail: with a pupil or a target 0.1 mm off, it must.
"""

import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile
import tomllib

import numpy as np
from check_rays import camera_rays, corners_of, mirrored, seen_by_embree
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.gp import gp_Dir, gp_Lin, gp_Pnt, gp_Vec
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.IntCurvesFace import IntCurvesFace_ShapeIntersector
from OCP.STEPControl import STEPControl_Reader
from verdicts import told

SHARE = 1e-4  # of each figure
LEAST = 1e-5  # px or mrad, below which errors are rounding
SPLINE = 1e-2  # mrad, by which the slopes of a STEP file's splines may turn a ray
NEAR = 0.2  # mm, between a facet and the spline
NODES = 24  # of the picture of a STEP file, along each side
REFUSED = 0.5  # share of the profiles that may be refused


# -- Profiles ------------------------------------------------------------------------------------


def profile_text(r):
    """A random profile."""
    pinhole = r.random() < 0.6
    pixels = r.choice([(160, 120), (200, 112), (128, 128), (90, 150)])
    width = round(r.uniform(20, 120), 3)
    lines = []
    if pinhole:
        distance = round(width * r.uniform(1.2, 4), 3)
        # The mirror fills the frame's width, more or less.
        focal = round(pixels[0] * distance / width * r.uniform(0.8, 1.0), 3)
        lines += [f"camera.pinhole = {{ pixels = {list(pixels)}, focal_px = {focal}, distance_mm = {distance} }}"]
    else:
        lines += [f"camera.orthographic.pixels = {list(pixels)}"]
    layout = r.choice(["strip", "conquistador", "conquistador", "disc", "annulus"])
    radius = round(width * r.uniform(3, 20), 2)
    if layout in ("strip", "conquistador"):
        law = r.choice(["cylindrical", "mercator", "equirectangular", "equal-area"])
        target = r.choice(["", "", f"target_radius_mm = {radius}, "])
        turn = layout == "conquistador" or r.random() < 0.5
        azimuth = [-180, 180] if turn else [round(r.uniform(-90, -20), 2), round(r.uniform(20, 90), 2)]
        elevation = [round(r.uniform(-35, -5), 2), round(r.uniform(5, 35), 2)]
        if r.random() < 0.2:
            elevation = [round(r.uniform(5, 15), 2), round(r.uniform(25, 40), 2)]
            target = f"target_plane_mm = {radius}, "
        fill = r.random() < 0.3
        lines += [f"projection.{law} = {{ {target}azimuth_deg = {azimuth}, elevation_deg = {elevation} }}"]
        keys = [f"fill_frame = {str(fill).lower()}"]
        if layout == "conquistador":
            keys += [f'panel = "{r.choice(["section", "refit"])}"', f'ridge = "{r.choice(["crest", "crest", "valley"])}"']
        lines += [f"layout.{layout} = {{ {', '.join(keys)} }}"]
        method = r.choice(["vector-field", "vector-field", "fixed-surface"])
        lines += [f"method.{method}.degree = {r.choice([8, 10, 12])}"]
    else:
        target = r.choice(["", f", target_radius_mm = {radius}"])
        laws = ["equiangular", "tangent-proportional", "area-proportional", "equi-areal", "hyperbolic" if pinhole else "parabolic"]
        outer = round(r.uniform(60, 110), 2)
        if layout == "annulus":
            law = r.choice([*laws, "cylinder"] + ["conical"] * pinhole)
            inner = round(r.uniform(20, 45), 2)
            free = law not in ("parabolic", "hyperbolic", "conical")
            keys = f"inner_polar_deg = {inner}, outer_polar_deg = {outer}" if free else f"outer_polar_deg = {outer}"
            lines += [f"projection.{law} = {{ {keys}{target} }}"]
            lines += [f"layout.annulus.inner_width_mm = {round(width * r.uniform(0.15, 0.4), 3)}"]
        else:
            law = r.choice([law for law in laws if law != "area-proportional"])
            lines += [f"projection.{law} = {{ outer_polar_deg = {outer}{target} }}", "layout.disc = {}"]
        lines += [f"method.vector-field.degree = {r.choice([16, 24])}"]
    lines += [f"part = {{ width_mm = {width}, base_mm = {round(0.1 * width, 2)} }}"]
    lines += [f"mesh.facet_px = {r.choice([0.3, 0.5, 1])}", 'export.formats = ["stl", "step"]']
    return "\n".join(lines) + "\n"


# -- Projections ---------------------------------------------------------------------------------

RISES = {  # z of an elevation, and back
    "cylindrical": (np.tan, np.arctan),
    "mercator": (lambda e: np.arcsinh(np.tan(e)), lambda z: np.arctan(np.sinh(z))),
    "equirectangular": (lambda e: e, lambda z: z),
    "equal-area": (np.sin, np.arcsin),
}


def directions(azimuth, elevation):
    flat = np.cos(elevation)
    return np.column_stack([flat * np.sin(azimuth), flat * np.cos(azimuth), np.sin(elevation)])


def scale_of(profile):
    """Side of a pixel on the reference plane, mm, and the inverse distance of the pinhole."""
    (kind, camera), *_ = profile["camera"].items()
    if kind == "orthographic":
        return profile["part"]["width_mm"] / camera["pixels"][0], 0.0
    return camera["distance_mm"] / camera["focal_px"], 1 / camera["distance_mm"]


class Strip:
    """One panel, or two that mirror each other."""

    def __init__(self, profile):
        (law, asked), *_ = profile["projection"].items()
        (kind, layout), *_ = profile["layout"].items()
        pixel, _ = scale_of(profile)
        (_, camera), *_ = profile["camera"].items()
        frame = pixel * camera["pixels"][1]
        first, last = np.radians(asked["azimuth_deg"])
        panels = 2 if kind == "conquistador" else 1
        self.width = profile["part"]["width_mm"]
        self.scale = self.width * panels / (last - first)
        self.middle = 0.5 * (first + last)
        self.rise, self.fall = RISES[law]
        low, high = self.rise(np.radians(asked["elevation_deg"]))
        height = frame / panels if layout.get("fill_frame") else (high - low) * self.scale
        ridge = layout.get("ridge")
        below = {"crest": 0.0, "valley": height, None: 0.5 * height}[ridge]
        self.rows = (-below, height - below)
        self.z = 0.5 * (low + high) - (0.5 * height - below) / self.scale
        self.folded = {"crest": -1.0, "valley": 1.0}.get(ridge, 0.0)
        self.pixel = pixel

    def flip(self, q):
        return np.where(q[:, 1] * self.folded > 0, -1.0, 1.0)

    def aimed(self, q):
        y = q[:, 1] * self.flip(q)
        return (np.abs(q[:, 0]) <= 0.5 * self.width) & (self.rows[0] <= y) & (y <= self.rows[1])

    def wanted(self, q):
        flip = self.flip(q)
        z = q[:, 1] * flip / self.scale + self.z
        found = directions(q[:, 0] / self.scale + self.middle, self.fall(z))
        found[:, 1] *= flip
        return found

    def content(self, q, seen):
        flip = self.flip(q)
        # The nearest of the azimuths that are a turn apart.
        wanted = q[:, 0] / self.scale + self.middle
        azimuth = np.arctan2(seen[:, 0], seen[:, 1] * flip)
        azimuth = wanted + np.remainder(azimuth - wanted + np.pi, 2 * np.pi) - np.pi
        z = self.rise(np.arcsin(np.clip(seen[:, 2], -1, 1)))
        return np.column_stack([(azimuth - self.middle) * self.scale, (z - self.z) * self.scale * flip])

    def nodes(self):
        """Places of the picture and their weights: Gauss and Legendre's over one panel."""
        u, w = np.polynomial.legendre.leggauss(NODES)
        x = 0.5 * self.width * u
        y = 0.5 * (self.rows[0] + self.rows[1]) + 0.5 * (self.rows[1] - self.rows[0]) * u
        grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        return grid, np.outer(w, w).ravel()


class Ring:
    """A law about the axis."""

    def __init__(self, profile, layout, corners):
        (law, asked), *_ = profile["projection"].items()
        self.pixel, k = scale_of(profile)
        ri, ro = 0.0, 0.5 * profile["part"]["width_mm"]
        if "annulus" in profile["layout"]:
            ri = 0.5 * profile["layout"]["annulus"]["inner_width_mm"]
            if k:
                points = corners.reshape(-1, 3)
                radius = np.hypot(points[:, 0], points[:, 1])
                rim = points[np.abs(radius - ri) < 1e-4, 2].max()
                ri /= (layout["pupil_mm"][2] - rim) * k
        self.radii = ri, ro
        last, first = math.radians(asked["outer_polar_deg"]), math.radians(asked.get("inner_polar_deg", 0))
        theta = (lambda r: np.arctan(k * r) / k) if k else (lambda r: r)
        radius = (lambda t: np.tan(k * t) / k) if k else (lambda t: t)

        def linear(of_psi, psi_of, of_r, r_of):
            """The law by which a function of psi is linear in one of r."""
            a = (of_psi(last) - of_psi(first)) / (of_r(ro) - of_r(ri))
            forth = lambda r: psi_of(of_psi(first) + a * (of_r(r) - of_r(ri)))
            return forth, lambda psi: r_of(of_r(ri) + (of_psi(psi) - of_psi(first)) / a)

        same = lambda x: x
        if law == "parabolic":
            a = math.tan(last / 2) / ro
            self.psi, self.r = lambda r: 2 * np.arctan(a * r), lambda psi: np.tan(psi / 2) / a
        elif law == "hyperbolic":
            a = math.tan(math.atan(k * ro) / 2) / math.tan(last / 2)
            self.psi = lambda r: 2 * np.arctan(np.tan(np.arctan(k * r) / 2) / a)
            self.r = lambda psi: np.tan(2 * np.arctan(a * np.tan(psi / 2))) / k
        elif law == "conical":
            twice = last - math.atan(k * ro)
            self.psi, self.r = lambda r: twice + np.arctan(k * r), lambda psi: np.tan(psi - twice) / k
        else:
            self.psi, self.r = {
                "equiangular": lambda: linear(same, same, theta, radius),
                "tangent-proportional": lambda: linear(same, same, same, same),
                "area-proportional": lambda: linear(same, same, np.square, np.sqrt),
                "equi-areal": lambda: linear(
                    lambda p: 1 - np.cos(p), lambda c: np.arccos(1 - c), np.square, np.sqrt
                ),
                "cylinder": lambda: linear(
                    lambda p: -1 / np.tan(p), lambda c: np.arctan2(1, -c), same, same
                ),
            }[law]()

    def aimed(self, q):
        r = np.hypot(q[:, 0], q[:, 1])
        inner, outer = self.radii
        return (r <= outer * (1 - 1.01e-4)) & ((inner == 0) | (r >= inner * (1 + 1e-6)))

    def wanted(self, q):
        r = np.hypot(q[:, 0], q[:, 1])
        return directions(np.arctan2(q[:, 0], q[:, 1]), np.pi / 2 - self.psi(r))

    def content(self, _, seen):
        flat = np.hypot(seen[:, 0], seen[:, 1])
        r = self.r(np.arctan2(flat, seen[:, 2]))
        return seen[:, :2] * (r / flat)[:, None]

    def nodes(self):
        """Of one radius, which all are like."""
        u, w = np.polynomial.legendre.leggauss(NODES)
        inner, outer = self.radii
        r = 0.5 * (inner + outer) + 0.5 * (outer - inner) * u
        return np.column_stack([r * 0.6, r * 0.8]), w * r


class Target:
    """Where directions are told from."""

    def __init__(self, profile, layout):
        (_, asked), *_ = profile["projection"].items()
        self.radius, self.height = asked.get("target_radius_mm"), asked.get("target_plane_mm")
        self.origin = np.array(layout["target_origin_mm"] or [0, 0, 0])

    def far(self):
        return self.radius is None and self.height is None

    def toward(self, at, wanted):
        """The direction from a point of the mirror to what a direction from the origin shows."""
        if self.far():
            return wanted
        if self.radius:
            there = wanted * (self.radius / np.hypot(wanted[:, 0], wanted[:, 1]))[:, None]
        else:
            there = wanted * (self.height / wanted[:, 2])[:, None]
        way = there + self.origin - at
        return way / np.linalg.norm(way, axis=1)[:, None]

    def seen(self, at, leaving):
        """The direction from the origin of what a ray meets."""
        if self.far():
            return leaving
        p = at - self.origin
        if self.radius:
            a = leaving[:, 0] ** 2 + leaving[:, 1] ** 2
            b = p[:, 0] * leaving[:, 0] + p[:, 1] * leaving[:, 1]
            c = p[:, 0] ** 2 + p[:, 1] ** 2 - self.radius**2
            t = (-b + np.sqrt(b * b - a * c)) / a
        else:
            t = (self.height - p[:, 2]) / leaving[:, 2]
        way = p + leaving * t[:, None]
        return way / np.linalg.norm(way, axis=1)[:, None]


def errors(picture, target, q, at, leaving):
    """Ray error, rad, and pixel error, px (T21, T22)."""
    wanted = target.toward(at, picture.wanted(q))
    ray = 2 * np.arctan2(
        np.linalg.norm(wanted - leaving, axis=1), np.linalg.norm(wanted + leaving, axis=1)
    )
    away = picture.content(q, target.seen(at, leaving)) - q
    return ray, np.hypot(away[:, 0], away[:, 1]) / picture.pixel


# -- Files ---------------------------------------------------------------------------------------


def rms(values, weights=None):
    return math.sqrt(np.average(np.square(values), weights=weights))


def by_stl(profile, layout, corners, picture, target):
    """What all pixels see: counts, RMS errors and the share of the frame that is filled."""
    (_, camera), *_ = profile["camera"].items()
    width, height = camera["pixels"]
    origins, ways = camera_rays(profile, layout, corners)
    x, y = np.meshgrid(np.arange(width) + 0.5 - width / 2, height / 2 - np.arange(height) - 0.5)
    q = np.column_stack([x.ravel(), y.ravel()]) * picture.pixel
    aimed = picture.aimed(q)
    q, origins, ways = q[aimed], origins[aimed], ways[aimed]
    facet = seen_by_embree(corners, origins, ways)
    hit = facet >= 0
    q, origins, ways, three = q[hit], origins[hit], ways[hit], corners[facet[hit]]
    leaving = mirrored(three, ways)
    normal = np.cross(three[:, 1] - three[:, 0], three[:, 2] - three[:, 0])
    t = np.einsum("ij,ij->i", three[:, 0] - origins, normal) / np.einsum("ij,ij->i", ways, normal)
    at = origins + ways * t[:, None]
    start = at + leaving * 1e-5 * np.abs(corners).max()
    clear = seen_by_embree(corners, start, leaving) < 0
    ray, image = errors(picture, target, q[clear], at[clear], leaving[clear])
    tolerance = 0.01 * width
    return {
        "rays": int(aimed.sum()),
        "hit": int(clear.sum()),
        "ray": 1e3 * rms(ray),
        "image": rms(image),
        "filled": int((image <= tolerance).sum()) / (width * height),
    }


def by_step(path, profile, layout, corners, picture, target):
    """RMS errors of the design: rays through the STEP file's faces."""
    reader = STEPControl_Reader()
    if reader.ReadFile(str(path)) != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise ValueError("STEP not read")
    reader.TransferRoots()
    finder = IntCurvesFace_ShapeIntersector()
    finder.Load(reader.OneShape(), 1e-9)
    q, weights = picture.nodes()
    _, k = scale_of(profile)
    top = 2 * np.abs(corners).max()
    places, leaving = [], []

    def ray(x, y):
        if not k:
            return np.array([x, y, top]), np.array([0, 0, -1.0])
        way = np.array([x * k, y * k, -1.0])
        return np.array(layout["pupil_mm"]), way / np.linalg.norm(way)

    # Where the facets are, which are near. OpenCASCADE passes a face by now and then, close to an edge.
    origins, ways = (np.array(rays) for rays in zip(*(ray(x, y) for x, y in q)))
    three = corners[seen_by_embree(corners, origins, ways)]
    normal = np.cross(three[:, 1] - three[:, 0], three[:, 2] - three[:, 0])
    far = np.einsum("ij,ij->i", three[:, 0] - origins, normal)
    far /= np.einsum("ij,ij->i", ways, normal)
    for (x, y), t in zip(q, far):
        for shift in (1, 1 - 1e-6, 1 + 1e-6, 1 - 1e-5):
            origin, way = ray(x * shift, y * shift)
            finder.PerformNearest(gp_Lin(gp_Pnt(*origin), gp_Dir(*way)), 0, 1e9)
            if finder.NbPnt() and abs(finder.WParameter(1) - t) < NEAR:
                break
        surface = BRepAdaptor_Surface(finder.Face(1))
        point, du, dv = gp_Pnt(), gp_Vec(), gp_Vec()
        surface.D1(finder.UParameter(1), finder.VParameter(1), point, du, dv)
        normal = du.Crossed(dv)
        normal = np.array([normal.X(), normal.Y(), normal.Z()])
        normal /= np.linalg.norm(normal)
        places.append([point.X(), point.Y(), point.Z()])
        leaving.append(way - 2 * way.dot(normal) * normal)
    ray, image = errors(picture, target, q, np.array(places), np.array(leaving))
    return {"ray": 1e3 * rms(ray, weights), "image": rms(image, weights)}


def compared(folder, profile, report, layout):
    """Figures in short, and what is wrong."""
    corners = corners_of(folder / "mirror.stl")
    picture = (
        Strip(profile)
        if {"strip", "conquistador"} & profile["layout"].keys()
        else Ring(profile, layout, corners)
    )
    target = Target(profile, layout)
    traced = report["trace"][0]
    stl = by_stl(profile, layout, corners, picture, target)
    step = by_step(folder / "mirror.step", profile, layout, corners, picture, target)
    pixels = report["frame"]["pixels"][0] * report["frame"]["pixels"][1]
    pairs = [
        ("STL rays", stl["rays"], traced["rays"], 2.0),
        ("STL hits", stl["hit"], traced["hit"], 2.0),
        ("filled", stl["filled"], report["frame"]["filled"], 3.0 / pixels),
        ("STL ray error", stl["ray"], traced["ray_error_mrad"]["rms"], LEAST),
        ("STL pixel error", stl["image"], traced["pixel_error_px"]["rms"], LEAST),
        ("STEP ray error", step["ray"], report["design"]["ray_error_mrad"]["rms"], SPLINE),
        ("STEP pixel error", step["image"], report["design"]["pixel_error_px"]["rms"], SPLINE / 10),
    ]
    wrong = [
        f"{name} {found:.8g} for {said:.8g}"
        for name, found, said, least in pairs
        if not abs(found - said) <= SHARE * abs(said) + least
    ]
    figures = f"{stl['hit']} of {stl['rays']} rays, {stl['image']:.4f} px, design {step['image']:.4f} px"
    return figures, wrong


def built(morion, home, name, text):
    """The folder of a build, or none where it is refused."""
    path = home / f"{name}.toml"
    path.write_text(text)
    done = subprocess.run(
        [morion, "build", str(path), "--out", str(home), "--quiet"], capture_output=True, text=True
    )
    return None if done.returncode == 2 else home / name


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    morion, count = sys.argv[1], int(sys.argv[2])
    r = random.Random(int(sys.argv[3]) if len(sys.argv) > 3 else 1)
    refused, made = 0, {}
    with tempfile.TemporaryDirectory() as home:
        home = pathlib.Path(home)
        while len(made) < count:
            text = profile_text(r)
            folder = built(morion, home, f"random-{len(made) + refused}", text)
            if folder is None:
                refused += 1
                if refused > 20 + REFUSED / (1 - REFUSED) * count:
                    sys.exit(f"{refused} profiles are refused, the last is\n{text}")
                continue
            made[folder.name] = (folder, text)

        def complaints(name):
            folder, text = made[name]
            profile = tomllib.loads(text)
            report = json.loads((folder / "report.json").read_text())
            figures, wrong = compared(folder, profile, report, report["layout"])
            if name == next(iter(made)):
                for key in ("pupil_mm", "target_origin_mm"):
                    moved = report["layout"][key]
                    if moved:
                        moved = {**report["layout"], key: [*moved[:2], moved[2] + 0.1]}
                        if not compared(folder, profile, report, moved)[1]:
                            wrong.append(f"{key} may be 0.1 mm off")
            if wrong:
                figures += "\n" + text
            return figures, wrong

        code = told("pictures", made, complaints)
    print(f"pictures: {len(made)} profiles, {refused} more refused")
    sys.exit(code)


if __name__ == "__main__":
    main()
