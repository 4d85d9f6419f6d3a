"""HTML of mirrors and reports in notebooks."""

from __future__ import annotations

import struct
import zlib
from base64 import b64encode
from html import escape
from typing import Optional

import numpy as np
from numpy.typing import NDArray

_COLOURS = {"pass": "#1a7f37", "fail": "#cf222e"}


def png(grey: NDArray[np.uint8]) -> bytes:
    """A picture of shape (rows, columns) as PNG."""

    def chunk(kind: bytes, content: bytes) -> bytes:
        check = zlib.crc32(kind + content)
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", check)

    rows, columns = grey.shape
    head = struct.pack(">IIBBBBB", columns, rows, 8, 0, 0, 0, 0)
    lines = np.zeros((rows, columns + 1), np.uint8)
    lines[:, 1:] = grey
    content = zlib.compress(lines.tobytes(), 9)
    return (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", content) + chunk(b"IEND", b"")
    )


def picture(content: bytes, width: int) -> str:
    """An element of a PNG."""
    code = b64encode(content).decode()
    return f'<img src="data:image/png;base64,{code}" style="max-width:{width}px" alt="">'


def report(text: str, verdict: Optional[str], image: Optional[bytes]) -> str:
    """A command's summary, with its verdict and the picture that it made."""
    parts = ['<div class="morion">']
    if verdict is not None:
        colour = _COLOURS.get(verdict, "inherit")
        parts.append(f'<p><strong style="color:{colour}">{escape(verdict)}</strong></p>')
    if image is not None:
        parts.append(picture(image, 480))
    parts.append(f"<pre>{escape(text)}</pre></div>")
    return "".join(parts)


def table(title: str, rows: list[tuple[str, str]], image: Optional[bytes]) -> str:
    """Facts with a title and a picture."""
    lines = "".join(f"<tr><th>{escape(k)}</th><td>{escape(v)}</td></tr>" for k, v in rows)
    shown = "" if image is None else picture(image, 320)
    return (
        f'<div class="morion"><p><strong>{escape(title)}</strong></p>{shown}'
        f"<table><tbody>{lines}</tbody></table></div>"
    )
