"""The surfaces that are meshed, and how far a mesh is off them."""

import math

import numpy as np
from numpy.polynomial import legendre

# The given surfaces by their formulas, the shipped ones by their series.
FORMULAS = {
    "bowl": lambda x, y: (x * x + y * y) / 1000,
    "saddle": lambda x, y: (x * x - y * y) / 1000,
    "bowl-16-to-1": lambda x, y: x * x / 250 + y * y / 4000,
    "mixed": lambda x, y: (
        x * x / 600
        - y * y / 1500
        + 3e-6 * x**3
        + 2e-6 * x * y * y
        + 0.02 * np.sin(x / 8) * np.cos(y / 11)
    ),
}
SAMPLES = 12
BLOCK = 20_000


class Surface:
    """Heights and Hessians of one of Morion's sheets."""

    def __init__(self, given):
        self.name = given["name"]
        self.low, self.high = (np.array(corner) for corner in given["rect"])
        self.centre, self.half = np.array(given["centre"]), np.array(given["half"])
        self.scale, self.z = given["scale_mm"], given["z_mm"]
        self.coefficients = np.array(given["coefficients"])
        self.limit, self.least = given["limit_mm"], given["least"]

    def height(self, x, y):
        if self.name in FORMULAS:
            return FORMULAS[self.name](x, y)
        u, v = (x - self.centre[0]) / self.half[0], (y - self.centre[1]) / self.half[1]
        return self.scale * legendre.legval2d(u, v, self.coefficients) + self.z

    def hessian(self, x, y):
        """f_xx, f_xy, f_yy on the grid of the given x and y."""
        u, v = (x - self.centre[0]) / self.half[0], (y - self.centre[1]) / self.half[1]

        def derivative(i, j):
            c = legendre.legder(legendre.legder(self.coefficients, i, axis=0), j, axis=1)
            scale = self.scale / (self.half[0] ** i * self.half[1] ** j)
            return scale * legendre.leggrid2d(u, v, c)

        return derivative(2, 0), derivative(1, 1), derivative(0, 2)

    def axes(self, counts):
        return [np.linspace(self.low[k], self.high[k], counts[k]) for k in (0, 1)]

    def bezier(self):
        """Control points of the surface as one Bezier patch."""

        def nodes(count):
            return 0.5 - 0.5 * np.cos(np.pi * (np.arange(count) + 0.5) / count)

        def bernstein(t, degree):
            k = np.arange(degree + 1)
            choose = np.array([math.comb(degree, i) for i in k])
            return choose * t[:, None] ** k * (1 - t[:, None]) ** (degree - k)

        counts = self.coefficients.shape
        t = [nodes(count) for count in counts]
        x, y = (self.low[k] + t[k] * (self.high[k] - self.low[k]) for k in (0, 1))
        heights = self.height(*np.meshgrid(x, y, indexing="ij"))
        a, b = (bernstein(t[k], counts[k] - 1) for k in (0, 1))
        poles = np.linalg.solve(b, np.linalg.solve(a, heights).T).T
        return *self.axes(counts), poles


def chord_error(surface, vertices, triangles):
    """Largest height between a triangle and the surface, sampled on every triangle."""
    i, j = np.meshgrid(np.arange(SAMPLES + 1), np.arange(SAMPLES + 1))
    i, j = i[i + j <= SAMPLES], j[i + j <= SAMPLES]
    weights = np.stack([i, j, SAMPLES - i - j], -1) / SAMPLES
    worst = 0.0
    for start in range(0, len(triangles), BLOCK):
        corners = vertices[triangles[start : start + BLOCK]]
        points = np.einsum("sk,tkc->tsc", weights, corners)
        height = surface.height(points[..., 0], points[..., 1])
        worst = max(worst, float(np.abs(points[..., 2] - height).max()))
    return worst
