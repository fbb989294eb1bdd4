"""Find a robot's model file and read it, MJCF or URDF; or take the joints that a spec lists."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

from actspec.diagnostics import (
    Diagnostic,
    ResolveError,
    RobotError,
    Severity,
    in_quotes,
    listed,
    nearest,
    shortened,
)
from actspec.files import leads_into, path_of_name
from actspec.joints import JointKind
from actspec.robot.submodules import NOT_CHECKED_OUT, not_checked_out
from actspec.robot.view import JointView, ModelFormat, RobotView

if TYPE_CHECKING:
    from importlib.metadata import Distribution

    from actspec.robot.xml_tree import XmlDocument
    from actspec.spec.validate import Spec


_SCHEME = "package://"
_DISTRIBUTION = re.compile(r"[A-Za-z0-9](?:[A-Za-z0-9._-]*[A-Za-z0-9])?")


class RobotNotInstalled(RobotError):
    """The model is in a distribution that is not installed here; `validate` may skip it."""


class JointsNotNamed(RobotError):
    """Only a compilation tells the joints of the model; `validate` skips it."""


def find_model(reference: str, base: str) -> str:
    """Turn a spec's `robot.model` into a path.

    Args:
        reference: A path, relative to `base` or absolute, or `package://DIST/path`: a file of an
            installed distribution, which is found by its metadata and never imported.
        base: Folder of the spec.

    Raises:
        RobotNotInstalled: the distribution is not installed.
        RobotError: the reference is malformed, leaves the distribution, or names no file.
    """
    if reference.startswith(_SCHEME):
        return _find_installed(reference)
    if not reference or "\0" in reference:
        raise _error("ROBOT103", f"{in_quotes(reference)} is not a path")
    path = os.path.normpath(os.path.join(base, path_of_name(reference)))
    if os.path.isfile(path):
        return path
    folder, name = os.path.split(path)
    # A spec in the working directory has no folder in its name.
    folder = folder or os.curdir
    if os.path.isdir(path):
        raise _error(
            "ROBOT101", f"the model is a folder, got {in_quotes(reference)}", _near("", names_in(path))
        )
    submodule = not_checked_out(os.path.join(base, ""), path)
    if submodule is not None:
        raise _error(
            NOT_CHECKED_OUT, f"there is no model {in_quotes(reference)}: {submodule}", submodule.help
        )
    if not os.path.isdir(folder):
        raise _error(
            "ROBOT101",
            f"there is no model {in_quotes(reference)}: its folder does not exist",
            "a path is relative to the spec's folder; a file of an installed distribution is package://DIST/path",
        )
    raise _error("ROBOT101", f"there is no model {in_quotes(reference)}", _near(name, names_in(folder)))


def robot_of(spec: Spec) -> RobotView:
    """The robot that a spec names.

    Raises:
        RobotError: the model is not there or cannot be read; what has no place of its own is where it is named.
    """
    model, folder = spec.model.robot.model, os.path.dirname(spec.document.path)
    if model == "none":
        return listed_robot(spec)
    try:
        return replace(load_robot(find_model(model, folder)), packages=_packages(spec))
    except RobotError as err:
        raise type(err)(placed(spec, err)) from err


def placed(spec: Spec, err: RobotError) -> tuple[Diagnostic, ...]:
    """What is wrong with a spec's model; what has no place of its own is where the model is named."""
    place = spec.span("robot", "model")
    return tuple(item if item.span is not None else replace(item, span=place) for item in err.diagnostics)


def check_packages(spec: Spec) -> None:
    """Check that the folders of `robot.packages` are there: a compiled model has its meshes from them.

    Raises: RobotError: one is not, at its line.
    """
    for name, at in _packages(spec).items():
        if "\0" in at or not os.path.isdir(at):
            message = (
                f"there is no folder {in_quotes(spec.model.robot.packages[name])} of the package '{name}'"
            )
            help = "write the package's own folder, relative to the spec's, the one with its package.xml; or name it "
            help += f"with --package {name}=FOLDER"
            raise RobotError.of("ROBOT101", message, spec.span("robot", "packages", name), help=help)


def _packages(spec: Spec) -> dict[str, str]:
    """ROS packages and their folders."""
    folder = os.path.dirname(spec.document.path)
    return {
        name: os.path.normpath(os.path.join(folder, path_of_name(at)))
        for name, at in spec.model.robot.packages.items()
    }


def load_robot(path: str) -> RobotView:
    """Read a robot file; the root element decides between MJCF and URDF.

    Args:
        path: File on disk.

    Raises: RobotError: the file cannot be read or understood.
    """
    from actspec.robot.xml import open_document

    document = open_document(path)
    tag = document.root.tag
    if tag == "mujoco":
        from actspec.robot.read_mjcf import read_mjcf

        return read_mjcf(document.files, document)
    if tag == "robot":
        from actspec.robot.read_urdf import read_urdf

        _check_expanded(document)
        return read_urdf(document.files, document)
    raise _no_robot(document)


_OPAQUE = ("replicate", "attach", "composite", "flexcomp")
"""Elements of an MJCF that make joints which its text does not name."""


def joints_of_text(path: str) -> RobotView:
    """The joints and actuators of a robot file as its text names them; nothing is compiled, there is no inertia.

    Args:
        path: File on disk.

    Raises:
        JointsNotNamed: only a compilation tells its joints.
        RobotError: the file cannot be read, as for `load_robot`.
    """
    from actspec.robot.xml import open_document

    document = open_document(path)
    tag, reason = document.root.tag, "read for its joints alone"
    if tag == "robot":
        from actspec.robot.read_urdf import read_urdf

        _check_expanded(document)
        return replace(read_urdf(document.files, document, refusal=reason), uncompiled=True)
    if tag != "mujoco":
        raise _no_robot(document)
    pending = [document.root]
    for element in pending:
        if element.tag in _OPAQUE:
            raise JointsNotNamed.of(
                "ROBOT104", f"its <{element.tag}> makes joints that its text does not name"
            )
        pending += element.children
    from actspec.robot.read_mjcf_text import read_mjcf_text

    return replace(read_mjcf_text(document, reason), uncompiled=True)


def _check_expanded(document: XmlDocument) -> None:
    """Refuse a xacro whose joints are not there yet: what its macros, includes and conditions make."""
    from actspec.robot.read_urdf import EXPAND, unexpanded

    for element in unexpanded(document):
        if element.tag.partition(":")[2] not in ("arg", "property"):
            message = f"<{shortened(element.tag)}> has to be expanded by xacro first: it may make joints"
            raise RobotError.of("ROBOT104", message, document.span(element), help=EXPAND)


def _no_robot(document: XmlDocument) -> RobotError:
    message = f"the root element is <{document.root.tag}>: neither an MJCF (<mujoco>) nor a URDF (<robot>)"
    return RobotError.of("ROBOT104", message, document.span(document.root))


def _find_installed(reference: str) -> str:
    from importlib import metadata

    name, _, inner = reference.removeprefix(_SCHEME).partition("/")
    parts = inner.split("/")
    if not _DISTRIBUTION.fullmatch(name) or any(
        p in ("", ".", "..") or "\\" in p or "\0" in p for p in parts
    ):
        raise _error(
            "ROBOT103",
            f"{in_quotes(reference)} does not name a file of a distribution",
            "write package://DIST/path, the path as the distribution lists it, without '..'",
        )
    try:
        distribution = metadata.distribution(name)
    except metadata.PackageNotFoundError as err:
        message = f"the model {in_quotes(reference)} is not installed: there is no distribution {in_quotes(name)} here"
        raise RobotNotInstalled(
            [Diagnostic("ROBOT102", Severity.ERROR, message, "robot.model", None, f"pip install {name}")]
        ) from err
    listing = {str(file).replace(os.sep, "/") for file in distribution.files or ()}
    if inner in listing:
        path = str(distribution.locate_file(inner))
        if os.path.isfile(path):
            return os.path.normpath(path)
        raise _error(
            "ROBOT101", f"the distribution {in_quotes(name)} lists {in_quotes(inner)}, but the file is gone"
        )
    roots = _editable_roots(distribution)
    for root in roots:
        path = os.path.realpath(os.path.join(root, *parts))
        if os.path.isfile(path):
            if leads_into(path, [os.path.realpath(root)]):
                return path
            raise _error(
                "ROBOT103", f"{in_quotes(inner)} is a link that leaves the distribution {in_quotes(name)}"
            )
    folder = "/".join(parts[:-1])
    beside = {file.rpartition("/")[2] for file in listing if file.rpartition("/")[0] == folder}
    for root in roots:
        beside.update(names_in(os.path.join(root, *parts[:-1])))
    raise _error(
        "ROBOT101",
        f"the distribution {in_quotes(name)} has no file {in_quotes(inner)}",
        _near(parts[-1], beside),
    )


def _editable_roots(distribution: Distribution) -> tuple[str, ...]:
    """Folders that an editable install takes its packages from; none for a plain install.

    Source: PEP 610, direct_url.json; `src` is the common layout.
    """
    from urllib.parse import urlsplit
    from urllib.request import url2pathname

    try:
        origin = json.loads(distribution.read_text("direct_url.json") or "{}")
        editable = bool(origin["dir_info"]["editable"])
        url = urlsplit(origin["url"])
    except (ValueError, KeyError, TypeError):
        return ()
    if not editable or url.scheme != "file":
        return ()
    root = url2pathname(url.path)
    return (root, os.path.join(root, "src"))


def names_in(folder: str) -> list[str]:
    """What there is in a folder; nothing where it cannot be read."""
    try:
        return sorted(os.listdir(folder))
    except OSError:
        return []


def _near(name: str, names: Iterable[str]) -> str | None:
    """The nearest name, else the model files that there are."""
    models = sorted(n for n in names if n.lower().endswith((".xml", ".urdf", ".mjcf")))
    near = nearest(name, models)
    if near is not None:
        return f"did you mean {in_quotes(near)}?"
    return f"the folder has {listed(models)}" if models else None


def _error(code: str, message: str, help: str | None = None) -> RobotError:
    return RobotError.of(code, message, where="robot.model", help=help)


def listed_robot(spec: Spec) -> RobotView:
    """The view of a robot with `model: none`: names, kinds and ranges, nothing else.

    Raises:
        ResolveError: a range has the unit of the other kind of joint.
    """
    joints = []
    faults = []
    for index, entry in enumerate(spec.model.robot.joints):
        span = spec.span("robot", "joints", index)
        name = entry if isinstance(entry, str) else entry.name
        kind = JointKind.HINGE if isinstance(entry, str) else JointKind(entry.kind)
        limits = None
        if not isinstance(entry, str) and entry.range is not None:
            low, high = entry.range
            limits = (float(low.value), float(high.value))
            if any(
                end.linear is not None and end.linear is not (kind is JointKind.SLIDE) for end in (low, high)
            ):
                faults.append(
                    Diagnostic(
                        "RES001",
                        Severity.ERROR,
                        f"'{name}' is a {kind.value} joint, but its range is [{low.written}, {high.written}]",
                        f"robot.joints[{index}].range",
                        span,
                        "a hinge is in rad, a slide in m",
                    )
                )
        joints.append(JointView(name, kind, span, body="", range=limits))
    if faults:
        raise ResolveError(faults)
    return RobotView(
        name=spec.model.robot.name,
        path=spec.document.path,
        format=ModelFormat.NONE,
        joints=tuple(joints),
        inertia_reason="the spec names no model",
    )
