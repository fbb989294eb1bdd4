"""Fixes put into the text of files: all edits of a fix or none, each file in one step, the model checked.

After a fix of an XML the compiled model differs from the one before in the fields that the fix names
and in no other, or the fix is not made.
"""

from __future__ import annotations

import ast
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from actspec.audit.finding import Fix, Safety, TextEdit
from actspec.audit.outcome import Reported
from actspec.diagnostics import ActspecError, AuditError, Collector, Diagnostic, Severity, Span, listed
from actspec.files import why
from actspec.placing import place
from actspec.processes import IsolatedCall, LostError
from actspec.readings.artifact import FileKind, FileReading
from actspec.robot.view import ModelFile, ModelFormat

_OF_UNITS = "UNT"
_OF_FIGURES = (_OF_UNITS, "SGN")
"""Families of rules about what the figures of a file mean."""

MOST_PASSES = 10
"""Chosen: fixes that overlap come one a pass; a chain of ten is two rules that undo each other."""


@dataclass(frozen=True, slots=True)
class FixedFile:
    """A file with fixes in it, not yet written.

    Attributes:
        path: As in `FileReading.files`.
        old: Bytes before.
        new: Bytes after.
        titles: What its fixes do, each once.
    """

    path: str
    old: bytes
    new: bytes
    titles: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Fixes:
    """What one pass can fix.

    Attributes:
        files: Files that change, in the order of the findings.
        refused: Fixes that failed their check.
    """

    files: tuple[FixedFile, ...]
    refused: tuple[Diagnostic, ...]


def without_doubtful(found: Sequence[Reported]) -> tuple[Reported, ...]:
    """Findings without the fixes that another finding speaks against.

    A fix that is not safe takes the rest of its file for right: none is offered where the unit or sign of a whole file
    is in doubt, or the units of two joints or more, which no fix of their own mends. Neither is any of two that put
    different text in the place of the same bytes.

    Args:
        found: All findings.
    """
    doubted: set[str] = set()
    joints: dict[str, set[str]] = {}
    for finding in (item.finding for item in found):
        family = finding.code.rstrip("0123456789")
        if family in _OF_FIGURES and not finding.joint:
            doubted.add(finding.span.path)
        elif family == _OF_UNITS and finding.fix is None:
            joints.setdefault(finding.span.path, set()).update(finding.joints or (finding.joint,))
    doubted.update(path for path, names in joints.items() if len(names) > 1)
    texts: dict[tuple[str, int, int], set[bytes]] = {}
    for edit in (edit for item in found if item.finding.fix is not None for edit in item.finding.fix.edits):
        if edit.start < edit.end:
            texts.setdefault((edit.path, edit.start, edit.end), set()).add(edit.new)

    def is_doubtful(fix: Fix) -> bool:
        trusting = fix.safety is Safety.UNSAFE
        return any(
            (trusting and edit.path in doubted) or len(texts.get((edit.path, edit.start, edit.end), ())) > 1
            for edit in fix.edits
        )

    return tuple(
        replace(item, finding=replace(item.finding, fix=None))
        if item.finding.fix is not None and is_doubtful(item.finding.fix)
        else item
        for item in found
    )


def apply_fixes(findings: Iterable[Reported], files: Sequence[FileReading], unsafe: bool) -> Fixes:
    """Put the fixes of findings into the text of their files; nothing is written.

    Of fixes that overlap the first one is taken; the others may fit on the next pass.

    Args:
        findings: In the report's order.
        files: What was read.
        unsafe: Whether fixes that change how the robot behaves are taken too.
    """
    data = {_key(file.path): file for reading in files if reading.readable for file in reading.files}
    wanted = [
        (item, item.finding.fix)
        for item in findings
        if item.finding.fix is not None and (unsafe or item.finding.fix.safety is Safety.SAFE)
    ]
    taken: list[tuple[Reported, Fix]] = []
    edits: set[TextEdit] = set()
    for item, fix in wanted:
        own = {replace(edit, path=_key(edit.path)) for edit in fix.edits}
        # Joints that share a default class share its fix.
        if all(edit.path in data for edit in own) and not _overlap(own - edits, edits):
            edits |= own
            taken.append((item, fix))
    refused: list[Diagnostic] = []
    with IsolatedCall(_model_fault) as check:
        reason = _fault([fix for _, fix in taken], data, files, check)
        if reason is not None:
            # One of them is at fault: each is tried beside those that passed.
            good: list[tuple[Reported, Fix]] = []
            for item, fix in taken:
                reason = _fault([*(other for _, other in good), fix], data, files, check)
                if reason is None:
                    good.append((item, fix))
                else:
                    refused.append(_refusal(item, fix, reason))
            taken = good
    return Fixes(tuple(_fixed([fix for _, fix in taken], data)), tuple(dict.fromkeys(refused)))


def write_fixes(files: Sequence[FixedFile], report: tuple[str, bytes] | None = None) -> None:
    """Write fixed files, and the report of them, all or none.

    Args:
        files: The files.
        report: Its path and bytes, which nothing is lost by; None: it is printed.

    Raises: AuditError: files that have changed since they were read, or cannot be written.
    """
    out = Collector()
    for file in files:
        try:
            with open(file.path, "rb") as stream:
                if stream.read() != file.old:
                    out.error(
                        "AUD012", "the file has changed since it was read; not fixed", span=Span(file.path)
                    )
                    continue
        except OSError as err:
            out.error("AUD006", f"the file cannot be read again: {why(err)}", span=Span(file.path))
    out.raise_if_failed(AuditError)
    try:
        place([*((file.path, file.new) for file in files), *([] if report is None else [report])])
    except OSError as err:
        message = f"the file cannot be written: {why(err)}"
        raise AuditError.of("AUD006", message, Span(str(err.filename))) from err


def _key(path: str) -> str:
    return os.path.realpath(path)


def _overlap(new: set[TextEdit], old: set[TextEdit]) -> bool:
    """Whether edits touch bytes, or insert at places, that others do."""
    return any(
        a.path == b.path and ((a.start < b.end and b.start < a.end) or a.start == b.start)
        for a in new
        for b in old
    )


def _edited(fixes: Iterable[Fix], data: Mapping[str, ModelFile]) -> dict[str, bytes]:
    """Path to new bytes."""
    by_path: dict[str, set[TextEdit]] = {}
    for edit in (edit for fix in fixes for edit in fix.edits):
        by_path.setdefault(_key(edit.path), set()).add(replace(edit, path=""))
    found = {}
    for path, edits in by_path.items():
        text = data[path].data
        for edit in sorted(edits, key=lambda edit: edit.start, reverse=True):
            text = text[: edit.start] + edit.new + text[edit.end :]
        found[path] = text
    return found


def _fixed(fixes: Sequence[Fix], data: Mapping[str, ModelFile]) -> Iterator[FixedFile]:
    for path, new in _edited(fixes, data).items():
        titles = dict.fromkeys(
            fix.title for fix in fixes if any(_key(edit.path) == path for edit in fix.edits)
        )
        if new != data[path].data:
            yield FixedFile(data[path].path, data[path].data, new, tuple(titles))


def _refusal(item: Reported, fix: Fix, reason: str) -> Diagnostic:
    return Diagnostic(
        "AUD011",
        Severity.WARNING,
        f"the fix of {item.finding.code} is not applied ({fix.title}): {reason}",
        item.finding.joint,
        item.finding.span,
    )


def _fault(
    fixes: Sequence[Fix],
    data: Mapping[str, ModelFile],
    files: Sequence[FileReading],
    check: IsolatedCall[str | None],
) -> str | None:
    """Why these fixes together must not be made; None when they may."""
    new = _edited(fixes, data)
    fields = {field for fix in fixes for field in fix.fields}
    for reading in files:
        touched = reading.readable and any(_key(file.path) in new for file in reading.files)
        if touched:
            after = tuple(replace(file, data=new.get(_key(file.path), file.data)) for file in reading.files)
            reason = _reading_fault(reading, after, fields, check)
            if reason is not None:
                return reason
    return None


def _reading_fault(
    reading: FileReading, after: tuple[ModelFile, ...], fields: set[str], check: IsolatedCall[str | None]
) -> str | None:
    if reading.kind in (FileKind.MJCF, FileKind.URDF):
        form = ModelFormat.MJCF if reading.kind is FileKind.MJCF else ModelFormat.URDF
        try:
            # MuJoCo has read these files, but not yet as they would be, and not in this process.
            return check(reading.path, form, reading.files, after, fields)
        except LostError as err:
            return f"{reading.path} could not be compiled to check it: {err}"
    import yaml

    for file in after:
        try:
            if file.path.endswith(".py"):
                ast.parse(file.data)
            else:
                yaml.compose(file.data, Loader=yaml.SafeLoader)
        except (SyntaxError, ValueError, RecursionError, yaml.YAMLError) as err:
            return f"{file.path} could not be read afterwards: {type(err).__name__}"
    return None


def _model_fault(
    path: str,
    form: ModelFormat,
    before: tuple[ModelFile, ...],
    after: tuple[ModelFile, ...],
    fields: set[str],
) -> str | None:
    """What the compiled model says against an edit of its text."""
    from actspec.robot.compiled import DERIVED, differences
    from actspec.robot.mjspec import compile_spec, open_spec

    try:
        old = compile_spec(open_spec(before, format=form))
    except ActspecError:
        return f"MuJoCo does not take {path} as it is, so the fix cannot be checked"
    try:
        new = compile_spec(open_spec(after, format=form))
    except ActspecError as err:
        return f"MuJoCo refuses {path} afterwards: {err.diagnostics[0].message}"
    changed = [text for text in differences(old, new) if text.partition(":")[0] not in fields | DERIVED]
    return f"it would change {listed(changed, 3)} of the compiled model" if changed else None
