"""The mirror in an OBJ that Morion wrote, without the rest of the part."""

import numpy as np


def mirror_of(path):
    """Corners of an OBJ's facets that have normals, which are the mirror's, and the normals there."""
    lines = [line.split() for line in path.read_text().splitlines()]
    places, normals = (np.array([line[1:] for line in lines if line[:1] == [key]], float) for key in ("v", "vn"))
    facets = [corner.split("//") for line in lines if line[:1] == ["f"] and "//" in line[1] for corner in line[1:]]
    place, normal = np.array(facets, int).reshape(-1, 3, 2).T - 1
    return places[place.T], normals[normal.T]
