"""One file to what is in it. Nothing that is read is executed."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Diagnostic, RobotError, Severity, Span, in_quotes
from actspec.files import NotRegular, TooLarge, read_regular
from actspec.readings.artifact import Artifact, FileKind, FileReading
from actspec.readings.template import placeholder, statement
from actspec.robot.sizes import TOO_LARGE
from actspec.robot.view import ModelFile, RobotView
from actspec.robot.xml_tree import NOT_XML
from actspec.spec.variants import split
from actspec.spec.yaml_text import is_spec

if TYPE_CHECKING:
    from actspec.robot.xml_tree import Include, XmlDocument

ROBOT = (".xml", ".urdf", ".mjcf")
"""Endings of robot files; a file that is named may have any other."""
ROBOT_ALONE = (".urdf", ".mjcf")
"""Those that nothing but robot files have."""
PYTHON = (".py",)
YAML = (".yaml", ".yml")

XACRO = ".xacro"
ROBOT_ROOT = re.compile(rb"<(?:mujoco|mujocoinclude|robot)[\s>/]")

XACRO_FILE, TEMPLATE, EMPTY = "xacro", "template", "empty"
"""Robot files that are not read where they are found in a folder."""

MOST_YAML_BYTES = 8 * 1024 * 1024
"""Chosen: the largest deploy file seen has 30 kB."""

FAULT = "AUD008"
"""Code of a file that was lost to a fault, and not for what is in it."""


KINDS = {"mujoco": FileKind.MJCF, "mujocoinclude": FileKind.MJCF, "robot": FileKind.URDF}
"""Root element to the kind of file; a `mujocoinclude` is a part of a model."""

_REPORTED_BY_RULES = ("ROBOT125",)
"""Codes of what a rule finds too: limits of 0, LIM101."""

POSES = 64
"""Chosen: sampled poses for the ledger's inertia, a quarter of those of a compile, because an audit of many
files is to take little longer than MuJoCo takes to compile them.

The least inertia of 1747 joints of 77 published MJCF and URDF models over these poses, as a multiple of that
over 5121 (2049 taken likewise, the others at ends and middles of the limits):

    others free: median joint 1.03, one joint in twenty 1.29, worst joint of the median model 1.29, of all 4.8
    others held: 1.01, 2.0, 2.2, 13
    a compile's 257 poses, free: 1.01, 1.14, 1.13, 1.6; held: 1.002, 1.35, 1.5, 3.4

The largest inertia is at most 37 % too low, the reference pose is exact. As many poses at corners of the limits
do worse (4.1 for the median model), and half of each no better: what is least is a folded or a stretched
limb, which is rarely at its limits.
"""


def read_file(
    path: str, keep_matrices: bool = False, refusal: str | None = None, named: tuple[str, ...] = ()
) -> FileReading:
    """Read one file, here and now, as what its name and content say that it is.

    Args:
        path: As the user named it.
        keep_matrices: As in `read_robot`.
        refusal: Likewise; set when a process ended on the file.
        named: As in `read_python`.
    """
    lower = path.lower()
    if lower.endswith(PYTHON):
        from actspec.readings.python.read import read_python

        return read_python(path, named)
    if split(path)[0].lower().endswith(YAML):
        return _read_yaml(path)
    return read_robot(path, keep_matrices=keep_matrices, refusal=refusal)


def _read_yaml(path: str) -> FileReading:
    """A spec by its key, which is not resolved here, else a deploy file."""
    try:
        data = read_regular(split(path)[0], MOST_YAML_BYTES)
    except NotRegular as err:
        return FileReading(path, None, f"it is {err}")
    except TooLarge:
        return FileReading(path, None, f"it is larger than {MOST_YAML_BYTES >> 20} MiB")
    except (OSError, ValueError) as err:
        return FileReading(path, None, (getattr(err, "strerror", None) or "bad path").lower())
    if not is_spec(data):
        from actspec.readings.deploy import read_deploy
        from actspec.readings.rl_sar import base_of

        return read_deploy(path, data, base_of(path, data, MOST_YAML_BYTES))
    return FileReading(path, FileKind.SPEC, None, (), (ModelFile(path, "", data),))


def read_robot(path: str, *, keep_matrices: bool, refusal: str | None = None) -> FileReading:
    """Read a robot file.

    An MJCF that the installed MuJoCo refuses is read from its text alone, and the artifact says why.

    Args:
        path: As the user named it.
        keep_matrices: Keep the mass matrices beside the joints' inertia; they are large.
        refusal: Why MuJoCo must not see the file (it crashed on it); None: it may.
    """
    from actspec.robot.xml import open_document

    try:
        document = open_document(path)
    except RobotError as err:
        return _not_xml(path, err.diagnostics)
    tag = document.root.tag
    kind = KINDS.get(tag)
    if kind is FileKind.URDF:
        from actspec.robot.read_urdf import is_xacro, unexpanded

        called = path.lower().endswith(XACRO)
        if is_xacro(document) or (called and next(unexpanded(document), None) is not None):
            return _xacro(path)
    if kind is None:
        reason = f"the root element is <{tag}>: neither an MJCF (<mujoco>) nor a URDF (<robot>)"
        return FileReading(path, None, reason, files=document.files)
    try:
        view = _view(document, kind, refusal)
    except RobotError as err:
        for item in err.diagnostics:
            # xacro 2.1.1 computes without its namespace, too: measured. In a name it may be no more than that.
            if kind is FileKind.URDF and "${" in item.message:
                return _xacro(path)
            if (value := placeholder(item.message, item.span, document)) is not None:
                return _template(path, value, item.span)
        return replace(unreadable(path, kind, err.diagnostics), files=document.files)
    value = None if view.refusal is None else placeholder(view.refusal, view.refused_at, document)
    if value is not None:
        return _template(path, value, view.refused_at)
    if view.inertia is not None:
        inertia = view.inertia if keep_matrices else None
        view = replace(view, joint_inertia=view.inertias(), inertia=inertia)
    artifact = Artifact(path, kind, view.name, robot=view, text_only=view.refusal)
    said = tuple(item for item in view.diagnostics if item.code not in _REPORTED_BY_RULES)
    return FileReading(path, kind, None, (artifact,), document.files, said)


def _not_xml(path: str, diagnostics: Sequence[Diagnostic]) -> FileReading:
    """A file that is no XML, or that cannot be put together, which a template may be."""
    reading = replace(unreadable(path, None, diagnostics), files=_main_file(path))
    data = b"".join(file.data for file in reading.files)
    own = path.lower().endswith(ROBOT_ALONE)
    if not data.strip():
        return replace(reading, unread=EMPTY if own and reading.files else "")
    if not own and ROBOT_ROOT.search(data) is None:
        return reading
    for item in diagnostics:
        if (value := placeholder(item.message, item.span)) is not None:
            return _template(path, value, item.span)
        # Of an included file that is no XML, too.
        for file in _main_file(item.span.path) if item.code == NOT_XML and item.span is not None else ():
            if (found := statement(file)) is not None:
                return _template(path, *found)
    return reading


def _xacro(path: str) -> FileReading:
    from actspec.robot.read_urdf import EXPAND

    called = path.lower().endswith(XACRO)
    help = EXPAND if called else f"xacro {os.path.basename(path)} -o EXPANDED.urdf, and name that"
    reading = nothing_to_audit(path, "this is a xacro, which has to be expanded first", help)
    return replace(reading, unread=XACRO_FILE)


def _template(path: str, value: str, place: Span | None) -> FileReading:
    help = "name the file that the program which fills it in writes"
    reading = nothing_to_audit(
        path, f"this is a template, which has to be filled in first: {value}", help, place=place
    )
    return replace(reading, unread=TEMPLATE)


def _view(document: XmlDocument, kind: FileKind, refusal: str | None) -> RobotView:
    """The view; of a file that MuJoCo refuses, from its text alone."""
    if kind is FileKind.URDF:
        from actspec.robot.read_urdf import read_urdf

        return read_urdf(document.files, document, refusal=refusal, poses=POSES, shapes=False)
    refused_at = None
    if refusal is None:
        from actspec.robot.read_mjcf import read_mjcf

        try:
            return read_mjcf(document.files, document, poses=POSES, shapes=False)
        except RobotError as err:
            from actspec.robot.xml import NOT_FOLLOWED

            # Of a file beside it, too: an attached model is refused as an include is.
            if err.diagnostics[0].code in (TOO_LARGE, *NOT_FOLLOWED):
                raise
            refusal, refused_at = _first(err.diagnostics)
            twice = _second_include(document)
            if twice is not None:
                message = f"{in_quotes(twice.name)} is included a second time; {refusal}"
                raise RobotError.of("ROBOT007", message, document.span(twice.element)) from err
    from actspec.robot.read_mjcf_text import read_mjcf_text

    return replace(read_mjcf_text(document, refusal), refused_at=refused_at)


def _second_include(document: XmlDocument) -> Include | None:
    """The include that brings bodies or actuators again: each figure is there twice, and no such robot is meant."""
    moving = {element.file for element in document.walk("body", "actuator")}
    seen = set()
    for include in document.includes:
        path = document.files[include.index].path
        if path in seen and include.index in moving:
            return include
        seen.add(path)
    return None


def unreadable(path: str, kind: FileKind | None, diagnostics: Sequence[Diagnostic]) -> FileReading:
    """A file that a stage refused: its first error is the reason."""
    reason, refused = _first(diagnostics)
    return FileReading(path, kind, reason, diagnostics=tuple(diagnostics), refused=refused)


def _first(diagnostics: Sequence[Diagnostic]) -> tuple[str, Span | None]:
    """The first error in one sentence, and its place where that is less than a file."""
    first = next(item for item in diagnostics if item.severity is Severity.ERROR)
    reason = f"{first.where}: {first.message}" if first.where else first.message
    return reason, first.span if first.span is not None and first.span.line else None


def _main_file(path: str) -> tuple[ModelFile, ...]:
    """The bytes of a file that is not the XML that it should be, for excerpts."""
    from actspec.robot.xml import read_main

    try:
        return (read_main(path),)
    except RobotError:
        return ()


def nothing_to_audit(
    path: str, reason: str, help: str, where: str = "", place: Span | None = None
) -> FileReading:
    """What stands for nothing that can be audited."""
    message = f"nothing to audit{where}: {reason}"
    fault = Diagnostic("AUD014", Severity.ERROR, message, "", place or Span(path), help)
    return FileReading(path, None, reason, diagnostics=(fault,))
