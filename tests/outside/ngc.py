"""Programs of mills and lathes: the ends of their moves, by LinuxCNC's interpreter and by their words alone."""

import re
import subprocess

NUMBER = r"(-?\d+\.\d+)"
CANON = re.compile(rf"STRAIGHT_(FEED|TRAVERSE)\({', '.join([NUMBER] * 6)}\)")
WORD = re.compile(r"([GXYZC])(-?\d*\.?\d+|-?\d+\.)")


def interpreted(path):
    """Ends of the moves by LinuxCNC's interpreter: whether each is a feed move, and its X, Y, Z in mm and C in degrees; and what it said
    last."""
    said = subprocess.run(["rs274", "-g", str(path)], input="", capture_output=True, text=True, timeout=600)
    ends = [(found[1] == "FEED", tuple(float(found[k]) for k in (2, 3, 4, 7))) for found in CANON.finditer(said.stdout)]
    return ends, said.stdout[-300:] + said.stderr[-300:]


def written(path):
    """The same by the words of the program alone; None for what it has not told yet."""
    # A lathe has no Y, and with G7 X is a diameter. What has no C stays at 0.
    said = {word for line in path.read_text().splitlines() for word in line.split()}
    by_x = 0.5 if "G7" in said else 1.0
    place, mode, ends = [None, 0.0 if said & {"G7", "G8"} else None, None, 0.0], None, []
    for line in path.read_text().splitlines():
        if line.startswith("("):
            continue
        words = [] if "G4" in line.split() else WORD.findall(line)
        for letter, value in words:
            if letter == "G" and float(value) in (0, 1):
                mode = int(value)
            elif letter in "XYZC":
                place["XYZC".index(letter)] = float(value) * (by_x if letter == "X" else 1.0)
        if any(letter in "XYZC" for letter, _ in words):
            ends.append((mode == 1, tuple(place)))
    return ends


def moves(path):
    """Both ends of each move between told places, X, Y and Z in mm, and whether it is a feed move."""
    ends = written(path)
    pairs = [(a[1][:3], b[1][:3], b[0]) for a, b in zip(ends, ends[1:]) if None not in a[1]]
    return [(a, b) for a, b, _ in pairs], [feed for *_, feed in pairs]
