"""Names of joints alone, from a list or any file that has them: for configurations whose joints stand in a USD."""

from __future__ import annotations

import ast
import itertools
import math
import os
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import yaml

from actspec.diagnostics import AuditError, Collector, Span, listed, one_line
from actspec.files import FAULTS, read_regular, why
from actspec.readings.artifact import Artifact, FileKind, Framework, RobotConfig, Setting
from actspec.readings.called import agreement, are_two, shared_words, words_of
from actspec.readings.deploy import MOST_JOINTS
from actspec.readings.deploy_keys import NAMES, names_in_a_row
from actspec.readings.deploy_motors import SDK_NAMES
from actspec.readings.dict_keys import POSE, meets
from actspec.readings.joint_names import joint_names, matching
from actspec.readings.joint_texts import (
    NAME_KEYS,
    PATTERN,
    NoNamesError,
    distinct,
    lists_in,
    lists_in_notebook,
    without_beginning,
)
from actspec.readings.motor_names import names_wanted
from actspec.readings.named import PendingFiles
from actspec.readings.python.source import MAX_BYTES, UnreadableError, parse
from actspec.readings.read import MOST_YAML_BYTES, YAML
from actspec.readings.yaml_nodes import MOST_STEPS, Unfit, compose, node_span
from actspec.robot.submodules import of_missing
from actspec.robot.view import JointView

Joints: TypeAlias = "tuple[JointView | str, ...]"
"""Joints in the file's order; of a robot file with kind and range, else names alone."""


@dataclass(frozen=True, slots=True)
class JointList:
    """Joints that a file or an argument names.

    Attributes:
        joints: In its order, no name twice.
        of: What has them, for a message: `leg.urdf`, of a folder `robots/leg.urdf`.
        changed: How the names were changed; "": they are as they stand there.
        path: The file, of a folder's; "" for one that was named itself, which is the robot's whatever it is called.
        words: Telling words of what a folder's file is called.
        why: Why a folder's file counts that is not called as the robot; "": it is, or was chosen of several.
    """

    joints: Joints
    of: str
    changed: str = ""
    path: str = ""
    words: frozenset[str] = frozenset()
    why: str = ""


_USD = (".usd", ".usda", ".usdc", ".usdz")
_ROBOT_FILES = (".xml", ".urdf", ".mjcf", ".xacro", ".py")
_XML = re.compile(rb"(?:\xef\xbb\xbf)?\s*<")
_ENDING = "_joint"
"""That USD files of robots leave out, or have, where the URDF is the other way round."""
_DOF = re.compile(r"\d+dof")
_CONSTANT = re.compile(r"(?:^|_)joint_names$", re.IGNORECASE)
_SAME_END = 0.01
"""Difference of ends of one range in two files of a robot [rad or m]. Chosen: 1.57 for a quarter turn."""
_NAME_ONE = "name the file of the robot: --joints FILE"
_MOST_NAMES = 10 * MOST_JOINTS
"""Chosen: names in all lists of a file; the patterns are held against each list."""
_KNOWN = (*_ROBOT_FILES, ".json", ".txt", ".csv", ".list", ".toml", ".ipynb", ".log", ".md", *YAML, *_USD)
"""Endings of files, which no joint has."""
_HELP = (
    "a URDF, an MJCF, IO_descriptors.yaml of Isaac Lab, a deploy file, a text with one name a line, a CSV with a "
    "column `name`, or the names themselves: --joints a,b,c"
)


def joint_lists(text: str) -> tuple[JointList, ...]:
    """The lists of joints that an argument names, the first one first; no name twice in a list.

    Args:
        text: A file, a folder, or names with commas between them.

    Raises:
        AuditError: there is no such file, it names no joints, or too many.
    """
    lower = text.lower()
    is_there = os.path.exists(text)
    found: list[JointList]
    if not is_there and not lower.endswith(_KNOWN) and ("/" not in text or "," in text):
        found = [JointList(names, "the list") for names in _told(lambda: [distinct(text)], text)]
    elif not is_there:
        message, help = of_missing("there is no such file", text, _HELP)
        raise _refusal(message, text, help)
    elif lower.endswith(_USD):
        printed = f"{_HELP}. In Isaac Lab `print(robot.joint_names)` prints them"
        raise _refusal("USD is not read for names of joints", text, printed)
    elif os.path.isdir(text):
        found = list(_of_files(text))
    else:
        of, data = os.path.basename(text), _data(text)
        if lower.endswith((*YAML, ".json")):
            found = [JointList(names, of) for names in _named(data, text)]
        elif lower.endswith(".ipynb"):
            found = [JointList(names, of) for names in _told(lambda: lists_in_notebook(data), text)]
        elif lower.endswith(".py"):
            found = _of_program(text)
        elif lower.endswith(_ROBOT_FILES) or _XML.match(data):
            found = list(_of_files(text))
        else:
            lines = data.decode("utf-8-sig", "replace")
            found = [JointList(names, of) for names in _told(lambda: lists_in(lines), text)]
    if not found:
        raise _refusal("no list of joint names is in it", text, _HELP)
    counts = [sum(isinstance(joint, str) for joint in one.joints) for one in found]
    for count, most, where in (
        (max(counts), MOST_JOINTS, ""),
        (sum(counts), _MOST_NAMES, " in all of its lists"),
    ):
        if count > most:
            raise _refusal(f"has {count} names of joints{where}, at most {most} are read", text, _HELP)
    return tuple(found)


def _told(read: Callable[[], list[tuple[str, ...]]], text: str) -> list[tuple[str, ...]]:
    """What a reader of texts finds, its refusals as those of the option."""
    try:
        return read()
    except NoNamesError as err:
        span = Span(text, err.line) if err.line and os.path.exists(text) else None
        raise _refusal(str(err), text, err.help or _HELP, span) from None


def environment_of(text: str) -> Artifact | None:
    """The steps that Isaac Lab's IO_descriptors.yaml states of the environment, as a configuration without groups.

    Args:
        text: As of `joint_lists`, which has read it; None where it states no physics step.
    """
    if not os.path.isfile(text) or not text.lower().endswith((*YAML, ".json")):
        return None
    settings = {}
    for name, node in _entries(_entry(compose(_data(text), text), "scene")):
        if name in ("physics_dt", "decimation") and (number := _number(node)) is not None:
            settings[name] = Setting(number, node_span(node))
    name = os.path.splitext(os.path.basename(text))[0]
    config = RobotConfig(Framework.ISAACLAB, name, Span(text), (), settings)
    return Artifact(text, FileKind.CFG, name, config=config) if "physics_dt" in settings else None


def _entries(node: yaml.Node | None) -> list[tuple[str, yaml.Node]]:
    """Keys and values; a key that is a list or mapping, of which a text may have no end, is none."""
    pairs = node.value if isinstance(node, yaml.MappingNode) else []
    return [(str(key.value), value) for key, value in pairs if isinstance(key, yaml.ScalarNode)]


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


def fitting(lists: Sequence[JointList], robot: Sequence[Artifact], named: str) -> JointList | None:
    """The list on which most patterns of configurations match a joint; None where none does.

    Of several it is the one on which most keys of poses, gains and limits do: `.*_joint` fits every robot. Of those it
    is one that is called as the robot, of a folder's files, where all quadrupeds of a maker may have the same names;
    one that is called as another robot is none. Then it is one without a joint that the pose has no key for, if there
    is one that has half of the joints or more of any that has all of its own, the longest, the one called as the
    asset, and the one with as many degrees of freedom in its name.

    A robot file's joints may differ from those of the USD by their ending alone. They are called as the patterns have
    it where none selects one of them otherwise, or every pattern then does. Listed names may share what is before
    them, a path or a signal (`q_hip`): it goes, unless patterns select them with it alone. The list says both.

    Args:
        lists: Of one robot or several, whole or parts of them.
        robot: Configurations with patterns.
        named: Where the lists are from, as the user named it.

    Raises:
        AuditError: files of a folder are called as other robots, or as this one and differ in joints.
    """
    pairs = [(one, one.config) for one in robot if one.config is not None]
    words = frozenset(word for one, config in pairs for word in words_of(one, config.model or ""))
    strangers = [one for one in lists if one.path and are_two((words,), (one.words,))]
    configs = [config for _, config in pairs]
    found = _best([one for one in lists if one not in strangers], configs, words, named)
    meant = strangers if found is None else ()
    if called := [one for one in meant if _best([one], configs, words, named) is not None]:
        message = f"all of its files with these joints are called as other robots: {_shown(called)}"
        raise _refusal(message, named, _NAME_ONE)
    if found is not None and len(lists) == 1 and found.path:
        # A kind, which tells no robots apart, is a name all the same where it is the only one: `leg`.
        if shared_words(words, found.words) or (found.words and found.words <= words):
            return found
        return replace(found, why="the only file there with joints, which is not called as the configuration")
    return found


def _best(
    lists: Sequence[JointList], configs: Sequence[RobotConfig], words: frozenset[str], named: str
) -> JointList | None:
    """As `fitting`, of files of which none is another robot's; words: what the robot is called."""
    if not lists:
        return None
    patterns = [(c.framework, p) for c in configs for group in c.groups for p in group.joints or ()]

    keys = [
        (config.framework, name, key)
        for config in configs
        for each in (config.settings, *(group.settings for group in config.groups))
        for name, setting in each.items()
        for key in setting.keys or ()
    ]

    dof = {word for c in configs for said in (c.name, c.model or "") for word in _DOF.findall(said.lower())}
    every = [frozenset(names_of(one.joints)) for one in lists]

    def is_a_part(names: frozenset[str]) -> bool:
        return any(names < other and 2 * len(names) < len(other) for other in every)

    def worth(one: JointList) -> tuple[int, int, bool, bool, int, int, int]:
        names = names_of(one.joints)
        met = sum(bool(matching(style, pattern, names)) for style, pattern in patterns)
        of_keys = [{name for name in names if meets(*key, name)} for key in keys]
        posed = set().union(*(own for key, own in zip(keys, of_keys, strict=True) if key[1] == POSE))
        covered = len(posed) == len(names) and not is_a_part(frozenset(names))
        called = bool(shared_words(words, one.words))
        asset = max((agreement(config.model or "", one.path) for config in configs if one.path), default=0)
        same_dof = len(dof & {*_DOF.findall(os.path.basename(one.path).lower())})
        return met, sum(map(bool, of_keys)), called, covered, len(names), asset, same_dof

    def best_of(some: Sequence[JointList]) -> JointList:
        top = max(map(worth, some))
        equal = [one for one in some if worth(one) == top]
        files = [one for one in equal if one.path]
        unlike: list[JointList] = []
        for one in files:
            if not any(_are_same(one.joints, other.joints) for other in unlike):
                unlike.append(one)
        if top[0] and len(unlike) > 1:
            message = "which of its files is the robot's is not told, and their joints differ: "
            raise _refusal(f"{message}{_shown(unlike)}", named, _NAME_ONE)
        return equal[0]

    best = best_of([max(_bare(one), one, key=worth) for one in lists])
    # What somebody listed are the names themselves: only a file of another format may have others.
    renamed = [
        replace(
            one,
            joints=tuple(replace(view, name=name) for view, name in zip(own, names, strict=True)),
            changed=f"{how} the ending {_ENDING}, as the configuration's patterns have them",
        )
        for one in lists
        for own in [[joint for joint in one.joints if not isinstance(joint, str)]]
        for how, names in other_endings(names_of(own))
    ]
    if renamed:
        other = best_of(renamed)
        if worth(best)[0] < worth(other)[0] and (worth(best)[0] == 0 or worth(other)[0] == len(patterns)):
            return other
    return best if worth(best)[0] else None


def _shown(lists: Sequence[JointList]) -> str:
    return listed([one_line(one.of) for one in lists], 4)


def _are_same(joints: Joints, others: Joints) -> bool:
    """Whether two lists give a spec the same joints: in order, names, kinds and ranges."""
    told, wanted = (
        [(one, "", None) if isinstance(one, str) else (one.name, one.kind, one.range) for one in each]
        for each in (joints, others)
    )
    return [one[:2] for one in told] == [one[:2] for one in wanted] and all(
        mine == its or (mine and its and max(abs(a - b) for a, b in zip(mine, its, strict=True)) < _SAME_END)
        for (_, _, mine), (_, _, its) in zip(told, wanted, strict=True)
    )


def _bare(one: JointList) -> JointList:
    """A list whose names have nothing before them that all share; the same where they have not."""
    names = [joint for joint in one.joints if isinstance(joint, str)]
    bare, cut = without_beginning(names) if len(names) == len(one.joints) else ([], "")
    return replace(one, joints=tuple(bare), changed=f"without {cut}") if bare else one


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


def named_joints(artifacts: Sequence[Artifact], named: str, out: Collector) -> JointList:
    """The joints of the file or list that names them; none after an error.

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
    lists = joint_lists(named)
    # A deploy file alone selects its joints by their names.
    parts = [a for a in artifacts if a.config is not None and a.config.framework is not Framework.DEPLOY]
    parts = parts or [a for a in artifacts if a.config is not None]
    configs = [config for config in every if config.framework is not Framework.DEPLOY] or every
    found = fitting(lists, parts, named)
    if found is None and robot is None:
        patterns = [one_line(pattern) for config in configs for pattern in patterns_of(config)]
        message = f"none of its joints is selected by {listed(dict.fromkeys(patterns))}"
        names = names_of(max((one.joints for one in lists), key=len))
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
    return found or JointList((), "")


def names_of(joints: Sequence[JointView | str]) -> list[str]:
    """The names alone."""
    return [joint if isinstance(joint, str) else joint.name for joint in joints]


def _of_files(path: str) -> Iterator[JointList]:
    """The joints of a robot file or of those of a folder, with kinds and ranges."""
    with PendingFiles([path], keep_matrices=False) as pending:
        readings = pending.finish()
    for reading in readings:
        if not reading.readable:
            raise _refusal(f"cannot be read: {reading.reason}", path, reading.help, reading.refused)
        of = os.path.basename(path)
        if os.path.isdir(path):
            of = os.path.join(os.path.basename(os.path.abspath(path)), os.path.relpath(reading.path, path))
        for artifact in reading.artifacts:
            if artifact.robot is not None:
                joints: Joints = artifact.robot.scalar_joints
            else:
                joints = tuple(joint_names(artifact) or ())
            if joints and os.path.isdir(path):
                yield JointList(joints, of, path=reading.path, words=words_of(artifact, of))
            elif joints:
                yield JointList(joints, of)


def _of_program(path: str) -> list[JointList]:
    """The one list of a Python file that is called `JOINT_NAMES`, or `BIPED_JOINT_NAMES`, else what it configures.

    Its text is not run.
    """
    try:
        tree = parse(path, (), "", MAX_BYTES).tree
    except UnreadableError:
        return list(_of_files(path))
    lists = _constants(tree.body)
    if len({*lists.values()}) == 1:
        return [JointList(next(iter(lists.values())), os.path.basename(path))]
    try:
        if found := list(_of_files(path)):
            return found
    except AuditError as err:
        place = err.diagnostics[0].span
        if place is not None and place.line:
            raise
    # A class of a configuration may select some joints by such a list.
    lists = lists or _constants(
        [one for cls in ast.walk(tree) if isinstance(cls, ast.ClassDef) for one in cls.body]
    )
    if len({*lists.values()}) == 1:
        return [JointList(next(iter(lists.values())), os.path.basename(path))]
    message = "no list of joint names is in it"
    if lists:
        message = f"which of its lists has the joints is not told: {listed(map(one_line, lists))}"
    raise _refusal(message, path, "let one list be called JOINT_NAMES, with the names written out")


def _constants(body: Sequence[ast.stmt]) -> dict[str, tuple[str, ...]]:
    """Lists of names by what they are called; none where one of them is not written out."""
    found = {}
    for one in body:
        targets = one.targets if isinstance(one, ast.Assign) else []
        targets = [one.target] if isinstance(one, ast.AnnAssign) and one.value is not None else targets
        target = targets[0] if len(targets) == 1 else None
        if not isinstance(one, (ast.Assign, ast.AnnAssign)) or not isinstance(target, ast.Name):
            continue
        if _CONSTANT.search(target.id):
            items = one.value.elts if isinstance(one.value, (ast.List, ast.Tuple)) else []
            names = [item.value for item in items if isinstance(item, ast.Constant)]
            texts = tuple(name for name in names if isinstance(name, str) and not PATTERN.search(name))
            if len(texts) < max(1, len(items)) or len({*texts}) < len(items):
                return {}
            found[target.id] = texts
    return found


def _named(data: bytes, path: str) -> Iterator[Joints]:
    """Lists of names below a key that names joints, and a list that is the whole file."""
    try:
        root = compose(data)
    except Unfit as err:
        raise _refusal(str(err), path, None, err.span(path)) from None
    pending = [] if root is None else [("joints", root)]
    # `joints: {hip: {...}, knee: {...}}`, where the file has no list.
    keyed: list[Joints] | None = []
    fault: yaml.Node | None = None
    # Aliases may form a circle, or be many: below each key of names a node counts once, below all others, too.
    seen = set[tuple[str, int]]()
    for key, node in itertools.islice(pending, MOST_STEPS):
        place = key if key in (*NAMES, *SDK_NAMES) else "", id(node)
        if place in seen:
            continue
        seen.add(place)
        if key in NAMES:
            node = names_in_a_row(node, lambda own: {name: _name_in(one) for name, one in _entries(own)})
        if isinstance(node, yaml.MappingNode):
            entries = _entries(node)
            pending += entries
            if key in NAMES and _are_numbered(node):
                fault = fault or node
                continue
            below = node is not root and key in NAMES and entries
            if keyed is not None and below and all(isinstance(v, yaml.MappingNode) for _, v in entries):
                keyed.append(tuple(dict(entries)))
        elif isinstance(node, yaml.SequenceNode):
            texts = [item.value for item in node.value if item.tag == "tag:yaml.org,2002:str"]
            # `joints: [{name: hip}, {name: knee}]`
            every = [_entries(item) for item in node.value]
            texts = texts or [
                value.value
                for own in every
                for name, value in own
                if name in NAME_KEYS and value.tag == "tag:yaml.org,2002:str"
            ]
            if key in SDK_NAMES:
                # Gaps in the numbering of the motors.
                names, count = list(filter(None, texts)), len(texts) - texts.count("")
            else:
                names, count = texts, len(node.value)
            listed_so = key in (*NAMES, *SDK_NAMES) and names and len(names) == count == len(set(names))
            # A run's `joint_names: [.*_wrist_.*]` selects some.
            if listed_so and not any(map(PATTERN.search, names)):
                keyed = None
                yield tuple(names)
            else:
                pending += [("", item) for item in node.value]
    if keyed is not None and fault is not None:
        message = "its names by number are not from 0 or 1 on, each once and written out"
        raise _refusal(
            message, path, "a merge `<<` is not read among them", replace(node_span(fault), path=path)
        )
    yield from keyed or ()


def _name_in(node: yaml.Node) -> yaml.Node:
    """The name in a mapping that has one; any other node as it is."""
    names = [
        value for key, value in _entries(node) if key in NAME_KEYS and value.tag == "tag:yaml.org,2002:str"
    ]
    return names[0] if len(names) == 1 else node


def _are_numbered(node: yaml.MappingNode) -> bool:
    """Whether the keys are numbers, or merges beside them, of names."""
    entries = _entries(node)
    numbers = [_name_in(value) for key, value in entries if key.isdecimal()]
    rest = [key for key, _ in entries if not key.isdecimal() and key != "<<"]
    return bool(numbers) and not rest and all(one.tag == "tag:yaml.org,2002:str" for one in numbers)


def _data(path: str) -> bytes:
    try:
        return read_regular(path, MOST_YAML_BYTES)
    except FAULTS as err:
        raise _refusal(f"cannot be read: {why(err)}", path, None) from None


def _refusal(message: str, text: str, help: str | None, span: Span | None = None) -> AuditError:
    if span is None and os.path.exists(text):
        span = Span(text)
    shown = "" if span is not None else f"{one_line(text)!r}: "
    return AuditError.of("DRF011", f"{shown}{message}", span, where="--joints", help=help)
