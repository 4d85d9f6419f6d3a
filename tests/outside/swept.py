"""What a ball that is moved along straight lines leaves of a block: the lowest of all balls over each place."""

import numpy as np

TILE = 2.0  # mm: places this near are searched for together


def lowest(moves, ball, places):
    """Z of what a ball of radius `ball` leaves over places of the plan when its tip goes along `moves` (both ends of each),
    and the centre of the ball that cuts there; infinitely high where none does."""
    a, b = moves[:, 0] + [0, 0, ball], moves[:, 1] + [0, 0, ball]
    along = b - a
    length = np.hypot(along[:, 0], along[:, 1])
    # (A move straight up or down is its lower end.)
    low = np.where((b[:, 2] < a[:, 2])[:, None], b, a)
    a = np.where((length == 0)[:, None], low, a)
    unit = along[:, :2] / np.maximum(length, 1e-300)[:, None]
    slope = np.where(length > 0, along[:, 2] / np.maximum(length, 1e-300), 0.0)
    lean = slope / np.sqrt(1 + slope * slope)
    middle = 0.5 * (moves[:, 0, :2] + moves[:, 1, :2])
    heights, centres = np.full(len(places), np.inf), np.full((len(places), 3), np.nan)
    tiles, which = np.unique(np.floor(places / TILE).astype(int), axis=0, return_inverse=True)
    order = np.argsort(which.ravel(), kind="stable")
    for tile, here in zip(tiles, np.split(order, np.cumsum(np.bincount(which.ravel()))[:-1])):
        off = np.hypot(*((tile + 0.5) * TILE - middle).T)
        near = np.flatnonzero(off < ball + TILE + 0.5 * length)
        if not len(near):
            continue
        at = places[here][:, None] - a[near, :2]
        s = np.einsum("ijk,jk->ij", at, unit[near])
        q = np.einsum("ijk,ijk->ij", at, at) - s * s
        # Where along the move its ball is lowest: ball heights over a place are a convex function of it.
        u = np.sqrt(np.maximum(ball * ball - q, 0)) * lean[near]
        t = np.clip(s - u, 0, length[near])
        under = ball * ball - q - (s - t) ** 2
        z = a[near, 2] + slope[near] * t - np.sqrt(np.maximum(under, 0))
        z = np.where(under > 0, z, np.inf)
        best = z.argmin(axis=1)
        k = np.arange(len(here))
        heights[here] = z[k, best]
        cutter, t = near[best], t[k, best]
        centres[here] = np.column_stack([a[cutter, :2] + t[:, None] * unit[cutter], a[cutter, 2] + slope[cutter] * t])
    return heights, centres
