"""Models that an MJCF attaches: read and checked as its includes are, before MuJoCo opens them.

Measured with MuJoCo 3.7.0 and 4.0.0: a name is looked up in the folder of the model that attaches; an attached model
attaches others in its turn; one that attaches itself ends in a crash; of files in memory, the base name alone counts.
"""

from __future__ import annotations

import os
from collections.abc import Iterator

from actspec.diagnostics import Collector, RobotError
from actspec.robot.assets import base_name, stand_in
from actspec.robot.xml import MOST_BYTES, MOST_CHAIN, MOST_FILES, Unreadable, attached_document, on_disk
from actspec.robot.xml_tree import XmlDocument

_MARKS = (b"<flexcomp", b"<model")
"""Elements that MuJoCo opens a file for while it parses."""


def opened_by(document: XmlDocument) -> Iterator[tuple[str, XmlDocument | bytes]]:
    """What MuJoCo opens while it parses an MJCF, under the name by which it finds it.

    Attached models, theirs included, and stand-ins for the meshes of flexible bodies.

    Raises: RobotError: a model cannot be followed, in the words that an include has.
    """
    reader = _Attached()
    yield from reader.followed(document, (os.path.normpath(document.files[0].path),))
    reader.out.raise_if_failed(RobotError)


def attached_models(document: XmlDocument) -> dict[str, XmlDocument]:
    """The models that an MJCF attaches, and those that they attach, by the name by which MuJoCo finds them.

    Raises: RobotError: as `opened_by`.
    """
    return {name: found for name, found in opened_by(document) if isinstance(found, XmlDocument)}


def key_of(name: str) -> str:
    """MuJoCo finds a file by its base name in any case."""
    return base_name(name).lower()


class _Attached:
    """The work of `opened_by`: what has been read so far."""

    def __init__(self) -> None:
        self.out = Collector()
        self._paths: dict[str, str] = {}
        self._sites = 0
        self._bytes = 0

    def followed(
        self, document: XmlDocument, chain: tuple[str, ...]
    ) -> Iterator[tuple[str, XmlDocument | bytes]]:
        """What one model opens, each followed by what that opens.

        Args:
            document: The model.
            chain: Paths of the models that attach it and each other, its own last.
        """
        if not any(mark in file.data for file in document.files for mark in _MARKS):
            return
        main = document.files[0].path
        for element in document.walk("flexcomp", "model"):
            name, site = element.get("file"), document.span(element)
            if element.tag == "flexcomp":
                if name:
                    yield key_of(name), stand_in("mesh", name)
                continue
            self._sites += 1
            if self._sites > MOST_FILES or len(chain) > MOST_CHAIN:
                message = f"more than {MOST_FILES} attached models, or {MOST_CHAIN} in a chain"
                raise RobotError.of("ROBOT002", message, site)
            if not name:
                self.out.error(
                    "ROBOT006", "an attached model without a file", span=site, help='write file="..."'
                )
                continue
            try:
                file = on_disk(main, main, name)
            except Unreadable as err:
                self.out.error(
                    err.code, f"the attached model cannot be followed: {err}", span=site, help=err.help
                )
                continue
            path = os.path.normpath(file.path)
            if path in chain:
                names = " -> ".join((*chain[chain.index(path) :], path))
                self.out.error("ROBOT007", f"the attached models go in a circle: {names}", span=site)
                continue
            if self._paths.setdefault(key_of(name), path) != path:
                self.out.error(
                    "ROBOT006",
                    f"another attached model is called {base_name(name)!r} too: MuJoCo would take one for the other",
                    span=site,
                    help="rename one of the two files",
                )
                continue
            inner = attached_document(file, site)
            self._bytes += sum(len(part.data) for part in inner.files)
            if self._bytes > MOST_BYTES:
                limit = f"the attached models are larger than {MOST_BYTES >> 20} MiB together"
                raise RobotError.of("ROBOT002", limit, site)
            yield key_of(name), inner
            yield from self.followed(inner, (*chain, path))
