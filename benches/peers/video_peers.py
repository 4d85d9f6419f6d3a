"""OpenCV's remap on the frames of a Y4M stream, 4:2:0: video_peers.py FRAMES MAP.npy FIRST.raw

Prints the seconds of all frames, which are in memory before, and writes the first of them.
"""

import json
import sys
import time

import cv2
import numpy as np

FRAMES, MAP, FIRST = sys.argv[1:]


def main():
    data = open(FRAMES, "rb").read()
    header, data = data.split(b"\n", 1)
    width, height = (int(word[1:]) for word in header.decode().split()[1:3])
    luma, chroma = width * height, width * height // 4
    frames = []
    step = len(b"FRAME\n") + luma + 2 * chroma
    for k in range(len(data) // step):
        frame = np.frombuffer(data, np.uint8, luma + 2 * chroma, k * step + len(b"FRAME\n"))
        half = (height // 2, width // 2)
        frames.append(
            [
                frame[:luma].reshape(height, width),
                frame[luma : luma + chroma].reshape(half),
                frame[luma + chroma :].reshape(half),
            ]
        )
    places = np.load(MAP)
    # A sample of colour lies in the middle of four pixels, in the view as in the photo.
    four = places.reshape(places.shape[0] // 2, 2, places.shape[1] // 2, 2, 2).mean((1, 3))
    maps = [cv2.convertMaps(places, None, cv2.CV_16SC2), cv2.convertMaps((four - 0.5) / 2, None, cv2.CV_16SC2)]

    def painted(frame):
        return [
            cv2.remap(plane, *maps[min(k, 1)], cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
            for k, plane in enumerate(frame)
        ]

    first = painted(frames[0])
    begun = time.perf_counter()
    for frame in frames:
        painted(frame)
    seconds = time.perf_counter() - begun
    with open(FIRST, "wb") as out:
        out.write(b"".join(plane.tobytes() for plane in first))
    print(json.dumps({"seconds": seconds, "frames": len(frames), "threads": cv2.getNumThreads()}))


main()
