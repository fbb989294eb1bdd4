"""MJCF and URDF to a file reading; what MuJoCo refuses is read as far as the XML tells."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from actspec.diagnostics import Diagnostic, RobotError, Severity
from actspec.readings.artifact import Artifact, FileKind, FileReading
from actspec.robot.view import ModelFile, RobotView
from actspec.robot.xml import XmlDocument, open_document

KINDS = {"mujoco": FileKind.MJCF, "robot": FileKind.URDF}
"""Root element to the kind of file."""

_TOLD_BY_RULES = ("ROBOT125",)
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


def read_robot(path: str, *, keep_matrices: bool, refusal: str | None = None) -> FileReading:
    """Read a robot file.

    An MJCF that the installed MuJoCo refuses is read from its text alone, and the artifact says why.

    Args:
        path: As the user named it.
        keep_matrices: Keep the mass matrices beside the joints' inertia; they are large.
        refusal: Why MuJoCo must not see the file (it crashed on it); None: it may.
    """
    try:
        document = open_document(path)
    except RobotError as err:
        return replace(_unreadable(path, None, err.diagnostics), files=_main_file(path))
    tag = document.root.tag
    kind = KINDS.get(tag)
    if kind is None:
        reason = f"the root element is <{tag}>: neither an MJCF (<mujoco>) nor a URDF (<robot>)"
        return FileReading(path, None, reason, files=document.files)
    try:
        view = _view(document, kind, keep_matrices, refusal)
    except RobotError as err:
        return replace(_unreadable(path, kind, err.diagnostics), files=document.files)
    if view.inertia is not None:
        from actspec.readings.joint import joint_inertias

        view = replace(view, joint_inertia=joint_inertias(view))
    artifact = Artifact(path, kind, view.name, robot=view, text_only=view.refusal)
    told = tuple(item for item in view.diagnostics if item.code not in _TOLD_BY_RULES)
    return FileReading(path, kind, None, (artifact,), document.files, told)


def _view(document: XmlDocument, kind: FileKind, matrices: bool, refusal: str | None) -> RobotView:
    """The view; of a file that MuJoCo refuses, from its text alone."""
    if kind is FileKind.URDF:
        from actspec.robot.read_urdf import read_urdf

        return read_urdf(
            document.files, document, refusal=refusal, matrices=matrices, poses=POSES, shapes=False
        )
    if refusal is None:
        from actspec.robot.read_mjcf import read_mjcf

        try:
            return read_mjcf(document.files, document, matrices=matrices, poses=POSES, shapes=False)
        except RobotError as err:
            refusal = reason_of(err.diagnostics, document.files[0].path)
    from actspec.robot.read_mjcf_text import read_mjcf_text

    return read_mjcf_text(document, refusal)


def reason_of(diagnostics: Sequence[Diagnostic], path: str) -> str:
    """The first error in one sentence, with its place.

    Args:
        diagnostics: Of a stage that failed.
        path: The file that the sentence is about; its name is not repeated.
    """
    first = next(item for item in diagnostics if item.severity is Severity.ERROR)
    span = first.span
    where = f"{first.where}: " if first.where else ""
    if span is None or not span.line:
        return where + first.message
    place = f"line {span.line}" if span.path == path else f"{span.path} line {span.line}"
    return f"{place}: {where}{first.message}"


def _unreadable(path: str, kind: FileKind | None, diagnostics: Sequence[Diagnostic]) -> FileReading:
    return FileReading(path, kind, reason_of(diagnostics, path), diagnostics=tuple(diagnostics))


def _main_file(path: str) -> tuple[ModelFile, ...]:
    """The bytes of a file that is not the XML that it should be, for excerpts."""
    from actspec.robot.xml import read_main

    try:
        return (read_main(path),)
    except RobotError:
        return ()
