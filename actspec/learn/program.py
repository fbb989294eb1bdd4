"""Whether a TorchScript file is a program that actspec itself writes, whatever its weights: such a one may run unasked.

TorchScript can read and write files. Its text stands in the archive, so it is compared and not run: every line must be
one that our own writer gives for the network of the ONNX file beside it.
"""

from __future__ import annotations

import io
import re
import zipfile

from actspec.laws.network import Layers
from actspec.learn.files import torchscript_bytes

MOST_TEXT = 1 << 20
"""Most of a program's text [bytes]. Chosen: that of an LSTM has 12 kB."""

_NUMBERED = re.compile(r"___torch_mangle_\d+\.")
"""What torch puts before names, by how many networks a process has made."""
_TENSORS = ("data/", "constants/", "traced_inputs/")


def is_own(data: bytes, layers: Layers) -> bool:
    """Whether a TorchScript file holds the program that actspec writes for these layers.

    Raises:
        ImportError: torch is not installed, which writes them.
    """
    try:
        return _program(data) == _program(torchscript_bytes(layers))
    except (zipfile.BadZipFile, ValueError, NotImplementedError, OSError, RuntimeError):
        return False


def _program(data: bytes) -> tuple[list[str], list[str]]:
    """Lines of all of its text, and the names of what else it holds, both sorted: torch has no order of its own."""
    lines: list[str] = []
    others = []
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        for item in archive.infolist():
            name = item.filename.partition("/")[2]
            if name.startswith("code/"):
                if item.file_size > MOST_TEXT or len(lines) > MOST_TEXT:
                    raise ValueError("too much text")
                lines += _NUMBERED.sub("", archive.read(item).decode()).splitlines()
            elif not name.startswith(_TENSORS):
                others.append(name)
    return sorted(lines), sorted(others)
