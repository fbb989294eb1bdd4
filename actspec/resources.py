"""Files that ship with actspec: templates, schemas and robots."""

from __future__ import annotations

from pathlib import Path, PurePosixPath
from typing import Literal

Kind = Literal["templates", "schemas", "robots"]

_PACKAGE = Path(__file__).resolve().parent


def data_path(kind: Kind, name: str = "") -> Path:
    """Find a shipped file or folder.

    Looks in the installed package first, then in the checkout that an editable install runs from.

    Args:
        kind: The folder it belongs to.
        name: Path below that folder, with `/`; empty means the folder itself.

    Raises:
        ValueError: `name` leaves the folder.
        FileNotFoundError: this installation has no such file.
    """
    parts = PurePosixPath(name)
    if parts.is_absolute() or ".." in parts.parts or "\\" in name or ":" in name:
        raise ValueError(f"{kind}: {name!r} is not a path inside the folder")
    for root in _roots():
        found = root / kind / parts
        if found.exists():
            return found
    raise FileNotFoundError(f"{kind}/{name} is not part of this actspec installation")


def _roots() -> list[Path]:
    checkout = _PACKAGE.parent
    # The parent of an installed package is site-packages, whose `templates` is somebody else's.
    return [_PACKAGE / "_data", *([checkout] if (checkout / "pyproject.toml").is_file() else [])]
