"""From the files that a user names to the readings of one robot."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

from actspec.diagnostics import (
    AuditError,
    Collector,
    Diagnostic,
    Span,
    listed,
    many,
    nearest,
    one_line,
    shell_word,
)
from actspec.draft.deploy_lists import lists_of, of_this_robot, remark_of
from actspec.draft.environment import are_one, in_environments, written_once
from actspec.draft.including import as_part, whole_of
from actspec.draft.sources import RobotReading, stated
from actspec.draft.unread import check_drives, with_drives
from actspec.draft.unselected import (
    misspelt,
    not_listed,
    robot_file_of,
    selected_twice,
    unselected,
)
from actspec.lift import Lifted, lift
from actspec.lift.config import asset_of, file_of, leaves_to_model, not_read
from actspec.readings.artifact import (
    ActuatorGroup,
    Artifact,
    FileKind,
    FileReading,
    Framework,
    RobotConfig,
)
from actspec.readings.dict_keys import plain_name
from actspec.readings.joint_lists import (
    JointList,
    differ_by_ending,
    environment_of,
    named_joints,
    names_of,
    patterns_of,
)
from actspec.readings.joint_names import joint_names, matching
from actspec.readings.motor_names import NAMELESS
from actspec.readings.named import PendingFiles, named_as_run
from actspec.readings.pair import pair
from actspec.readings.read import PYTHON, read_file
from actspec.readings.versions import Versions
from actspec.robot.submodules import not_checked_out, of_missing
from actspec.robot.view import JointView
from actspec.units import format_quantity

_REFUSED = "MuJoCo refuses the model: "

_PLUGIN = re.compile(r"\bplugin \S+ not found")
_ROBOT_FILE = re.compile(r"\.(usd[acz]?|urdf|xml)$", re.IGNORECASE)
_DESCRIPTORS = "Isaac Lab's IO_descriptors.yaml, "

_ROBOTS = (FileKind.MJCF, FileKind.URDF)

_HOLDERS = ("robot", "robot_cfg")
"""Fields of an environment that have its robot."""


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
            message, help = "is a folder: name the files", named_as_run(path, path)
            if submodule := not_checked_out(os.path.normpath(path), os.path.join(path, "*")):
                message, help = str(submodule), submodule.help
            out.error("DRF004", message, span=Span(path), help=help)
        elif not os.path.exists(path):
            broken = os.path.islink(path)
            message, help = of_missing("there is no such file", path, _near(path))
            if broken:
                message, help = "is a link to no file", None
            out.error("DRF004", message, span=Span(path), help=help)
    out.raise_if_failed(AuditError)
    programs = tuple(dict.fromkeys(path for path in paths if path.lower().endswith(PYTHON)))
    read = partial(read_file, named=programs)
    with PendingFiles(list(dict.fromkeys(paths)), keep_matrices=False, read=read) as pending:
        readings = pending.finish()
    for reading in readings:
        _check(reading, out)
    out.raise_if_failed(AuditError)
    every = [artifact for reading in readings for artifact in reading.artifacts]
    artifacts = _chosen(every, robot, out)
    out.raise_if_failed(AuditError)
    artifacts = with_drives(list(_one_a_file(artifacts, robot, out)))
    out.raise_if_failed(AuditError)
    check_drives(artifacts, out)
    out.raise_if_failed(AuditError)
    names = None if named is None else named_joints(artifacts, named, out)
    out.raise_if_failed(AuditError)
    if named is not None and (environment := environment_of(named)) is not None:
        artifacts.append(environment)
    fitting = list(of_this_robot(artifacts, () if names is None else names.joints, out))
    artifacts, trained = in_environments(fitting, every, robot)
    listed_in = every if named is not None or any(artifact.robot for artifact in artifacts) else []
    passed_over = {one.span for artifact in listed_in for one in lists_of(artifact.config).values()}
    parts = list(_lifted(artifacts, named, names, versions, out))
    remarks = [
        remark or (remark_of(part) if listed_in else "")
        for part, remark in zip(artifacts, trained, strict=True)
    ]
    parts = [_remarked(part, remark) for part, remark in zip(parts, remarks, strict=True)]
    out.raise_if_failed(AuditError)
    files = {reading.path: tuple(file.path for file in reading.files) for reading in readings}
    said = [*out, *(item for reading in readings for item in reading.diagnostics)]
    said += _once(parts)
    # The remark on all lists of a file says it once.
    said = [item for item in said if item.code != NAMELESS or item.span not in passed_over]
    found = zip(parts, artifacts, strict=True)
    return tuple(RobotReading(part, a, files.get(a.path, ())) for part, a in found), tuple(
        dict.fromkeys(said)
    )


def _once(parts: Sequence[Lifted]) -> Iterator[Diagnostic]:
    """What the parts have to say; of a robot that an environment of another file imports, not once more.

    What is said of several figures for one cause at one place is said of them together.
    """
    told = set[tuple[str, Span | None]]()
    for part in parts:
        own = [d for d in part.actuators.diagnostics if (d.code, d.span) not in told]
        causes: dict[Diagnostic, list[str]] = {}
        for item in own:
            causes.setdefault(replace(item, where=""), []).append(item.where)
        yield from (replace(item, where=listed(dict.fromkeys(wheres), 4)) for item, wheres in causes.items())
        told.update((d.code, d.span) for d in own if d.span is not None and d.span.line)


def _remarked(part: Lifted, remark: str) -> Lifted:
    """A robot with a remark on the whole of it."""
    return replace(part, notes={**part.notes, "": (remark, *part.notes.get("", ()))}) if remark else part


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
            help = whole_of(reading) or reading.help
            out.error("DRF004", f"cannot be read: {reading.reason}", span=reading.place, help=help)
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
                f"MuJoCo refuses the file, and so would a compile: {artifact.text_only.replace(_REFUSED, '', 1)}",
                span=artifact.refused_at or place,
                help=whole_of(reading) or f"{_mend(artifact.text_only)}; `actspec audit` reads it as it is",
            )
        elif artifact.is_part and (told := as_part(reading.path)):
            out.add(told)


def _mend(reason: str) -> str:
    """What to do with a file that MuJoCo refuses for a reason."""
    if _PLUGIN.search(reason):
        return (
            "MuJoCo comes without that plugin: put its library into the folder `plugin` of the mujoco package"
        )
    return "correct it first"


def _chosen(artifacts: Sequence[Artifact], name: str | None, out: Collector) -> list[Artifact]:
    """What the files say of the robot that is meant.

    A file with one robot is about it, whatever it calls it; of a file with several, what belongs to those files.
    """
    artifacts = [
        part
        for part in artifacts
        if part.name == name or not any(_is_base(part, other) for other in artifacts)
    ]
    robots = pair(artifacts)
    parts = [(robot, artifacts[index]) for robot in robots for index in robot.artifacts]
    files = [part.path for _, part in parts]
    single = {id(part) for _, part in parts if files.count(part.path) == 1}
    if name is None:
        kinds = {robot: {id(part) in single for home, part in parts if home is robot} for robot in robots}
        paired = [robot for robot in robots if True in kinds[robot]]
        meant = [robot for robot in paired if False in kinds[robot]] or list(robots)
    else:
        meant = [r for r in robots if r.name == name or any(artifacts[i].name == name for i in r.artifacts)]
        if not meant:
            names = dict.fromkeys(one_line(part.name) for _, part in parts)
            help = f"they have {listed(names, 20)}"
            out.error("DRF007", f"no file has a robot {name!r}", where="--robot", help=help)
    return [part for robot, part in parts if id(part) in single or robot in meant]


def _one_a_file(parts: Sequence[Artifact], name: str | None, out: Collector) -> Iterator[Artifact]:
    """The parts without those of a file that describe the robot once more, otherwise.

    A configuration without actuators (an environment's steps and ranges) goes with the one that has them.
    """
    by_file: dict[str, list[Artifact]] = {}
    for part in parts:
        by_file.setdefault(part.path, []).append(part)
    for path, own in by_file.items():
        full = [part for part in own if part.config is None or part.config.groups]
        if name is None:
            # A spare motor is no robot beside one.
            spare = [part for part in full if _is_motor_alone(part)]
            full = [part for part in full if part not in spare] or full
            own = [part for part in own if part in full or part not in spare]
        named = [part for part in full if part.name == name]
        distinct: list[Artifact] = []
        for part in named or full:
            if not any(are_one(part, other) for other in distinct):
                distinct.append(part)
        if len(distinct) > 1 and name is None:
            distinct = _taken(distinct, [part for part in parts if part.path != path])
        if len(distinct) > 1:
            names = listed([one_line(part.name) for part in full if part in distinct], 20)
            message = f"describes {len(distinct)} robots"
            out.error("DRF007", message, span=Span(path), help=f"name one with --robot: {names}")
        yield from distinct
        yield from (part for part in own if part not in full)


def _taken(robots: list[Artifact], others: Sequence[Artifact]) -> list[Artifact]:
    """The one of a file's robots that environments of other files import, from that file or from where nobody looked;
    all of them where that is not one."""
    configs = [one for one in others if one.config is not None]
    named = {
        name for one in configs if one.config for at, name in one.config.elsewhere.items() if at in _HOLDERS
    }
    found = [
        robot
        for robot in robots
        if robot.config is not None and (robot.name in named or any(are_one(robot, one) for one in configs))
    ]
    return found if len(found) == 1 else robots


def _is_motor_alone(part: Artifact) -> bool:
    """Whether a configuration is one actuator cfg that a name of the file has."""
    config = part.config
    if config is None or config.settings or len(config.groups) != 1:
        return False
    return config.groups[0].name == config.name


def _is_base(part: Artifact, other: Artifact) -> bool:
    """Whether a configuration is only what another one of its file was made of: private, or without an asset, or what
    the function that makes the other one would make without arguments."""
    one, two = part.config, other.config
    if one is None or two is None or part.path != other.path:
        return False
    if _is_made_by(two, one):
        return True
    if part.name.startswith("_") and not other.name.startswith("_") and _written(one) & _written(two):
        # The copy may get entries, or lose some.
        return True
    return written_once(one, two) and "model" not in one.settings and "model" in two.settings


def _is_made_by(robot: RobotConfig, function: RobotConfig) -> bool:
    """Whether a robot is made by a function of its file, in which its groups are written.

    Of a task the figures without arguments are those of its training.
    """
    lines = [group.span.line for group in function.groups]
    if not function.by_call or robot.by_call or function.randomize or "decimation" in function.settings:
        return False
    return written_once(robot, function) and function.span.line <= min(lines) <= max(lines) < robot.span.line


def _written(config: RobotConfig) -> set[tuple[str, Span]]:
    """Groups and asset of a configuration, with where they are written."""
    model = config.settings.get("model")
    return {(g.name, g.span) for g in config.groups} | ({("", model.span)} if model is not None else set())


def _lifted(
    artifacts: Sequence[Artifact],
    named: str | None,
    names: JointList | None,
    versions: Versions,
    out: Collector,
) -> Iterator[Lifted]:
    """Each part on the joints of the robot file, else on those that are named, or that another part names."""
    model = next((a for kind in _ROBOTS for a in artifacts if a.kind is kind), None)
    joints: Sequence[JointView | str] = ()
    if model is not None and model.robot is not None:
        joints = model.robot.scalar_joints
    of, follow = None if model is None else one_line(os.path.basename(model.path)), {}
    if names is not None:
        joints = names.joints
        # What only names the joints says nothing of who drives them: the configuration does, of its USD.
        follow = {j.name: j.mimic for j in joints if not isinstance(j, str) and j.mimic is not None}
        joints = [j if isinstance(j, str) else replace(j, mimic=None) for j in joints]
        of = "--joints"
    elif model is None:
        _check_names(artifacts, out)
    for artifact in artifacts:
        config, others = artifact.config, [other for other in artifacts if other is not artifact]
        beside = next((names for names in map(joint_names, others) if names), None)
        listed_here = None if joints or beside or artifact.kind is not FileKind.CFG else joint_names(artifact)
        beside = beside or listed_here
        same = [o.config for o in others if o.config and config and o.config.framework is config.framework]
        step = next((other.physics_dt for other in same if other.physics_dt is not None), None)
        told = config is not None and step is None and config.physics_dt is None
        if told and model is not None and not any(o.config and o.config.physics_dt for o in others):
            # The spec has the robot file's step then, and its steps are the ones that count.
            step = _stated_step(model)
        part = lift(artifact, joints or beside, versions=versions, physics_dt=step)
        if told and step is not None and any(j.delay is not None for j in part.actuators.joints):
            source = one_line(os.path.basename(model.path)) if model is not None else ""
            part = _remarked(
                part, f"delays count the step of {source}, {format_quantity(step, 's')}: no other is stated"
            )
        if listed_here:
            part = _remarked(
                part, f"the names of the {many(len(listed_here), 'joint')} are from its joint_sdk_names"
            )
        if names is not None and config is not None and config.groups:
            kinds = "names" if isinstance(next(iter(joints), ""), str) else "names, kinds and ranges"
            source = one_line(names.of)
            how = "".join(f", {one_line(text)}" for text in (names.changed, names.why) if text)
            said = f"the {kinds} of the {many(len(joints), 'joint')} are from {source} (--joints){how}"
            part = _remarked(part, said)
            notes = dict(part.notes)
            for joint in (j.joint for j in part.actuators.joints if j.joint in follow):
                also = f"follows '{one_line(follow[joint])}' in {source} (mimic), and the configuration drives it too"
                notes[joint] = (*notes.get(joint, ()), also)
            part = replace(part, notes=notes)
        if config is not None:
            own = [
                *(joint.joint for joint in part.actuators.joints),
                *(item.joint for item in part.left_alone),
            ]
            typed = named is not None and not os.path.exists(named)
            every_name = names_of(joints) or beside or own
            lost = list(unselected(config, every_name, of, typed))
            lost += selected_twice(config, every_name)
            # A list may be typed, too; a robot's file has its joints as they are called.
            listed_alone = named is not None and all(isinstance(joint, str) for joint in joints)
            if listed_alone and not lost:
                lost += misspelt(config, names_of(joints))
            if model is None and named is not None and config.framework is Framework.DEPLOY:
                lost += not_listed(config, names_of(joints))
            more = (*part.actuators.diagnostics, *lost)
            part = replace(part, actuators=replace(part.actuators, diagnostics=more))
        if config is not None and _is_left_alone(
            config, part, names_of(joints) or listed_here or _own_names(config, others)
        ):
            _check_classes(artifact, config, part, model, out)
        elif model is not None and artifact is not model:
            _check_joints(artifact, part, model, joints, out)
        yield part


def _stated_step(model: Artifact) -> float | None:
    """The physics step that a robot file states [s]; None where it is the engine's default."""
    step = lift(model).actuators.physics_dt
    return step.value if stated(step) else None


def _own_names(config: RobotConfig, others: Sequence[Artifact]) -> list[str]:
    """The joints of a configuration that names each, and that no other file with drives stands beside."""
    if any(other.config is not None and other.config.groups for other in others):
        return []
    names = [plain_name(config.framework, pattern) for pattern in patterns_of(config)]
    known = [name for name in names if name is not None]
    return known if len(known) == len(names) else []


def _is_left_alone(config: RobotConfig, part: Lifted, names: Sequence[str]) -> bool:
    """Whether a configuration selects joints of the robot, and none of them can go into a group."""
    return not part.actuators.joints and any(
        matching(config.framework, pattern, names) for pattern in patterns_of(config)
    )


def _check_classes(
    artifact: Artifact, config: RobotConfig, part: Lifted, model: Artifact | None, out: Collector
) -> None:
    """A configuration without a joint for a group: beside it the robot file alone would speak."""
    of_model = [leaves_to_model(config.framework, group) for group in config.groups]
    if model is not None and all(of_model):
        return
    unread: dict[str, list[ActuatorGroup]] = {}
    for group in config.groups:
        if group.unread is not None:
            unread.setdefault(group.unread, []).append(group)
    files = listed(map(file_of, unread))
    # Several classes of one file lack one thing.
    alike = {not_read([one]): not_read(groups) for groups in unread.values() for one in groups}
    why = dict.fromkeys(alike.get(item.why, item.why) for item in part.left_alone)
    folder = os.path.dirname(artifact.path)
    here = f"below {one_line(folder)}" if folder else f"in the folder of {one_line(artifact.path)}"
    out.error(
        "DRF002",
        f"none of the joints of {one_line(artifact.name)} can go into a group: {listed(why)}",
        span=Span(artifact.path),
        help=f"import the configuration that it was trained with (.py) in its place, where {files} is"
        if any(group.of_run for group in config.groups)
        else f"put {files} {here}, or import {one_line(artifact.path)} where its package is"
        if files
        else f"name {robot_file_of(config)}"
        if model is None and any(of_model)
        else "leave this file out: the robot's MJCF or URDF alone makes a spec, in which you state what drives it",
    )


def _check_joints(
    artifact: Artifact, part: Lifted, model: Artifact, joints: Sequence[JointView | str], out: Collector
) -> None:
    """What shares no joint with the robot file is another robot's."""
    mine = [joint.joint for joint in part.actuators.joints]
    here = names_of(joints)
    theirs = [*mine, *(item.joint for item in part.left_alone)] if artifact.robot is not None else mine
    if not set(theirs) & set(here) and (artifact.config is None or artifact.config.groups):
        names = mine if artifact.config is None else [*patterns_of(artifact.config)]
        ending = ""
        if artifact.config is not None and differ_by_ending([artifact.config], here):
            ending = (
                "; they differ by their ending alone: a configuration has the names of its USD. Name the file by "
                f"--joints {shell_word(model.path)}, which takes them as the configuration has them"
            )
        out.error(
            "DRF008",
            f"{one_line(artifact.name)} shares no joint with {model.path}",
            span=Span(artifact.path),
            help=f"there: {listed(map(one_line, names), 4)}; here: {listed(map(one_line, here), 4)}{ending}",
        )


def _urdf_of(usd: str) -> str | None:
    """The URDF of a USD's name that is beside it, or in a folder `urdf` beside its own."""
    folder, name = os.path.split(usd)
    stem, ending = os.path.splitext(name)
    if "\0" in usd or not ending.lower().startswith(".usd"):
        return None
    beside = (os.path.join(folder, at, f"{stem}.urdf") for at in ("", os.path.join(os.pardir, "urdf")))
    return next((os.path.normpath(path) for path in beside if os.path.isfile(path)), None)


def _check_names(artifacts: Sequence[Artifact], out: Collector) -> None:
    """Where patterns select the joints, some file names these."""
    if any(artifact.kind is FileKind.DEPLOY or joint_names(artifact) for artifact in artifacts):
        return
    for artifact in artifacts:
        config = artifact.config
        groups = () if config is None else config.groups
        patterns = [
            pattern
            for group in groups
            for pattern in group.joints or ()
            if config is not None and plain_name(config.framework, pattern) is None
        ]
        if patterns:
            asset = asset_of(config) if config is not None else None
            model = config.model if config is not None else None
            if model and not re.search(r"[{}]|://", model):
                model = os.path.normpath(model)
            urdf = _urdf_of(model) if model else None
            first = (
                f"{one_line(urdf)} too, of which its USD may be made"
                if urdf
                else "the robot's MJCF or URDF too"
            )
            where = f": they stand in {one_line(model)}" if model and _ROBOT_FILE.search(model) else ""
            listing = "" if config is None or config.framework is Framework.LEGGED_GYM else _DESCRIPTORS
            out.error(
                "DRF009",
                f"{one_line(artifact.name)} selects its joints by patterns ({listed(map(one_line, patterns))}), and "
                f"no file names them{where}",
                span=Span(artifact.path),
                help=f"name {robot_file_of(config)}"
                if config is not None and asset
                else f"name {first}, or its joints: --joints FILE ({listing}a URDF, any file that "
                "names them) or --joints a,b,c",
            )
