"""What one compile made, and writing it: only what differs, atomically, never over somebody else's file."""

from __future__ import annotations

import difflib
import hashlib
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import actspec
from actspec.diagnostics import Collector, Diagnostic, EmitError, Span, listed, one_line
from actspec.files import FAULTS, json_of, name_in_file, noting, read_regular, was_read, why
from actspec.owned import put, say_read
from actspec.targets.base import Approximation, Emission, EmittedFile, TargetOptions

if TYPE_CHECKING:
    from actspec.ir import ActuatorSet
    from actspec.robot.view import RobotView
    from actspec.spec.validate import Spec

MANIFEST = "manifest.json"
MANIFEST_FORMAT = "actspec-manifest/1"
_MOST_MANIFEST = 64 << 20
"""Bytes. Chosen: that of other JSON that actspec has written."""


@dataclass(frozen=True, slots=True)
class Compilation:
    """Everything that one compile made, before anything is written.

    Attributes:
        spec: The spec.
        robot: The robot's file, read.
        actuators: What the spec means on that robot.
        targets: Options of each target, in the spec's order.
        emissions: What each made, in the same order.
        diagnostics: Warnings and notes of all stages.
        failures: Name of a target that could not be compiled and what it reports, where the others are asked for all
            the same.
    """

    spec: Spec
    robot: RobotView
    actuators: ActuatorSet
    targets: tuple[TargetOptions, ...]
    emissions: tuple[Emission, ...]
    diagnostics: tuple[Diagnostic, ...]
    failures: tuple[tuple[str, Diagnostic], ...] = ()

    @property
    def approximations(self) -> tuple[Approximation, ...]:
        """Of the spec itself, then of all targets."""
        emitted = (loss for emission in self.emissions for loss in emission.approximations)
        return (*self.actuators.approximations, *emitted)

    @property
    def unaccepted(self) -> tuple[Approximation, ...]:
        """Approximations that the spec's `accept` does not take, or takes for smaller than they are."""
        taken = dict(self.actuators.accept)
        return tuple(
            loss for loss in self.approximations if loss.key not in taken or not loss.within(taken[loss.key])
        )


@dataclass(frozen=True, slots=True, order=True)
class Origin:
    """What a file was written from.

    Attributes:
        spec: File name of the spec, with the variant as the command line has it: `a1.yaml`, `g1.yaml#mode_13`.
        robot: Name of its robot; "": an older actspec did not write it down.
    """

    spec: str
    robot: str

    def same(self, other: Origin) -> bool:
        """Whether both are one spec: specs in several folders may have one name, but are then of other robots."""
        return self.spec == other.spec and ("" in (self.robot, other.robot) or self.robot == other.robot)

    def beside(self, other: Origin) -> str:
        """In words that tell it from another one."""
        return self.spec if self.spec != other.spec else f"{self.spec} of robot '{self.robot}'"


@dataclass(frozen=True, slots=True)
class Output:
    """A file to write and what is there now.

    Attributes:
        target: Name of its target.
        folder: Of the target, which has its manifest.
        path: Path.
        data: New bytes.
        old: Bytes that are there; None when there is no file.
        origin: What it is made from.
    """

    target: str
    folder: str
    path: str
    data: bytes
    old: bytes | None
    origin: Origin

    @property
    def changed(self) -> bool:
        """Whether writing it changes anything."""
        return self.data != self.old

    @property
    def sha256(self) -> str:
        """Hash of the new bytes."""
        return hashlib.sha256(self.data).hexdigest()


def outputs(compilation: Compilation) -> tuple[Output, ...]:
    """All files of a compilation, each target's manifest last, beside what is on disk.

    Raises:
        EmitError: a path exists and is not a regular file.
    """
    collector = Collector()
    found = []
    for options, emission in zip(compilation.targets, compilation.emissions, strict=True):
        record = _record(compilation, options, emission)
        manifest = EmittedFile(MANIFEST, _manifest(record, options.folder))
        for file in (*emission.files, manifest):
            path = os.path.join(options.folder, file.path)
            old: bytes | None = None
            try:
                if os.path.lexists(path):
                    if not os.path.isfile(path):
                        collector.error("OUT001", "exists and is not a regular file", span=Span(path))
                        continue
                    with open(path, "rb") as stream:
                        old = stream.read()
            except OSError as err:
                collector.error("OUT002", f"cannot be read: {err.strerror}", span=Span(path))
                continue
            found.append(Output(options.name, options.folder, path, file.data, old, _origin(record)))
    collector.raise_if_failed(EmitError)
    return tuple(found)


def write(files: Sequence[Output], *, force: bool = False) -> None:
    """Write the files that differ, all or none.

    Args:
        files: From `outputs`.
        force: Also replace files that actspec did not write, or from another spec, or that were edited since.

    Raises:
        EmitError: a file would be lost, was read in this run, or cannot be written, or two are one; nothing is
            written.
    """
    collector = Collector()
    _check_distinct(files, collector)
    others: dict[tuple[Origin, Origin], list[str]] = {}
    for file in files:
        if not file.changed or file.old is None:
            continue
        if was_read(file.path):
            say_read(file.path, collector, "choose another folder with -o")
        elif force:
            continue
        elif (other := other_spec(file)) is not None:
            others.setdefault((other, file.origin), []).append(file.path)
        elif not is_ours(file):
            collector.error(
                "OUT003",
                f"exists already, and {_unlike(file)}",
                span=Span(file.path),
                help="choose another folder with -o, or replace it with --force",
            )
    for (other, own), (first, *rest) in others.items():
        more = (
            f"; so {'was' if len(rest) == 1 else 'were'} {len(rest)} more: {listed(rest, 4)}" if rest else ""
        )
        collector.error(
            "OUT003",
            f"was written from {other.beside(own)}, and this run writes {own.beside(other)}{more}",
            span=Span(first),
            help="choose another folder with -o: each spec needs one of its own where files have one name; "
            f"--force replaces what was written from {other.spec}",
        )
    collector.raise_if_failed(EmitError)
    write_files([(file.path, file.data) for file in files if file.changed], force=True)


def write_files(files: Sequence[tuple[str, bytes]], *, force: bool) -> None:
    """Put files in place, all or none; see `actspec.owned.put`.

    Raises: EmitError: one cannot be written, or would be lost; nothing was.
    """
    try:
        put(files, force=force)
    except FAULTS as err:
        path = getattr(err, "filename", None) or files[0][0]
        raise EmitError.of("OUT002", f"cannot be written: {why(err)}", Span(str(path))) from err


def diff(files: tuple[Output, ...]) -> Iterator[str]:
    """Lines of a unified diff from what is on disk to what would be written."""
    for file in files:
        if not file.changed:
            continue
        other = other_spec(file)
        before = os.devnull if file.old is None else file.path
        note = "" if other is None else f"written from {other.spec}"
        yield from diff_lines(file.old or b"", file.data, before, file.path, note)


def diff_lines(old: bytes, new: bytes, before: str, after: str, note: str = "") -> Iterator[str]:
    """Lines of a unified diff.

    Args:
        old: Text before.
        new: Text after.
        before: What the old file is called.
        after: What the new file is called.
        note: What is said of the old file behind its name, where a diff may have the time.
    """
    first, second = (data.decode("utf-8", "replace").splitlines(keepends=True) for data in (old, new))
    for line in difflib.unified_diff(first, second, one_line(before), one_line(after), one_line(note)):
        yield line if line.endswith("\n") else line + "\n"


def write_text(path: str, text: str, *, force: bool) -> None:
    """Write a text in one step, with its folders; characters that UTF-8 lacks are escaped.

    Raises: EmitError: it cannot be written, or a file would be lost.
    """
    write_files([(path, text.encode("utf-8", "backslashreplace"))], force=force)


def loss_record(loss: Approximation) -> dict[str, Any]:
    """An approximation as machine output has it."""
    return {
        "target": loss.target,
        "joint": loss.joint,
        "field": loss.field,
        "asked": loss.asked,
        "emitted": loss.emitted,
        "why": loss.why,
        "max_torque_error": loss.max_torque_error,
        **({"at": loss.at, "above_no_load_speed": loss.beyond} if loss.beyond is not None else {}),
    }


def _check_distinct(files: Sequence[Output], collector: Collector) -> None:
    """Report files of one path; names that differ by case alone are one on many file systems."""
    first: dict[str, Output] = {}
    for file in files:
        other = first.setdefault(os.path.realpath(file.path).casefold(), file)
        if other is not file:
            both = (
                f"two targets of this run write it: '{other.target}' and '{file.target}'"
                if other.target != file.target
                else f"this run writes it twice, for '{file.target}'"
            )
            collector.error(
                "OUT004",
                both,
                span=Span(file.path),
                help="compile them one after the other, each into a folder of its own with -o",
            )


def _record(compilation: Compilation, options: TargetOptions, emission: Emission) -> dict[str, Any]:
    """What was made from what; no time and no path of a machine, so that it is the same everywhere."""
    return {
        "tool": f"actspec {actspec.__version__}",
        "spec": name_in_file(os.path.basename(compilation.spec.document.path)),
        "spec_sha256": compilation.actuators.spec_sha256,
        **({"variant": compilation.actuators.variant} if compilation.actuators.variant else {}),
        "robot": compilation.spec.model.robot.name,
        "target": {"name": options.name, "kind": options.kind, "version": options.version},
        "files": [{"path": file.path, "sha256": file.sha256} for file in emission.files],
        "approximations": [
            loss_record(loss) for loss in (*compilation.actuators.approximations, *emission.approximations)
        ],
    }


def _origin(record: Mapping[str, Any]) -> Origin:
    variant = f"#{record['variant']}" if record.get("variant") else ""
    return Origin(f"{record['spec']}{variant}", str(record.get("robot", "")))


def _manifest(record: Mapping[str, Any], folder: str) -> bytes:
    """The manifest of a folder: what other specs have there stays in it, whichever was compiled last."""
    own, files = _origin(record), _hashes(record)
    records = [record]
    for other in _records(folder) or ():
        # A path that this spec takes over, by --force or where nothing lies, is the other's no more.
        kept = [
            e for e in other["files"] if files.get(os.path.normpath(e["path"]), e["sha256"]) == e["sha256"]
        ]
        if kept and not _origin(other).same(own):
            records.append({**other, "files": kept})
    first, *others = sorted(records, key=_origin)
    whole = {"format": MANIFEST_FORMAT, **first, **({"others": others} if others else {})}
    return f"{json_of(whole)}\n".encode()


def _records(folder: str) -> list[dict[str, Any]] | None:
    """What the manifest of a folder says of each spec; None: it has none of actspec's."""
    try:
        with noting():  # to be judged, and not as this run's input
            first = json.loads(read_regular(os.path.join(folder, MANIFEST), _MOST_MANIFEST))
        if first.pop("format") != MANIFEST_FORMAT:
            return None
        records: list[dict[str, Any]] = [first, *first.pop("others", ())]
        for record in records:  # they are asked and written anew below
            _origin(record), _hashes(record), json_of(record)
    except (*FAULTS, KeyError, TypeError, AttributeError, RecursionError):
        return None
    return records


def _hashes(record: Mapping[str, Any]) -> dict[str, str]:
    """Path below the target's folder to hash of each file of a record."""
    return {os.path.normpath(entry["path"]): str(entry["sha256"]) for entry in record["files"]}


def _owners(file: Output) -> list[Origin]:
    """The specs from which a file was written as it is there."""
    assert file.old is not None
    name, sha256 = os.path.relpath(file.path, file.folder), hashlib.sha256(file.old).hexdigest()
    return [_origin(record) for record in _records(file.folder) or () if _hashes(record).get(name) == sha256]


def _is_manifest(file: Output) -> bool:
    return os.path.relpath(file.path, file.folder) == MANIFEST


def is_ours(file: Output) -> bool:
    """Whether the manifest of its target's folder says that actspec wrote a file as it is there, from any spec."""
    return _records(file.folder) is not None if _is_manifest(file) else bool(_owners(file))


def other_spec(file: Output) -> Origin | None:
    """Another spec than the file's, from which what is there was written; None: there is none, or it was edited since.

    Also where both specs made the same of it: the other one needs what is there.
    """
    if file.old is None or _is_manifest(file):
        return None
    return next((origin for origin in _owners(file) if not origin.same(file.origin)), None)


def _unlike(file: Output) -> str:
    """Why a file that is there is not taken for actspec's."""
    if _is_manifest(file):
        return "is no manifest of actspec"
    name = os.path.relpath(file.path, file.folder)
    if any(name in _hashes(record) for record in _records(file.folder) or ()):
        return "was edited since actspec wrote it"
    return f"no {MANIFEST} beside it says that actspec wrote it"
