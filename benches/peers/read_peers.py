#!/usr/bin/env python3
"""Reads and checks FILE with trimesh: usage: read_peers.py FILE"""

import json
import sys

import trimesh

mesh = trimesh.load_mesh(sys.argv[1])
result = {
    "triangles": len(mesh.faces),
    "watertight": bool(mesh.is_watertight),
    "volume": bool(mesh.is_volume),
    "euler": int(mesh.euler_number),
    "components": int(mesh.body_count),
    "volume_mm3": float(mesh.volume),
}
print(json.dumps(result))
