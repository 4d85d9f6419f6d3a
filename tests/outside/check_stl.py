#!/usr/bin/env python3
"""Asks trimesh and Manifold whether STL files are solids: one closed body without handles.

usage: check_stl.py FILE.stl...
Prints one line per file; exits 1 if any of them is not.
"""

import sys

import manifold3d
import numpy as np
import trimesh


def complaints(path):
    """The file's figures in short, and what is wrong with it."""
    mesh = trimesh.load_mesh(path)
    body = manifold3d.Manifold(
        manifold3d.Mesh(
            vert_properties=np.asarray(mesh.vertices, dtype=np.float32),
            tri_verts=np.asarray(mesh.faces, dtype=np.uint32),
        )
    )
    found = {
        "watertight": (mesh.is_watertight, True),
        "volume": (mesh.is_volume, True),
        "euler number": (mesh.euler_number, 2),
        "bodies": (mesh.body_count, 1),
        "positive volume": (mesh.volume > 0, True),
        "manifold status": (body.status().name, manifold3d.Error.NoError.name),
        "genus": (body.genus(), 0),
    }
    wrong = [f"{name} {got}, not {want}" for name, (got, want) in found.items() if got != want]
    return f"{len(mesh.faces)} facets, {mesh.volume:.3f} mm3", wrong


def main():
    failed = False
    for path in sys.argv[1:]:
        try:
            figures, wrong = complaints(path)
        except Exception as error:
            figures, wrong = "unreadable", [f"{type(error).__name__}: {error}"]
        verdict = "FAILED; " + "; ".join(wrong) if wrong else "ok"
        print(f"trimesh, manifold: {path}: {figures}: {verdict}")
        failed |= bool(wrong)
    if not sys.argv[1:]:
        sys.exit(__doc__)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
