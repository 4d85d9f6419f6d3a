"""Job "video": frames of a Y4M stream through the mirror to a view, by one map.

OpenCV's `remap` with INTER_CUBIC, its threads as it likes, has the map that `morion unwrap --map` wrote, in the fixed-point form
that it is fastest with, and the frames in memory. Morion reads them from a file and writes them: its time is that of
the frames, reading and writing included, without the design and the map, which the peer does not make.
"""

import re
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from common import Failed, Row, installed

PHOTO, VIEW, FRAMES = (1440, 1080), (1920, 1080), 240


def stream(path, frames):
    """Writes smooth frames, 4:2:0, each another."""
    width, height = PHOTO
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    with path.open("wb") as out:
        out.write(f"YUV4MPEG2 W{width} H{height} F120:1 Ip C420jpeg\n".encode())
        for k in range(frames):
            wave = 128 + 60 * np.sin(0.05 * x + 0.1 * k) + 50 * np.cos(0.04 * y - 0.05 * k)
            planes = [wave, 128 + 0.4 * (wave[::2, ::2] - 128), 255 - wave[::2, ::2]]
            out.write(b"FRAME\n" + b"".join(p.round().astype(np.uint8).tobytes() for p in planes))


def job(bench):
    if not installed("video", {"OpenCV": "cv2"}):
        return [], None
    with tempfile.TemporaryDirectory(dir="/dev/shm" if Path("/dev/shm").is_dir() else None) as folder:
        folder = Path(folder)
        import cv2

        frames, photo = folder / "frames.y4m", folder / "photo.png"
        stream(frames, FRAMES)
        cv2.imwrite(str(photo), np.zeros(PHOTO[::-1], np.uint8))
        view = ["--profile", "conquistador", "--view", "0,0,60"]
        view += ["--width", str(VIEW[0]), "--height", str(VIEW[1])]
        bench.process([bench.morion, "unwrap", photo, *view, "--map", "npy", "--out", folder, "-q"])
        table = folder / "conquistador" / "photo-view-map.npy"
        ours_first, theirs_first = folder / "ours.y4m", folder / "theirs.raw"

        def ours():
            with frames.open("rb") as source, ours_first.open("wb") as out:
                command = [str(bench.morion), "unwrap", "-", *view]
                done = subprocess.run(command, stdin=source, stdout=out, stderr=subprocess.PIPE, text=True)
            found = re.search(r"(\d+) frames, ([\d.]+) a second", done.stderr)
            if done.returncode or not found or int(found[1]) != FRAMES:
                raise Failed(f"morion ended with {done.returncode}: {done.stderr[-200:]}")
            return FRAMES / float(found[2]), None

        programs = {
            "morion": ours,
            "OpenCV": lambda: theirs(bench, frames, table, theirs_first),
        }
        made = bench.turns(programs)
        if "OpenCV" not in made:
            return [], None
        luma = VIEW[0] * VIEW[1]
        size = luma * 3 // 2
        body = ours_first.read_bytes()
        body = body[body.index(b"\n") + 1 + len(b"FRAME\n") :][:size]
        a, b = (np.frombuffer(some, np.uint8).astype(int) for some in (body, theirs_first.read_bytes()))
        off = np.abs(a - b)
    rate = FRAMES / np.median([seconds for seconds, _ in made["morion"]])
    both = (
        f"{FRAMES} frames of {PHOTO[0]} x {PHOTO[1]} to {VIEW[0]} x {VIEW[1]} pixels, 4:2:0, bicubic: off by "
        f"{off[:luma].max()} code values of luma and {off[luma:].max()} of colour at most; Morion {rate:.0f} frames a second, "
        "which it also reads and writes"
    )
    times = {name: [seconds for seconds, _ in runs] for name, runs in made.items()}
    agrees = bool(off.max() <= 1)
    return [Row("video", "OpenCV remap", times["OpenCV"], times["morion"], both, agrees)], None


def theirs(bench, frames, table, first):
    """Seconds of the frames alone."""
    _, said = bench.said(bench.peer("video_peers.py", frames, table, first))
    return said["seconds"], said
