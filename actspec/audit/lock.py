"""The dynamics lock: what acts on each joint, as text for version control, and what has changed since.

A joint's hash is of its figures, rounded to nine digits, so that the noise of a sum does not change it. Links'
inertia is not in it: a lock is about actuators. The lock's own hash is of the names of its files alone: two branches
that record changes of different robots merge without a conflict, and a merge that loses a file is noticed.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, replace
from typing import Any

from actspec.audit.case import Case
from actspec.audit.difference import Difference, axis_text, compare_robots
from actspec.audit.outcome import UNKNOWN
from actspec.audit.places import json_fault, json_places
from actspec.audit.same_robot import called
from actspec.audit.settings import read_versions
from actspec.diagnostics import (
    AuditError,
    Collector,
    Diagnostic,
    Path,
    Severity,
    Span,
    listed,
    one_line,
    shortened,
)
from actspec.fields import FIELDS, Role
from actspec.files import FAULTS, json_of, name_in_file, path_of_name, read_regular, why
from actspec.readings.artifact import STEP_OF_WHAT, FileKind
from actspec.readings.compare import Figure
from actspec.readings.dynamics import (
    ORDERS,
    SETTING_NOUNS,
    JointDynamics,
    RobotDynamics,
    dynamics_of,
    is_figure,
)
from actspec.readings.ledger import LedgerRow
from actspec.readings.leftover import is_step
from actspec.readings.versions import Versions

FORMAT = "actspec-lock/1"

SAME = 6e-9
"""Largest relative difference from a figure that was rounded to nine digits, which is up to 5e-9 off."""

MOST_BYTES = 64 << 20
"""Chosen: a robot of 30 joints takes 20 kB."""

_MOST = 10**300
"""Whole numbers beyond are no floats."""

_TEXTS = ("hash", "control", "network", "axis")
"""Keys of a joint that are no figures."""

_HASH = 16
"""Hexadecimal digits of a hash: 64 bits, as in the baseline."""


def locked(case: Case, names: Mapping[str, str]) -> dict[str, Any]:
    """The lock of every file of a case.

    Args:
        case: What was read.
        names: Path of a file to its name in the lock.
    """
    files: dict[str, Any] = {}
    for path, name in names.items():
        for robot, index in _robots(case, path).items():
            artifact = case.artifacts[index]
            entry = files.setdefault(name, {"kind": artifact.kind.value, "robots": {}})
            entry["robots"][robot] = _robot(dynamics_of(artifact, case.rows_of(index)))
    versions = {
        field.name: value
        for field in fields(Versions)
        if (value := getattr(case.versions, field.name)) is not None
    }
    return {"format": FORMAT, "versions": versions, "files": files, "hash": _hash_of_files(files)}


def text_of(lock: Mapping[str, Any]) -> bytes:
    """A lock as the bytes of its file: sorted, one figure a line."""
    return f"{json_of(lock, sort_keys=True)}\n".encode()


def old_form(lock: Mapping[str, Any], path: str) -> Iterator[Diagnostic]:
    """What a lock of an older actspec cannot tell.

    Args:
        lock: From `read_lock`.
        path: Of the lock.
    """
    if "hash" not in lock:
        message = "it has no hash of the names of its files, so that a file which a merge lost is not noticed"
        yield Diagnostic("LCK007", Severity.WARNING, message, "", Span(path), "`actspec lock` adds it")


def remarks(case: Case, lock: Mapping[str, Any], names: Mapping[str, str]) -> Iterator[Diagnostic]:
    """What a lock does not have, or has from the text of a model alone.

    Args:
        case: What was read.
        lock: From `locked`.
        names: Path of a file to its name in the lock.
    """
    for file in case.files:
        for model in file.refused_models if file.whole is None else ():
            message = f"the model does not compile, and is recorded from its text alone: {model.text_only}"
            yield Diagnostic("LCK004", Severity.WARNING, message, "", model.refused_at or Span(file.path))
        said = file.said
        yield from (item for item in said if item.code == STEP_OF_WHAT)
        unknown = [item for item in said if item.code in UNKNOWN]
        if all(
            _is_empty(robot, bool(unknown)) for robot in lock["files"][names[file.path]]["robots"].values()
        ):
            why_not, place = "", Span(file.path)
            for item in unknown[:1]:
                why_not = f": {item.where}: {item.message}" if item.where else f": {item.message}"
                place = item.span or place
            message = f"no joint is recorded of this file, so that no change of one will be seen{why_not}"
            yield Diagnostic("LCK005", Severity.WARNING, message, "", place)
    for index in range(len(case.artifacts)):
        left = [(row, name) for row in case.rows_of(index) for name in FIELDS if _is_left_out(row, name)]
        if left:
            row, first = left[0]
            what = dict.fromkeys(
                f"{FIELDS[name].noun} of {shortened(row.joint)} ({getattr(row, name)})" for row, name in left
            )
            message = f"what is not finite is left out as unknown: {listed(what, 4)}"
            yield Diagnostic("LCK006", Severity.WARNING, message, "", row.place(first))


def _is_empty(robot: Mapping[str, Any], unknown: bool) -> bool:
    """Whether a lock has nothing of a robot; of one with unknown figures, nothing but its settings."""
    return not any(
        value for key, value in robot.items() if key != "hash" and not (unknown and key == "settings")
    )


def _is_left_out(row: LedgerRow, name: str) -> bool:
    """Whether a file gives a figure that is none, itself and not by way of others."""
    follows = FIELDS[name].role in (Role.TOTAL, Role.DERIVED)
    return not follows and not is_figure(name, getattr(row, name, None))


def changes(
    lock: Mapping[str, Any], case: Case, names: Mapping[str, str]
) -> tuple[tuple[str, Difference], ...]:
    """What has changed since a lock was written.

    A robot that the lock does not have is all new, one that the files no longer have is all gone.

    Args:
        lock: From `read_lock`.
        case: The same files now.
        names: Path of a file to its name in the lock.

    Returns: Name of the file and the difference, one a robot of those files.
    """
    found = []
    for path, name in names.items():
        entry = lock["files"][name]
        kind = FileKind(entry["kind"])
        now = {
            robot: dynamics_of(case.artifacts[index], case.rows_of(index))
            for robot, index in _robots(case, path).items()
        }
        for robot in sorted({*entry["robots"], *now}):
            new = now.get(robot, RobotDynamics(robot, path, kind, {}))
            old = _dynamics(robot, name, kind, entry["robots"].get(robot))
            if "hash" not in lock:
                new = _as_before_steps(new, old)
            found.append((name, compare_robots(old, new, SAME)))
    return tuple(found)


def _as_before_steps(new: RobotDynamics, old: RobotDynamics) -> RobotDynamics:
    """A robot beside a lock of an older actspec, which took no step of a deploy file that is called `dt`."""
    if new.kind is not FileKind.DEPLOY:
        return new
    settings = {name: value for name, value in new.settings.items() if name in old.settings}
    entries = {
        where: value
        for where, value in (new.entries or {}).items()
        if where in (old.entries or ()) or not is_step(where)
    }
    return replace(new, settings=settings, entries=entries)


def _robots(case: Case, path: str) -> dict[str, int]:
    """The robots of a file, by what they are called, to their artifacts."""
    own = [index for index, artifact in enumerate(case.artifacts) if artifact.path == path]
    return dict(zip(called(case.artifacts[index].name for index in own), own, strict=True))


def load_lock(path: str, *, needed: bool, figures: bool) -> dict[str, Any] | None:
    """The lock that is there; what is not a lock is never overwritten.

    Args:
        path: Of the lock.
        needed: Whether it must be there, because its list of files is used.
        figures: As in `read_lock`.

    Raises: AuditError: it is not there, cannot be read, or is not a lock.
    """
    try:
        data = read_regular(path, MOST_BYTES)
    except FileNotFoundError as err:
        if needed:
            raise AuditError.of(
                "LCK001", "there is no such lock", Span(path), help="write one with `actspec lock FILE`"
            ) from err
        return None
    except FAULTS as err:
        raise AuditError.of("LCK001", f"cannot be read: {why(err)}", Span(path)) from err
    return read_lock(path, data, figures=figures, files=needed)


def names_in_lock(files: Sequence[str], lock: str) -> dict[str, str]:
    """Files and what the lock calls them: relative to its folder, with `/`.

    Raises: AuditError: a file has no such path, as on another drive.
    """
    folder = os.path.dirname(os.path.abspath(lock))
    found: dict[str, str] = {}
    for file in files:
        try:
            name = name_in_file(os.path.relpath(os.path.abspath(file), folder).replace(os.sep, "/"))
        except ValueError as err:
            raise AuditError.of("LCK001", f"has no path relative to {one_line(folder)}", Span(file)) from err
        if name not in found.values():
            found[file] = name
    return found


def recorded_files(lock: Mapping[str, Any], path: str) -> dict[str, str]:
    """Files of a lock and what it calls them."""
    folder = os.path.dirname(path)
    return {os.path.join(folder, *path_of_name(name).split("/")): name for name in lock["files"]}


def read_lock(path: str, data: bytes, *, figures: bool = True, files: bool = True) -> dict[str, Any]:
    """A lock from its bytes.

    Args:
        path: Of the lock, for messages.
        data: Its bytes.
        figures: Check its figures too; without, only which files and versions it is about.
        files: Check that it has all the files that were recorded; without, they are named anew.

    Raises: AuditError: it is no lock, is of another actspec, names files by an absolute path, or its figures or
        files do not fit their hashes.
    """
    out = Collector()
    lock: Any = None
    text, place, why_not = "", Span(path), ""
    try:
        text = data.decode("utf-8")
        lock = json.loads(text)
    except (ValueError, RecursionError) as err:
        at, reason = json_fault(data, err)
        place, why_not = Span(path, *at), f": {reason}"
    form: Path = ("format",)
    if not isinstance(lock, dict) or not str(lock.get("format", "")).startswith("actspec-lock/"):
        place = place if why_not else _spans(path, text, [form])[form]
        help = "write a new one with `actspec lock FILE --force`"
        out.error("LCK001", f"is not a dynamics lock{why_not}", span=place, help=help)
    elif lock["format"] != FORMAT:
        told = shortened(str(lock["format"]))
        place = _spans(path, text, [form])[form]
        out.error("LCK001", f"has the format {told}, and this actspec knows {FORMAT}", span=place)
    else:

        def refuse(faults: Sequence[tuple[Path, str]]) -> None:
            spans = _spans(path, text, [at for at, _ in faults])
            for way, fault in faults:
                help = "write it again with `actspec lock FILE...`, with every file that it is to have"
                out.error("LCK002", fault, span=spans[way], help=help)

        refuse(_faults(lock, figures))
        if not out.failed:
            spans = _spans(path, text, [("versions", name) for name in lock["versions"]])
            read_versions(lock["versions"], "versions", lambda name: spans["versions", name], out)
        if files and not out.failed:
            refuse(_files_fault(lock))
    out.raise_if_failed(AuditError)
    assert isinstance(lock, dict)
    return lock


def _spans(path: str, text: str, wanted: Sequence[Path]) -> dict[Path, Span]:
    """Where keys of a lock are written; what is not there, where it would be."""
    ways = {way[:length] for way in wanted for length in range(1, len(way) + 1)}
    places = json_places(text, ways)
    found = {}
    for way in wanted:
        known = next((way[:length] for length in range(len(way), 0, -1) if way[:length] in places), None)
        found[way] = Span(path, *((1, 1) if known is None else places[known]))
    return found


def versions_of(lock: Mapping[str, Any]) -> Versions:
    """What the lock's files were meant for."""
    return Versions(**lock["versions"])


def _robot(robot: RobotDynamics) -> dict[str, Any]:
    joints = {name: _joint(joint) for name, joint in robot.joints.items()}
    settings = {name: _rounded(value) for name, value in robot.settings.items()}
    record: dict[str, Any] = {"settings": settings}
    if robot.orders is not None:
        record["orders"] = {name: list(names) for name, names in robot.orders.items()}
    if robot.entries is not None:
        record["entries"] = {where: _rounded(value) for where, value in robot.entries.items()}
    if robot.by_key is not None:
        record["by_key"] = {
            name: [
                {"key": key, "value": _rounded(figure.value)}
                for key, figure in every
                if figure.value is not None
            ]
            for name, every in robot.by_key.items()
        }
    digest = _hash({**record, "joints": {name: joint["hash"] for name, joint in joints.items()}})
    return {"hash": digest, **record, "joints": joints}


def _joint(joint: JointDynamics) -> dict[str, Any]:
    """Figures that are known; the others are left out."""
    record: dict[str, Any] = {"control": joint.control}
    if joint.network is not None:
        record["network"] = joint.network
    if joint.axis is not None:
        record["axis"] = axis_text(joint.axis)
    for name, figure in joint.figures.items():
        if figure.value is not None:
            record[name] = _rounded(figure.value)
    return {"hash": _hash(record), **record}


def _rounded(value: float | str) -> float | str:
    """Nine digits; by way of twelve, so that noise beside a figure that people wrote is never at the edge."""
    if isinstance(value, str):
        return value
    if not math.isfinite(value):
        return "Infinity" if value > 0.0 else "-Infinity"
    return float(f"{float(f'{value:.12g}'):.9g}") + 0.0


def _hash(record: Mapping[str, Any]) -> str:
    text = json.dumps(record, sort_keys=True, ensure_ascii=True, separators=(",", ":"))
    return hashlib.sha256(text.encode("ascii")).hexdigest()[:_HASH]


def _dynamics(name: str, file: str, kind: FileKind, entry: Mapping[str, Any] | None) -> RobotDynamics:
    """A robot of a lock; without one, a robot without joints."""
    if entry is None:
        return RobotDynamics(name, file, kind, {})
    joints = {joint: _locked_joint(joint, figures, file) for joint, figures in entry["joints"].items()}
    orders = entry.get("orders")
    return RobotDynamics(
        name,
        file,
        kind,
        joints,
        entry["settings"],
        orders=None if orders is None else {key: tuple(names) for key, names in orders.items()},
        entries=entry.get("entries"),
        by_key=_locked_keys(entry, file),
    )


def _locked_keys(entry: Mapping[str, Any], file: str) -> dict[str, tuple[tuple[str, Figure], ...]] | None:
    if "by_key" not in entry:
        return None
    return {
        name: tuple((one["key"], Figure(float(one["value"]), "", Span(file), True)) for one in every)
        for name, every in entry["by_key"].items()
    }


def _locked_joint(name: str, entry: Mapping[str, Any], file: str) -> JointDynamics:
    place = Span(file)
    figures = {field: Figure(float(entry[field]), "", place, True) for field in FIELDS if field in entry}
    axis = axis_of(entry["axis"]) if "axis" in entry else None
    return JointDynamics(name, entry["control"], place, figures, entry.get("network"), axis=axis)


def axis_of(text: object) -> tuple[float, float, float] | None:
    """What `axis_text` wrote; None: it is none."""
    if not isinstance(text, str):
        return None
    try:
        x, y, z = map(float, text.split())
    except ValueError:
        return None
    return (x, y, z) if math.isfinite(x + y + z) else None


def _faults(lock: Mapping[str, Any], figures: bool) -> Sequence[tuple[Path, str]]:
    """What is wrong with a lock that has the right format, the first fault of each robot, by its path."""
    versions, files = lock.get("versions"), lock.get("files")
    if not isinstance(versions, dict) or not all(isinstance(value, str) for value in versions.values()):
        return [(("versions",), "`versions` is not as actspec writes it")]
    if not isinstance(files, dict):
        return [(("files",), "`files` is not as actspec writes it")]
    kinds = [kind.value for kind in FileKind]
    found: list[tuple[Path, str]] = []
    for name, entry in files.items():
        here = ("files", name)
        robots = entry.get("robots") if isinstance(entry, dict) else None
        if not _is_relative(name):
            found.append((here, f"{shortened(name)!r} is no relative path"))
        elif not isinstance(robots, dict) or entry.get("kind") not in kinds:
            found.append((here, f"the entry of {shortened(name)!r} is not as actspec writes it"))
        elif figures:
            for robot, record in robots.items():
                fault = _robot_fault(record)
                if fault is not None:
                    below, message = fault
                    way = (*here, "robots", robot, *below)
                    found.append((way, f"{shortened(name)}, {shortened(robot)}: {message}"))
    return found


def _files_fault(lock: Mapping[str, Any]) -> Sequence[tuple[Path, str]]:
    """What is wrong with the list of files. A lock of an older actspec has no hash of it, but never no files."""
    if "hash" in lock and lock["hash"] != _hash_of_files(lock["files"]):
        message = "the names of its files do not match their hash: an edit or a merge lost some or added some"
    elif not lock["files"]:
        message = "it has no files: an edit or a merge lost them"
    else:
        return []
    return [(("files",), message)]


def _hash_of_files(files: Iterable[str]) -> str:
    return _hash({"files": sorted(files)})


def _robot_fault(record: Any) -> tuple[Path, str] | None:
    """The path below the robot, and what is wrong there."""
    shape = "is not as actspec writes it"
    if not isinstance(record, dict) or not isinstance(record.get("joints"), dict):
        return ("joints",), shape
    settings = record.get("settings")
    if not isinstance(settings, dict) or not all(
        key in SETTING_NOUNS and (isinstance(value, str) or _is_figure(value))
        for key, value in settings.items()
    ):
        return ("settings",), shape
    beside = {key: record[key] for key in ("orders", "entries", "by_key") if key in record}
    if not _is_orders(beside.get("orders", {})):
        return ("orders",), shape
    entries = beside.get("entries", {})
    if not isinstance(entries, dict) or not all(map(_is_figure, entries.values())):
        return ("entries",), shape
    if not _is_by_key(beside.get("by_key", {})):
        return ("by_key",), shape
    hashes = {}
    for name, joint in record["joints"].items():
        texts = (joint.get("control"), joint.get("network", "")) if isinstance(joint, dict) else (None,)
        if not all(isinstance(text, str) for text in texts) or axis_of(joint.get("axis", "0 0 1")) is None:
            return ("joints", name), f"{shortened(name)} {shape}"
        figures = {key: value for key, value in joint.items() if key not in _TEXTS}
        wrong = next(
            (key for key, value in figures.items() if not (key in FIELDS and _is_figure(value))), None
        )
        if wrong is not None:
            return ("joints", name, wrong), f"{shortened(name)} {shape}"
        own = {key: value for key, value in joint.items() if key != "hash"}
        if _hash(own) != joint.get("hash"):
            message = f"the figures of {shortened(name)} do not match their hash: the lock has been edited"
            return ("joints", name), message
        hashes[name] = joint["hash"]
    if _hash({"settings": settings, **beside, "joints": hashes}) != record.get("hash"):
        return ("hash",), "the joints do not match their hash: the lock has been edited"
    return None


def _is_orders(value: object) -> bool:
    return isinstance(value, dict) and all(
        key in ORDERS and isinstance(names, list) and all(isinstance(name, str) for name in names)
        for key, names in value.items()
    )


def _is_by_key(value: object) -> bool:
    return isinstance(value, dict) and all(
        name in FIELDS
        and isinstance(every, list)
        and all(
            isinstance(one, dict)
            and set(one) == {"key", "value"}
            and isinstance(one["key"], str)
            and _is_figure(one["value"])
            for one in every
        )
        for name, every in value.items()
    )


def _is_figure(value: object) -> bool:
    if isinstance(value, bool):
        return False
    if isinstance(value, int):
        return abs(value) <= _MOST
    return isinstance(value, float) or value in ("Infinity", "-Infinity")


def _is_relative(name: object) -> bool:
    """Whether a name stays a path from the lock; only Windows takes `a:b` for a drive and splits at a backslash."""
    if not isinstance(name, str) or not name or "\0" in name or name.startswith("/"):
        return False
    if name[1:3] == ":/":
        return False
    return os.sep == "/" or not ("\\" in name or name[1:2] == ":")
