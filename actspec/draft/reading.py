"""From the files that a user names to the readings of one robot."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

from actspec.diagnostics import AuditError, Collector, Diagnostic, Span, listed, nearest, one_line
from actspec.draft.sources import RobotReading
from actspec.ir import JointKind
from actspec.lift import Lifted, LiftedRobot, lift, lift_files
from actspec.lift.config import asset_of
from actspec.readings.artifact import FileKind, FileReading, Framework
from actspec.readings.joint_lists import fitting, joint_lists
from actspec.readings.versions import Versions
from actspec.robot.view import JointView

_LIVE = re.compile(r"[.^$*+?{}\[\]|()]")
"""What makes a name a pattern for more."""
_ESCAPED = re.compile(r"\\.", re.DOTALL)

_USD = re.compile(r"\.usd[acz]?$", re.IGNORECASE)

_ROBOTS = (FileKind.MJCF, FileKind.URDF)


def read_robot_files(
    paths: Sequence[str], robot: str | None, versions: Versions, named: str | None = None
) -> tuple[tuple[RobotReading, ...], tuple[Diagnostic, ...]]:
    """Read files of one robot.

    Args:
        paths: The files.
        robot: Name of the robot where a file has several; None: there is one only.
        versions: What the files are meant for.
        named: A file or list that names the joints where no robot file does; None: there is none.

    Returns: One reading a robot description, in the order of the files, and what the readers have to say.

    Raises: AuditError: a file cannot be read, describes no robot or another one, or nobody can tell which.
    """
    out = Collector()
    for path in paths:
        if os.path.isdir(path):
            out.error("DRF004", "is a folder: name the files", span=Span(path))
        elif not os.path.exists(path):
            broken = os.path.islink(path)
            message = "is a link to no file" if broken else "there is no such file"
            out.error("DRF004", message, span=Span(path), help=None if broken else _near(path))
    out.raise_if_failed(AuditError)
    found = lift_files(list(dict.fromkeys(paths)), versions=versions)
    for reading in found.readings:
        _check(reading, out)
    out.raise_if_failed(AuditError)
    chosen = _chosen(found.robots, robot, out)
    out.raise_if_failed(AuditError)
    parts = list(_one_a_file(chosen, robot, out))
    out.raise_if_failed(AuditError)
    parts = list(_fitted(parts, versions, out))
    if named is not None:
        parts = list(_on_named(parts, named, versions, out))
    else:
        _check_names(parts, out)
    out.raise_if_failed(AuditError)
    files = {reading.path: tuple(file.path for file in reading.files) for reading in found.readings}
    said = [item for reading in found.readings for item in reading.diagnostics]
    said += [item for part in parts for item in part.actuators.diagnostics]
    return tuple(_reading(part, files) for part in parts), tuple(dict.fromkeys(said))


def _near(path: str) -> str | None:
    """The file of the folder that may be meant."""
    folder, name = os.path.split(path)
    try:
        guess = nearest(name, sorted(set(os.listdir(folder or os.curdir)) - {name}))
    except (OSError, ValueError):
        return "its folder does not exist"
    return None if guess is None else f"did you mean {os.path.join(folder, guess)!r}?"


def _check(reading: FileReading, out: Collector) -> None:
    """A file that was named is of use, or says why not."""
    place = Span(reading.path)
    if not reading.readable:
        errors = [item for item in reading.diagnostics if item.span is not None and item.span.line]
        if errors:
            for item in errors:
                out.add(item)
        else:
            out.error("DRF004", f"cannot be read: {reading.reason}", span=place)
    elif reading.kind is FileKind.SPEC:
        out.error(
            "DRF005", "is a spec already", span=place, help="`actspec compile` writes configurations from it"
        )
    elif not reading.artifacts:
        out.error(
            "DRF005",
            "describes no robot",
            span=place,
            help="name an MJCF, URDF, configuration or deploy file",
        )
    for artifact in reading.artifacts:
        if artifact.text_only is not None and artifact.kind is FileKind.MJCF:
            out.error(
                "DRF006",
                f"MuJoCo refuses the file, and so would a compile: {artifact.text_only}",
                span=place,
                help="correct it first; `actspec audit` reads it as it is",
            )


def _chosen(robots: Sequence[LiftedRobot], name: str | None, out: Collector) -> list[Lifted]:
    """What the files say of the robot that is meant.

    A file with one robot is about it, whatever it calls it; of a file with several, what belongs to those files.
    """
    parts = [(robot, part) for robot in robots for part in robot.parts]
    files = [_path(part) for _, part in parts]
    single = {id(part) for _, part in parts if files.count(_path(part)) == 1}
    if name is None:
        paired = [robot for robot in robots if any(id(part) in single for part in robot.parts)]
        meant = [r for r in paired if any(id(part) not in single for part in r.parts)] or list(robots)
    else:
        meant = [r for r in robots if r.name == name or any(_name(part) == name for part in r.parts)]
        if not meant:
            names = dict.fromkeys(one_line(_name(part)) for _, part in parts)
            out.error(
                "DRF007",
                f"no file has a robot {name!r}",
                where="--robot",
                help=f"they have {listed(names, 20)}",
            )
    return [part for robot, part in parts if id(part) in single or robot in meant]


def _one_a_file(parts: Sequence[Lifted], name: str | None, out: Collector) -> Iterator[Lifted]:
    """The parts without those of a file that describe the robot once more, otherwise.

    A configuration without actuators (an environment's steps and ranges) goes with the one that has them.
    """
    by_file: dict[str, list[Lifted]] = {}
    for part in parts:
        by_file.setdefault(_path(part), []).append(part)
    for path, own in by_file.items():
        full = [
            part for part in own if part.artifact is None or part.artifact.config is None or _groups(part)
        ]
        named = [part for part in full if _name(part) == name]
        distinct = {_groups(part): part for part in reversed(named or full)}
        if len(distinct) > 1:
            out.error(
                "DRF007",
                f"describes {len(distinct)} robots",
                span=Span(path),
                help=f"name one with --robot: {listed([one_line(_name(part)) for part in full], 20)}",
            )
        yield from distinct.values()
        yield from (part for part in own if part not in full)


def _groups(part: Lifted) -> tuple[object, ...]:
    """What tells two configurations of one file apart: the places of their groups; () for none."""
    config = part.artifact.config if part.artifact is not None else None
    if config is None:
        return (part.artifact.name,) if part.artifact is not None else ()
    return tuple((group.name, group.cls, group.span) for group in config.groups)


def _fitted(parts: Sequence[Lifted], versions: Versions, out: Collector) -> Iterator[Lifted]:
    """The parts on the joints of the robot file; what shares no joint with it is another robot's."""
    model = next((p for kind in _ROBOTS for p in parts if p.artifact and p.artifact.kind is kind), None)
    if model is None or model.artifact is None or model.artifact.robot is None:
        yield from parts
        return
    joints = [j for j in model.artifact.robot.joints if j.kind in (JointKind.HINGE, JointKind.SLIDE)]
    step = next(
        (c.physics_dt for p in parts if p.artifact and (c := p.artifact.config) and c.physics_dt is not None),
        None,
    )
    for part in parts:
        artifact = part.artifact
        if artifact is None or part is model:
            yield part
            continue
        if artifact.config is not None and artifact.config.groups:
            part = lift(artifact, joints, versions=versions, physics_dt=step)
        mine = {joint.joint for joint in part.actuators.joints}
        if artifact.robot is not None:
            mine |= {item.joint for item in part.left_alone}
        if not mine & {joint.name for joint in joints} and (artifact.robot is not None or _groups(part)):
            out.error(
                "DRF008",
                f"{one_line(artifact.name)} shares no joint with {model.artifact.path}",
                span=Span(artifact.path),
                help=_other_names(part, joints),
            )
        yield part


def _on_named(parts: Sequence[Lifted], named: str, versions: Versions, out: Collector) -> Iterator[Lifted]:
    """The parts with the joints of the file or list that names them."""
    artifacts = [part.artifact for part in parts if part.artifact is not None]
    robot = next((artifact for artifact in artifacts if artifact.robot is not None), None)
    if robot is not None:
        message = "not needed: the robot file names the joints"
        out.error("DRF011", message, span=Span(robot.path), where="--joints", help="leave --joints out")
    configs = [
        a.config for a in artifacts if a.config is not None and a.config.framework is not Framework.DEPLOY
    ]
    joints = fitting(joint_lists(named), configs)
    if not joints and robot is None:
        patterns = [one_line(p) for config in configs for group in config.groups for p in group.joints or ()]
        message = f"none of its joints is selected by {listed(patterns) or 'the files'}"
        out.error("DRF011", message, span=Span(one_line(named)), where="--joints")
    for part in parts:
        if part.artifact is None or part.artifact.config is None or not part.artifact.config.groups:
            yield part
            continue
        part = lift(part.artifact, joints, versions=versions)
        kinds = "names, kinds and ranges" if not isinstance(next(iter(joints), ""), str) else "names"
        source = os.path.basename(named) if os.path.exists(named) else "the list"
        said = f"the {kinds} of the {len(joints)} joints are from {one_line(source)} (--joints)"
        yield replace(part, notes={**part.notes, "": (said, *part.notes.get("", ()))})


def _check_names(parts: Sequence[Lifted], out: Collector) -> None:
    """Where patterns select the joints, some file names these."""
    artifacts = [part.artifact for part in parts if part.artifact is not None]
    if any(artifact.robot is not None or artifact.kind is FileKind.DEPLOY for artifact in artifacts):
        return
    for artifact in artifacts:
        config = artifact.config
        groups = () if config is None else config.groups
        patterns = [
            pattern
            for group in groups
            for pattern in group.joints or ()
            if (config is not None and config.framework is Framework.LEGGED_GYM)
            or _LIVE.search(_ESCAPED.sub("", pattern))
        ]
        if patterns:
            asset = asset_of(config) if config is not None else None
            usd = config.settings.get("model") if config is not None else None
            where = (
                f": they stand in {one_line(str(usd.value))}" if usd and _USD.search(str(usd.value)) else ""
            )
            out.error(
                "DRF009",
                f"{one_line(artifact.name)} selects its joints by patterns ({listed(map(one_line, patterns))}), and "
                f"no file names them{where}",
                span=Span(artifact.path),
                help=f"name {one_line(asset)} too, which it reads"
                if asset
                else "name the robot's MJCF or URDF too, or its joints: --joints FILE (Isaac Lab's "
                "IO_descriptors.yaml, a URDF, any file that names them) or --joints a,b,c",
            )


def _other_names(part: Lifted, joints: Sequence[JointView]) -> str:
    config = part.artifact.config if part.artifact is not None else None
    theirs = [joint.joint for joint in part.actuators.joints]
    if config is not None:
        theirs = [pattern for group in config.groups for pattern in group.joints or ()]
    return f"there: {listed(map(one_line, theirs), 4)}; here: {listed([one_line(j.name) for j in joints], 4)}"


def _reading(part: Lifted, files: dict[str, tuple[str, ...]]) -> RobotReading:
    artifact = part.artifact
    assert artifact is not None
    framework = artifact.config.framework if artifact.config is not None else None
    return RobotReading(
        part, artifact.kind, artifact.path, artifact.name, framework, files.get(artifact.path, ())
    )


def _name(part: Lifted) -> str:
    return part.artifact.name if part.artifact is not None else part.actuators.robot


def _path(part: Lifted) -> str:
    return part.artifact.path if part.artifact is not None else ""
