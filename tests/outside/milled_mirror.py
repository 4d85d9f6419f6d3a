"""A milled mirror as its camera sees it: rays of the pixels, the design behind them, and the picture's errors."""

import numpy as np
from check_pictures import Ring, Strip, Target, errors
from check_rays import camera_rays, mirrored, seen_by_embree, turned


class View:
    """An equidistant view about the reflection of the camera's axis in the part's normal, in pixels (T98)."""

    pixel = 1.0

    def __init__(self, profile, layout):
        (_, camera), *_ = profile["camera"].items()
        self.rate = np.radians(profile["projection"]["fisheye"]["hfov_deg"]) / camera["pixels"][0]
        x, y, z = layout["looks_along"]
        # Rows: where the axes of the view are.
        self.axes = turned(np.eye(3), [-x, -y, z])

    def aimed(self, q):
        return np.full(len(q), True)

    def wanted(self, q):
        r = np.hypot(q[:, 0], q[:, 1])
        flat = np.sin(self.rate * r) / r
        return np.column_stack([q * flat[:, None], np.cos(self.rate * r)]) @ self.axes

    def content(self, _, seen):
        x, y, z = (seen @ self.axes.T).T
        flat = np.hypot(x, y)
        return np.column_stack([x, y]) * (np.arctan2(flat, z) / self.rate / flat)[:, None]


class Sphere:
    """A sphere around mirror and viewpoint (T100)."""

    def __init__(self, profile, layout):
        self.radius = profile["target"]["sphere"]["radius_mm"]
        self.centre = profile["target"]["sphere"]["centre_mm"] + np.array([0, 0, layout["mean_mm"]])
        self.viewpoint = np.array(layout["target_origin_mm"])

    def from_to(self, origin, ways, other):
        """Unit directions from `other` to where rays from `origin` meet the sphere."""
        p = origin - self.centre
        b = np.sum(p * ways, axis=-1)
        t = np.sqrt(b * b + self.radius**2 - np.sum(p * p, axis=-1)) - b
        way = origin + ways * t[:, None] - other
        return way / np.linalg.norm(way, axis=1)[:, None]

    def toward(self, at, wanted):
        return self.from_to(self.viewpoint, wanted, at)

    def seen(self, at, leaving):
        return self.from_to(at, leaving, self.viewpoint)


class Seen:
    """The pixels that are aimed at a mirror, and how a picture's errors are told."""

    def __init__(self, profile, layout, corners, normals):
        self.corners, self.normals = corners, normals
        if "fisheye" in profile["projection"]:
            self.picture, self.target = View(profile, layout), Sphere(profile, layout)
        else:
            is_strip = {"strip", "conquistador"} & profile["layout"].keys()
            self.picture = Strip(profile) if is_strip else Ring(profile, layout, corners)
            self.target = Target(profile, layout)
        (_, camera), *_ = profile["camera"].items()
        width, height = camera["pixels"]
        x, y = np.meshgrid(np.arange(width) + 0.5 - width / 2, height / 2 - np.arange(height) - 0.5)
        q = np.column_stack([x.ravel(), y.ravel()]) * self.picture.pixel
        aimed = self.picture.aimed(q)
        rays = camera_rays(profile, layout, corners)
        self.q, self.origins, self.ways = q[aimed], rays[0][aimed], rays[1][aimed]
        # Places and directions of the designed mirror.
        facet, at, _, _ = self.meet(corners)
        self.mirror = at, reflected(self.ways, upright(self, facet, at))

    def meet(self, corners):
        """Facets of a mesh, places on them and directions that leave, for each ray; and whether it is clear of the part then."""
        facet = seen_by_embree(corners, self.origins, self.ways)
        three = corners[facet]
        normal = np.cross(three[:, 1] - three[:, 0], three[:, 2] - three[:, 0])
        at = on_plane(self.origins, self.ways, three[:, 0], normal)
        leaving = mirrored(three, self.ways)
        start = at + leaving * 1e-5 * np.abs(corners).max()
        return facet, at, leaving, (facet >= 0) & (seen_by_embree(corners, start, leaving) < 0)

    def errors(self, at, leaving, which):
        return errors(self.picture, self.target, self.q[which], at[which], leaving[which])

    def content(self, at, leaving, which):
        return self.picture.content(self.q[which], self.target.seen(at[which], leaving[which]))

    def displaced(self, at, leaving, which):
        """What content is moved by against the designed mirror's, px."""
        away = self.content(at, leaving, which) - self.content(*self.mirror, which)
        return np.hypot(*away.T) / self.picture.pixel


def on_plane(origins, ways, point, normal):
    t = np.einsum("ij,ij->i", point - origins, normal) / np.einsum("ij,ij->i", ways, normal)
    return origins + ways * t[:, None]


def upright(seen, facet, at):
    """Normals of the designed mirror at places on its facets: those of the corners, in between."""
    three = seen.corners[facet]
    areas = [np.cross(three[:, k - 2] - at, three[:, k - 1] - at) for k in range(3)]
    weights = np.abs(np.einsum("kij,ij->ki", areas, sum(areas)))
    normal = np.einsum("ki,ikj->ij", weights, seen.normals[facet])
    return normal / np.linalg.norm(normal, axis=1)[:, None]


def reflected(ways, normal):
    return ways - 2 * np.einsum("ij,ij->i", ways, normal)[:, None] * normal
