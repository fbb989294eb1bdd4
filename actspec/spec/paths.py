"""Places in a YAML document."""

from __future__ import annotations

Path = tuple[str | int, ...]
"""Keys and indices from the top."""


def dotted(path: Path) -> str:
    """`('actuators', 'legs', 'joints', 0)` as `actuators.legs.joints[0]`."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            text += f".{part}" if text else part
    return text
