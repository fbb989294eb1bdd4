"""Paths inside the written file: meshes and textures stay where they are."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator

from actspec.robot.xml import Element, XmlDocument

_KEPT = re.compile(r"[A-Za-z][A-Za-z0-9+.-]*:|[/\\$]")
"""A URL (`package://`, `file:`), a drive, an absolute path or a substitution."""

_FOLDERS = ("meshdir", "texturedir", "assetdir")


def relative_paths(document: XmlDocument) -> Iterator[tuple[Element, str, str]]:
    """Every path that counts from the file's own folder: (element, attribute, path).

    MuJoCo's own `<compiler>` inside a URDF names folders. Where it says `strippath="false"` it joins them with
    the file names, which then count from there.
    """
    joined = False
    own = (child for section in document.sections("mujoco") for child in section.children)
    for compiler in (element for element in own if element.tag == "compiler"):
        folders = [name for name in _FOLDERS if compiler.get(name)]
        joined = joined or (bool(folders) and compiler.get("strippath") == "false")
        yield from _relative(compiler, *folders)
    if not joined:
        for element in document.walk("mesh", "texture"):
            yield from _relative(element, "filename")


def _relative(element: Element, *names: str) -> Iterator[tuple[Element, str, str]]:
    for name in names:
        path = element.get(name)
        if path and not _KEPT.match(path):
            yield element, name, path


def from_folder(path: str, source: str, folder: str) -> str:
    """A path from the source's folder as one from another folder, with forward slashes on every system."""
    found = os.path.relpath(os.path.join(os.path.abspath(source), path), os.path.abspath(folder))
    return found.replace(os.sep, "/")
