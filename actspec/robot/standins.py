"""Stand-ins for asset files: the least bytes that MuJoCo takes for a mesh, an image, a skin.

Source: MuJoCo 3.7, 3.11 and 4.0, measured: file formats by extension (OBJ, STL, MSH, PNG, SKN).
"""

from __future__ import annotations

import os
import struct
import zlib
from functools import lru_cache

_CORNERS = ((0.0, 0.0, 0.0), (10.0, 0.0, 0.0), (0.0, 10.0, 0.0), (0.0, 0.0, 10.0))
"""A tetrahedron [m]; large, so that a small `scale` does not take its mass below MuJoCo's least."""
_FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))


def stand_in(kind: str, name: str, *, content_type: str = "", grid: tuple[int, int] = (1, 1)) -> bytes:
    """Bytes that MuJoCo takes for an asset file.

    Args:
        kind: `mesh`, `texture`, `hfield` or `skin`.
        name: File name; its extension decides on the format.
        content_type: MIME type of the element, which goes before the extension.
        grid: Rows and columns of a texture's grid.
    """
    if kind == "texture":
        return _png(grid[1], grid[0])
    if kind == "skin":
        return _skin()
    form = content_type.rpartition("/")[2] or os.path.splitext(name)[1].lstrip(".")
    if kind == "hfield":
        return _png(2, 2) if form.lower() == "png" else struct.pack("<2i4f", 2, 2, 0, 0, 0, 1)
    return _mesh(form.lower())


@lru_cache(maxsize=8)
def _mesh(form: str) -> bytes:
    if form == "stl":
        facets = (
            struct.pack("<12fH", 0, 0, 0, *(c for corner in face for c in _CORNERS[corner]), 0)
            for face in _FACES
        )
        return bytes(80) + struct.pack("<I", len(_FACES)) + b"".join(facets)
    if form in ("msh", "vnd.mujoco.msh"):
        numbers = struct.pack("<4i", len(_CORNERS), 0, 0, len(_FACES))
        corners = b"".join(struct.pack("<3f", *corner) for corner in _CORNERS)
        return numbers + corners + b"".join(struct.pack("<3i", *face) for face in _FACES)
    lines = [f"v {x} {y} {z}" for x, y, z in _CORNERS]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in _FACES]
    return ("\n".join(lines) + "\n").encode("ascii")


@lru_cache(maxsize=8)
def _png(width: int, height: int) -> bytes:
    # Shades differ: MuJoCo refuses a height field without height.
    rows = b"".join(
        b"\0" + bytes(255 * (row == 0) for _ in range(3 * width)) for row in range(max(height, 1))
    )

    def chunk(tag: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + tag + data + struct.pack(">I", zlib.crc32(tag + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    parts = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + parts


def _skin() -> bytes:
    """Three vertices on one bone, the world."""
    bone = b"world".ljust(40, b"\0") + struct.pack("<3f4f", 0, 0, 0, 1, 0, 0, 0)
    return (
        struct.pack("<4i", 3, 0, 1, 1)
        + struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
        + struct.pack("<3i", 0, 1, 2)
        + bone
        + struct.pack("<i3i3f", 3, 0, 1, 2, 1, 1, 1)
    )
