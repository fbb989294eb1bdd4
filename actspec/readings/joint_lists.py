"""Names of joints alone, from a list or any file that has them: for configurations whose joints stand in a USD."""

from __future__ import annotations

import ast
import itertools
import math
import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TypeAlias

import yaml

from actspec.diagnostics import AuditError, Collector, Span, listed, one_line
from actspec.files import FAULTS, read_regular, why
from actspec.readings.artifact import Artifact, FileKind, Framework, RobotConfig, Setting
from actspec.readings.deploy import NAMES
from actspec.readings.deploy_motors import SDK_NAMES
from actspec.readings.motor_names import names_wanted
from actspec.readings.pair import joint_names, matching
from actspec.readings.python.source import MAX_BYTES, UnreadableError, parse
from actspec.readings.read import MOST_YAML_BYTES, YAML, PendingFiles
from actspec.readings.yaml_nodes import MOST_STEPS, Unfit, compose
from actspec.robot.view import JointView

Joints: TypeAlias = "tuple[JointView | str, ...]"
"""Joints in the file's order; of a robot file with kind and range, else names alone."""

_USD = (".usd", ".usda", ".usdc", ".usdz")
_ROBOT_FILES = (".xml", ".urdf", ".mjcf", ".xacro", ".py")
_XML = re.compile(rb"(?:\xef\xbb\xbf)?\s*<")
_ENDING = "_joint"
"""That USD files of robots leave out, or have, where the URDF is the other way round."""
_NO_NAME = re.compile(r"[,;\s]+")
_COMMENT = re.compile(r"#.*")
_NUMBERED = re.compile(r"^[ \t]*(?:[-*][ \t]+)?(?:\d+[:.)][ \t]+)?", re.MULTILINE)
"""Before a name in a list of lines: a dash, a number."""
_PRINTED = re.compile(r"\s*(?:\[[A-Z]+\]:?\s+)?(?:[A-Za-z][\w ]*[:=])?\s*\[([^\[\]]*)\]\s*")
"""A list as Python prints it, alone or behind words: `[INFO]: Joint names: ['hip', 'knee']`, as Isaac Lab logs it."""
_QUOTED = re.compile(r"(['\"])(.*)\1")
_NAME_KEYS = ("name", "joint", "joint_name", "joint name", "dof_name", "dof name")
"""What the name of a joint is called in a table, or in a list of mappings."""
_NO_JOINT = ("", "t", "time", "timestamp", "index", "step")
"""Columns of a recording that are no joint's."""
_SIGNAL_ENDS = re.compile(r"(.+)_(?:pos|position|vel|velocity|torque|tau)")
"""A column of one joint's signal, `hip_pos`."""
_SIGNALS = ("command", "position", "velocity", "torque", "pos", "vel", "q", "qd", "tau")
_CONSTANT = re.compile(r"(?:^|_)joint_names$", re.IGNORECASE)
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_PATTERN = re.compile(r"[\\*+?|()^$\[\]{}]")
_HELP = (
    "a URDF, an MJCF, IO_descriptors.yaml of Isaac Lab, a deploy file, a text with one name a line, a CSV with a "
    "column `name`, or the names themselves: --joints a,b,c"
)


def joint_lists(text: str) -> tuple[Joints, ...]:
    """The lists of joints that an argument names, the first one first; no name twice in a list.

    Args:
        text: A file, or names with commas between them.

    Raises:
        AuditError: there is no such file, or it names no joints.
    """
    lower = text.lower()
    known = (*_ROBOT_FILES, ".json", ".txt", ".csv", ".list", *YAML, *_USD)
    if not os.path.exists(text) and not lower.endswith(known) and "/" not in text:
        return (_distinct(text, text),)
    if not os.path.exists(text):
        raise _refusal("there is no such file", text, _HELP)
    if lower.endswith(_USD):
        help = f"{_HELP}. In Isaac Lab `print(robot.joint_names)` prints them"
        raise _refusal("USD is not read for names of joints", text, help)
    if lower.endswith((*YAML, ".json")):
        found = tuple(_named(_data(text), text))
    elif os.path.isdir(text) or lower.endswith(_ROBOT_FILES) or _XML.match(_data(text)):
        found = tuple(_of_constant(text)) or tuple(_of_files(text))
    else:
        lines = _COMMENT.sub("", _data(text).decode("utf-8-sig", "replace"))
        column = _column(lines, text)
        found = (_distinct(_listed(lines, text) if column is None else "\n".join(column), text),)
    if not found:
        raise _refusal("no list of joint names is in it", text, _HELP)
    return found


def environment_of(text: str) -> Artifact | None:
    """The steps that Isaac Lab's IO_descriptors.yaml states of the environment, as a configuration without groups.

    Args:
        text: As of `joint_lists`, which has read it; None where it states no physics step.
    """
    if not os.path.isfile(text) or not text.lower().endswith((*YAML, ".json")):
        return None
    settings = {}
    for name, node in _entries(_entry(compose(_data(text)), "scene")):
        if name in ("physics_dt", "decimation") and (number := _number(node)) is not None:
            mark = node.start_mark
            settings[name] = Setting(number, Span(text, mark.line + 1, mark.column + 1))
    name = os.path.splitext(os.path.basename(text))[0]
    config = RobotConfig(Framework.ISAACLAB, name, Span(text), (), settings)
    return Artifact(text, FileKind.CFG, name, config=config) if "physics_dt" in settings else None


def _entries(node: yaml.Node | None) -> list[tuple[str, yaml.Node]]:
    return (
        [(str(key.value), value) for key, value in node.value] if isinstance(node, yaml.MappingNode) else []
    )


def _entry(node: yaml.Node | None, name: str) -> yaml.Node | None:
    return next((value for key, value in _entries(node) if key == name), None)


def _number(node: yaml.Node) -> float | None:
    """A number above 0 that is written as one."""
    if node.tag not in ("tag:yaml.org,2002:float", "tag:yaml.org,2002:int"):
        return None
    try:
        number = float(node.value)
    except ValueError:
        return None
    return number if 0.0 < number < math.inf else None


def fitting(lists: Sequence[Joints], configs: Sequence[RobotConfig]) -> tuple[Joints, str]:
    """The list on which most patterns of the configurations match a joint; of several, the longest; () where none does.

    A robot file's joints may differ from those of the USD by their ending alone. They are called as the patterns have
    it where none selects one of them otherwise, or every pattern then does; the text says so.

    Args:
        lists: Of one robot or several, whole or parts of them.
        configs: With patterns.
    """
    patterns = [(c.framework, p) for c in configs for group in c.groups for p in group.joints or ()]

    def worth(joints: Joints) -> tuple[int, int]:
        names = names_of(joints)
        return sum(bool(matching(style, pattern, names)) for style, pattern in patterns), len(names)

    best = max(lists, key=worth)
    # What somebody listed are the names themselves: only a file of another format may have others.
    views = [[joint for joint in joints if not isinstance(joint, str)] for joints in lists]
    renamed = [
        (tuple(replace(view, name=name) for view, name in zip(own, names, strict=True)), how)
        for own in views
        for how, names in other_endings(names_of(own))
    ]
    other, how = max(renamed, key=lambda each: worth(each[0]), default=((), ""))
    if worth(best)[0] < worth(other)[0] and (worth(best)[0] == 0 or worth(other)[0] == len(patterns)):
        return other, f"{how} the ending {_ENDING}, as the configuration's patterns have them"
    return (best, "") if worth(best)[0] else ((), "")


def other_endings(names: Sequence[str]) -> Iterator[tuple[str, list[str]]]:
    """Names without the ending that robot files have and USD files often lack, and with it, where that changes them.

    Args:
        names: Of joints, no two the same; so they stay.
    """
    bare = [name.removesuffix(_ENDING) for name in names]
    if all(bare) and len(set(bare)) == len(names):
        yield from (("without", bare),) if bare != list(names) else ()
        full = [name + _ENDING for name in bare]
        yield from (("with", full),) if full != list(names) else ()


def patterns_of(config: RobotConfig) -> Iterator[str]:
    """What selects the joints of its groups."""
    yield from (pattern for group in config.groups for pattern in group.joints or ())


def differ_by_ending(configs: Sequence[RobotConfig], names: Sequence[str]) -> bool:
    """Whether patterns would select joints that are called without the ending `_joint`, or with it."""
    return any(
        matching(config.framework, pattern, others)
        for config in configs
        for pattern in patterns_of(config)
        for _, others in other_endings(names)
    )


def _differ_by_case(configs: Sequence[RobotConfig], names: Sequence[str]) -> bool:
    """Whether patterns would select joints in small letters, or in capital ones."""
    written = ([name.lower() for name in names], [name.upper() for name in names])
    return any(
        matching(config.framework, pattern, others)
        for config in configs
        for pattern in patterns_of(config)
        for others in written
    )


def named_joints(
    artifacts: Sequence[Artifact], named: str, out: Collector
) -> tuple[Sequence[JointView | str], str]:
    """The joints of the file or list that names them, and how their names were changed.

    Args:
        artifacts: Whose joints.
        named: As of `joint_lists`.
        out: Gets the error that no artifact needs or selects them.
    """
    robot = next((artifact for artifact in artifacts if artifact.config is None), None)
    if robot is not None:
        message = f"not needed: the {'robot file' if robot.spec is None else 'spec'} names the joints"
        out.error("DRF011", message, span=Span(robot.path), where="--joints", help="leave --joints out")
    every = [a.config for a in artifacts if a.config is not None]
    # A deploy file alone selects its joints by their names.
    configs = [config for config in every if config.framework is not Framework.DEPLOY] or every
    lists = joint_lists(named)
    joints, renamed = fitting(lists, configs)
    if not joints and robot is None:
        patterns = [one_line(pattern) for config in configs for pattern in patterns_of(config)]
        message = f"none of its joints is selected by {listed(dict.fromkeys(patterns))}"
        names = names_of(max(lists, key=len))
        help = f"its joints: {listed(map(one_line, names), 4)}"
        if differ_by_ending(configs, names):
            help += "; they differ from the configuration's by the ending _joint alone, which a USD may lack"
        elif _differ_by_case(configs, names):
            help += "; they differ from the configuration's by capital letters alone"
        if not patterns and any(config.framework is Framework.DEPLOY for config in every):
            message = "no file selects joints: the lists of the deploy file have no names"
            motors = next((config.motors for config in every if config.motors is not None), None)
            help = f"add to it {names_wanted(motors)}"
        elif not patterns:
            message = "no file selects joints: no actuators are read of the configuration"
            help = "name the file that has the robot's actuators"
        out.error("DRF011", message, span=Span(one_line(named)), where="--joints", help=help)
    return joints, renamed


def names_of(joints: Sequence[JointView | str]) -> list[str]:
    """The names alone."""
    return [joint if isinstance(joint, str) else joint.name for joint in joints]


def _of_files(path: str) -> Iterator[Joints]:
    """The joints of a robot file, with kinds and ranges."""
    with PendingFiles([path], keep_matrices=False) as pending:
        readings = pending.finish()
    for reading in readings:
        if not reading.readable:
            raise _refusal(f"cannot be read: {reading.reason}", path, reading.help, reading.refused)
        for artifact in reading.artifacts:
            if artifact.robot is not None:
                if found := artifact.robot.scalar_joints:
                    yield found
            elif names := joint_names(artifact):
                yield names


def _of_constant(path: str) -> Iterator[Joints]:
    """The one list of a Python file that is called `JOINT_NAMES`, or `BIPED_JOINT_NAMES`; its text is not run."""
    if not path.lower().endswith(".py"):
        return
    try:
        body = parse(path, (), "", MAX_BYTES).tree.body
    except UnreadableError:
        return
    found = []
    for one in body:
        target = one.targets[0] if isinstance(one, ast.Assign) and len(one.targets) == 1 else None
        if isinstance(one, ast.Assign) and isinstance(target, ast.Name) and _CONSTANT.search(target.id):
            items = one.value.elts if isinstance(one.value, (ast.List, ast.Tuple)) else []
            names = [item.value for item in items if isinstance(item, ast.Constant)]
            found.append([name for name in names if isinstance(name, str) and not _PATTERN.search(name)])
            if len(found[-1]) < max(1, len(items)) or len({*found[-1]}) < len(items):
                return
    if len(found) == 1:
        yield tuple(found[0])


def _named(data: bytes, path: str) -> Iterator[Joints]:
    """Lists of names below a key that names joints, and a list that is the whole file."""
    try:
        root = compose(data)
    except Unfit as err:
        raise _refusal(str(err), path, None, err.span(path)) from None
    pending = [] if root is None else [("joints", root)]
    # `joints: {hip: {...}, knee: {...}}`, where the file has no list.
    keyed: list[Joints] | None = []
    # Aliases may form a circle, or be many.
    for key, node in itertools.islice(pending, MOST_STEPS):
        if isinstance(node, yaml.MappingNode):
            pending += [(str(one.value), value) for one, value in node.value]
            below = node is not root and key in NAMES and node.value
            if keyed is not None and below and all(isinstance(v, yaml.MappingNode) for _, v in node.value):
                keyed.append(tuple(dict.fromkeys(str(one.value) for one, _ in node.value)))
        elif isinstance(node, yaml.SequenceNode):
            texts = [item.value for item in node.value if item.tag == "tag:yaml.org,2002:str"]
            # `joints: [{name: hip}, {name: knee}]`
            every = [_entries(item) for item in node.value]
            texts = texts or [
                value.value
                for own in every
                for name, value in own
                if name in _NAME_KEYS and value.tag == "tag:yaml.org,2002:str"
            ]
            if key in SDK_NAMES:
                # Gaps in the numbering of the motors.
                names, count = list(filter(None, texts)), len(texts) - texts.count("")
            else:
                names, count = texts, len(node.value)
            listed_so = key in (*NAMES, *SDK_NAMES) and names and len(names) == count == len(set(names))
            # A run's `joint_names: [.*_wrist_.*]` selects some.
            if listed_so and not any(map(_PATTERN.search, names)):
                keyed = None
                yield tuple(names)
            else:
                pending += [("", item) for item in node.value]
    yield from keyed or ()


def _column(text: str, path: str) -> list[str] | None:
    """The names of a table; None of what is none.

    Its first line heads one column by `name` or the like, or all columns are numbers but one.

    Raises: AuditError: it has numbers, and several columns that may be the names.
    """
    lines = [line for line in text.splitlines() if line.strip()]
    for mark in (",", ";", "\t", None):
        rows = [[cell.strip().strip("\"'") for cell in line.split(mark)] for line in lines]
        if not rows or any(len(row) != len(rows[0]) for row in rows):
            continue
        heads = [head.lower() in _NAME_KEYS for head in rows[0]]
        # A text of blanks and names has no heads, and one name alone is a name.
        if heads.count(True) == 1 and (len(rows) > 1 if len(heads) == 1 else mark is not None):
            return [row[heads.index(True)] for row in rows[1:]]
        if mark is not None and (heads_only := _heads(rows)):
            return heads_only
        columns = list(zip(*rows, strict=True))
        counts = [len(rows) > 1 and all(map(_NUMBER.fullmatch, column[1:])) for column in columns]
        if any(counts) and not all(counts):
            own = zip(columns, counts, strict=True)
            headed = any(count and not _NUMBER.fullmatch(column[0]) for column, count in own)
            words = [column[headed:] for column, count in zip(columns, counts, strict=True) if not count]
            names = [column for column in words if len(set(column)) == len(column)]
            if len(names) != 1:
                raise _refusal(
                    "which of its columns has the names is not told", path, "head that column `name`"
                )
            return list(names[0])
    return None


def _heads(rows: Sequence[Sequence[str]]) -> list[str]:
    """The joints that a recording's columns are of, `hip.position [rad]` or `hip`; none of what is no recording."""
    first, *rest = rows
    numbers = all(_NUMBER.fullmatch(cell) for row in rest for cell in row)
    if not rest or not numbers or any(_NUMBER.fullmatch(head) for head in first):
        return []
    heads = [re.sub(r"\s*\[[^\[\]]*\]$", "", head) for head in first]
    heads = [head for head in heads if head.lower() not in _NO_JOINT]
    stems = [stem for stem, _, end in (head.rpartition(".") for head in heads) if stem and end in _SIGNALS]
    ends = [_SIGNAL_ENDS.fullmatch(head) for head in heads]
    if all(ends):
        # One that ends otherwise may be a joint's own name.
        stems = [end[1] for end in ends if end]
    names = list(dict.fromkeys(stems or heads))
    return names if len(names) > 1 else []


def _listed(text: str, path: str) -> str:
    """A text with names, without what numbers its lines.

    Raises: AuditError: a line has a number beside names.
    """
    names = _NUMBERED.sub("", text)
    for line in names.splitlines():
        words = [word for word in _NO_NAME.split(line) if word]
        counts = [word for word in words if _NUMBER.fullmatch(word)]
        if counts and len(counts) < len(words):
            raise _refusal(f"{counts[0]} is a number beside names", path, _HELP)
    return names


def _data(path: str) -> bytes:
    try:
        return read_regular(path, MOST_YAML_BYTES)
    except FAULTS as err:
        raise _refusal(f"cannot be read: {why(err)}", path, None) from None


def _distinct(names: str, text: str) -> Joints:
    if "\0" in names or "\ufffd" in names:
        raise _refusal("is no text", text, _HELP)
    if printed := _PRINTED.fullmatch(names):
        names = re.sub("['\"]", "", printed[1])
    found = [name for name in (_QUOTED.sub(r"\2", each) for each in _NO_NAME.split(names)) if name]
    twice = next((name for name in found if found.count(name) > 1), None)
    pattern = next(filter(_PATTERN.search, found), None)
    if pattern is not None:
        raise _refusal(f"{one_line(pattern)} is a pattern, and names are needed", text, _HELP)
    if twice is not None:
        raise _refusal(f"{one_line(twice)} stands there twice", text, _HELP)
    if not found:
        raise _refusal("no name of a joint is in it", text, _HELP)
    return tuple(found)


def _refusal(message: str, text: str, help: str | None, span: Span | None = None) -> AuditError:
    if span is None and os.path.exists(text):
        span = Span(text)
    shown = "" if span is not None else f"{one_line(text)!r}: "
    return AuditError.of("DRF011", f"{shown}{message}", span, where="--joints", help=help)
