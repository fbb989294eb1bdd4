"""Deploy YAML: the gains, limits and pose that run on the robot, with the joints' names or without.

Three shapes are known: lists beside a list of joint names, mappings from joint (or a part of its name) to a number, and
below `joints` the figures of each joint. Lists without names are only used where every entry is the same, because which
joint an entry belongs to is then no question; the order of a nameless list is never guessed. It is of a robot with so
many joints.

Read by PyYAML's composer alone: nothing is constructed, tags are looked at and never acted upon.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeAlias

import yaml

from actspec.diagnostics import Collector, Diagnostic, Severity, Span, listed, many, shortened
from actspec.readings.artifact import (
    STEP_OF_WHAT,
    ActuatorGroup,
    Artifact,
    FileKind,
    FileReading,
    Framework,
    Motors,
    NamelessList,
    RobotConfig,
    Setting,
)
from actspec.readings.deploy_keys import (
    GAIN_KEYS,
    NAMES,
    PER_JOINT,
    STANDING,
    STANDING_UP,
    as_figures,
    by_figure,
    in_a_row,
    is_in_space,
    joint_lists,
    names_in_a_row,
    own_gains,
    speaks_of_space,
    standing_up,
    type_of_space,
)
from actspec.readings.deploy_missing import (
    MISSPELT,
    NO_GAINS,
    Lack,
    blocks_of,
    misspelt,
    slip,
    why_without_gains,
)
from actspec.readings.deploy_motors import LENGTH, motors_of, sdk_names
from actspec.readings.deploy_numbers import (
    LEAST_JOINTS,
    NO_NUMBER,
    by_side,
    is_empty,
    is_meant_for_one,
    is_per_joint,
    no_number,
)
from actspec.readings.deploy_orders import in_policy_order, with_orders
from actspec.readings.deploy_steps import nearest, steps_of
from actspec.readings.joint_names import matching
from actspec.readings.leftover import Leftover
from actspec.readings.motor_names import NAMELESS, called, names_wanted
from actspec.readings.rl_sar import Base
from actspec.readings.twice import keys_twice, name_twice
from actspec.readings.yaml_nodes import (
    MOST_DEPTH,
    MOST_STEPS,
    Unfit,
    compose,
    node_span,
    number_of,
    position,
    setting_of,
)
from actspec.robot.view import ModelFile

MOST_JOINTS = 2000
"""Chosen: joints that one list names; every field's list is held against every name."""

OWN_FORMAT = "actspec-deploy/"
"""What `format` begins with in a file that actspec wrote, whose other lists are known too."""

OWN_LISTS = {
    "command": ("command", ""),
    "position_low": ("position_lower", ""),
    "position_high": ("position_upper", ""),
    "command_low": ("command_range", "low"),
    "command_high": ("command_range", "high"),
    "delay": ("policy_delay", "nominal"),
    "delay_low": ("policy_delay", "low"),
    "delay_high": ("policy_delay", "high"),
}
"""Setting of a joint to the key of the list, and of the part of it."""

_ROS_PARAMETERS = "ros__parameters"
"""Key above the parameters of a ROS 2 node. Source: ros2_control, joint_trajectory_controller: `joints` are names of
interfaces, each of which it claims by its name."""

_COMMANDS = frozenset(("pos", "position", "vel", "velocity", "torque", "effort"))
"""Keys of a mapping that is by what is commanded, as `action_scale: {pos: 0.25}`, and not by joint."""

_NOT_OF_LISTS = frozenset((STEP_OF_WHAT, NO_NUMBER, STANDING_UP))
"""Codes of remarks that do not tell that a block has lists of figures."""

_Block: TypeAlias = "dict[str, yaml.Node]"
"""A mapping of the file: key to value."""

_GAINS = re.compile(
    rb"(?:^[^\w#\n]*|[{,][ \t]{0,9}[\"']?)(?:%s|(?:\w+_)?[kK][pPdD][sS]?(?:_\w+)?)[\"']?[ \t]*:"
    % "|".join(GAIN_KEYS).encode(),
    re.MULTILINE,
)


def names_gains(data: bytes) -> bool:
    """Whether a text that cannot be read has a key for gains."""
    return _GAINS.search(data) is not None


def read_deploy(path: str, data: bytes, base: Base | None = None) -> FileReading:
    """Read a deploy file.

    Args:
        path: YAML with gains.
        data: Its bytes.
        base: What it has from another file, where it says nothing else; None: nothing.

    Returns: One artifact for each block that has gains; unreadable with a reason when there is none.
    """
    file = ModelFile(path, "", data)
    try:
        root = compose(data, path)
    except Unfit as err:
        return FileReading(path, None, str(err), files=(file,), refused=err.span(path))
    if root is not None and b"scene:" in data:
        from actspec.readings.runs import read_run

        if run := read_run(file, root):
            return run
    name = os.path.splitext(os.path.basename(path))[0]
    reader = _Reader()
    try:
        configs = () if root is None else reader.whole(root, name, base)
        twice = () if root is None or not configs else keys_twice(root)
    except Unfit as err:
        return FileReading(path, FileKind.DEPLOY, str(err), files=(file,), refused=err.span(path))
    if not configs:
        return _without_gains(file, root, reader)
    return FileReading(
        path,
        FileKind.DEPLOY,
        None,
        tuple(Artifact(path, FileKind.DEPLOY, config.name, config=config) for config in configs),
        (file,) if base is None else (file, base.file),
        (*(note for config in configs for note in config.notes), *twice),
    )


def _without_gains(file: ModelFile, root: yaml.Node | None, reader: _Reader) -> FileReading:
    """A file of which nothing is taken as gains."""
    if reader.no_numbers:
        first = reader.no_numbers[0]
        more = len(reader.no_numbers) - 1
        why = f"{first.where}: {first.message.partition(': ')[0]}"
        why += f" (and {more} more)" if more else ""
        return FileReading(file.path, None, why, files=(file,), refused=first.span)
    reader.steps = 0
    gains = {gain: PER_JOINT[gain] for gain in ("kp", "kd")}
    try:
        lack = why_without_gains(root, gains, NAMES, reader.mapping)
    except Unfit:
        lack = Lack(NO_GAINS)
    span = None if lack.node is None else node_span(lack.node)
    return FileReading(
        file.path, None, lack.why, files=(file,), refused=span, without_gains=not lack.of_joints
    )


_CALLED = re.compile(r"\w[\w.-]{0,63}")


class _Reader:
    """Walks one file within its limits."""

    def __init__(self) -> None:
        self.steps = 0
        self.refused: list[yaml.SequenceNode] = []
        """Lists of joint names of the block at hand that have one twice, the nearest first."""
        self.no_numbers: list[Diagnostic] = []
        """What stands for figures, and is none, in blocks of which nothing is read."""
        self.own: set[frozenset[str]] | None = None
        """Lists of joint names of a file that has no known key of gains, where those of its author's are looked for."""
        self.motors: Motors | None = None
        """What the lists of the block at hand say by the robot's numbering."""
        self.keys: Mapping[str, tuple[str, ...]] = PER_JOINT
        """Field to the keys of the block at hand."""

    @property
    def figures(self) -> set[str]:
        """Every key of figures of joints."""
        return {key for keys in self.keys.values() for key in keys}

    def whole(self, root: yaml.Node, name: str, base: Base | None) -> tuple[RobotConfig, ...]:
        """Every block that has gains, with what no figure is made from."""
        name = self._called(root) or name
        above = () if base is None else (self.mapping(base.block),)
        found = tuple(self.configs(root, above, name, 0))
        if not found and not self.no_numbers:
            self.steps = 0
            self.own = joint_lists(blocks_of(root, self.mapping))
            found = tuple(self.configs(root, above, name, 0))
        if not found:
            return ()
        self.steps = 0
        try:
            found = with_orders(found, blocks_of(root, self.mapping), self.figures)
            self.steps = 0
            return Leftover(found, self.mapping, LEAST_JOINTS).kept(root)
        except Unfit as err:
            # Too much to compare, and its gains are read all the same.
            rest = {"the rest of the file": Setting(None, err.span(root.start_mark.name), str(err))}
            return (replace(found[0], others=rest), *found[1:])

    def _called(self, root: yaml.Node) -> str:
        """What the file calls its robot (`robot: go2`); empty where that is no name."""
        node = self.mapping(root).get("robot") if isinstance(root, yaml.MappingNode) else None
        word = str(node.value) if isinstance(node, yaml.ScalarNode) and node.tag.endswith(":str") else ""
        return word if _CALLED.fullmatch(word) else ""

    def configs(
        self, node: yaml.Node, above: tuple[_Block, ...], name: str, depth: int, in_space: bool = False
    ) -> Iterator[RobotConfig]:
        """Every block that has gains, outermost first; a block inside a block with gains belongs to it.

        Args:
            node: Where to look.
            above: The blocks that it is in, outermost first.
            name: What a robot in it is called: what the file says, its stem, or its key at the top.
            depth: How deep it is.
            in_space: Whether a key above, or a controller's type, speaks of a pose in space.
        """
        self._step(node)
        if depth > MOST_DEPTH:
            raise Unfit(f"it is nested more than {MOST_DEPTH} deep", position(node.start_mark))
        if isinstance(node, yaml.SequenceNode):
            for item in node.value:
                yield from self.configs(item, above, name, depth + 1, in_space)
        if not isinstance(node, yaml.MappingNode):
            return
        block = self.mapping(node)
        # Figures joint by joint are read as mappings from joint to each, which are known.
        by_joint, named = by_figure(block.get("joints"), self.mapping)
        block = {**by_joint, **block}
        figures = {key: as_figures(block[key], self.mapping) for key in self.figures if key in block}
        block = {key: its for key, one in block.items() if (its := figures.get(key, one)) is not None}
        if self._has_gains(block) and not is_in_space(block, below=in_space):
            config = self._config(node, block, named, above, name)
            if config.groups or any(note.code not in _NOT_OF_LISTS for note in config.notes):
                yield config
            else:
                self.no_numbers += [note for note in config.notes if note.code == NO_NUMBER]
            return
        in_space = in_space or type_of_space(block)
        for key, value in block.items():
            whose = key if depth == 0 else name
            below = in_space or speaks_of_space(key)
            yield from self.configs(value, (*above, block), whose, depth + 1, below)

    def _has_gains(self, block: _Block) -> bool:
        """Whether a block has gains by joint, or one kp and one kd beside the list of joint names that both are for.

        Where no block has them, by keys of an author's own: `kp_walk` and `kd_walk`, where nothing beside them, as
        `kp_stand`, leaves open which ones the joints run, and where names tell that they are of joints.

        Single numbers elsewhere are those of a controller that stands up, of a Cartesian one, of a group of actuators.
        """
        if self.own is not None:
            own = own_gains(block, self.own, self.mapping)
            if len(own) != 1 or not own[0].named or not own[0].name:
                return False
            self.keys = {**PER_JOINT, "kp": (own[0].kp,), "kd": (own[0].kd,)}
            return True
        # A block with the gains of standing up has limits and a default pose that are the policy's, too.
        if any(is_per_joint(block.get(key)) for key in (*GAIN_KEYS, *STANDING)):
            return True
        gains = [nearest((block,), PER_JOINT[field]) for field in ("kp", "kd")]
        single = all(found is not None and is_meant_for_one(found[1]) for found in gains)
        return single and any(self._texts(block.get(key)) for key in NAMES)

    def mapping(self, node: yaml.MappingNode) -> _Block:
        """Keys to values, merges applied as YAML 1.1 does: a key of one's own wins."""
        found: _Block = {}
        merged: list[yaml.MappingNode] = []
        for key, value in node.value:
            self._step(key)
            if not isinstance(key, yaml.ScalarNode):
                continue
            if key.tag == "tag:yaml.org,2002:merge":
                parts = value.value if isinstance(value, yaml.SequenceNode) else [value]
                merged.extend(
                    part for part in parts if isinstance(part, yaml.MappingNode) and part is not node
                )
            else:
                found[str(key.value)] = value
        for part in merged:
            # A merged mapping's own merges are left: nobody writes them, and they may form a circle.
            for key, value in part.value:
                self._step(key)
                if isinstance(key, yaml.ScalarNode):
                    found.setdefault(str(key.value), value)
        beside, named = found.values(), [key for key in NAMES if key in found]
        return found | {key: names_in_a_row(found[key], self._written, beside) for key in named}

    def _written(self, node: yaml.MappingNode) -> _Block:
        """A mapping's keys as they stand there."""
        for key, _ in node.value:
            self._step(key)
        return {str(key.value): value for key, value in node.value if isinstance(key, yaml.ScalarNode)}

    def _config(
        self,
        node: yaml.Node,
        block: _Block,
        named: yaml.SequenceNode | None,
        above: tuple[_Block, ...],
        name: str,
    ) -> RobotConfig:
        out = Collector()
        self.refused = []
        scopes = (block, *reversed(above))
        gains = nearest(scopes, self.keys["kp"])
        entries = (
            len(gains[1].value) if gains is not None and isinstance(gains[1], yaml.SequenceNode) else None
        )
        written = self._names(block, above)
        names = in_policy_order(written, scopes, entries)
        elsewhere = names is not None and next(iter(names.values())).path != node.start_mark.name
        if names is not None and elsewhere and entries not in (None, len(names)):
            # The robot has other joints than the policy.
            names = None
        self.motors = motors = motors_of(scopes, self.keys, self.mapping, out)
        called_so = sdk_names(scopes) or tuple(names or ())
        if motors is not None and len(called_so) == motors.count:
            names = None
        joints = tuple(names) if names is not None else None
        fields: dict[str, dict[str, Setting]] = {}
        count: Setting | None = None
        lists: dict[str, NamelessList] = {}
        mapped: dict[str, dict[str, Setting]] = {}
        for field, keys in self.keys.items():
            found = nearest(scopes, keys)
            values = {} if found is None else self._per_joint(*found, joints, out)
            if values:
                fields[field] = values
            if found is not None and values and isinstance(found[1], yaml.MappingNode):
                mapped[found[0]] = values
            if found is not None and joints is None and isinstance(found[1], yaml.SequenceNode):
                lists[field] = NamelessList(found[0], len(found[1].value), node_span(found[1]))
            if found is not None and ".*" in values and isinstance(found[1], yaml.SequenceNode):
                count = Setting(float(len(found[1].value)), node_span(found[1]))
        if joints is None and mapped:
            misspelt(mapped, out)
        for twice in self.refused[:1]:
            if any(one.entries == len(twice.value) for one in lists.values()):
                name_twice(twice, out)
        for key in STANDING if joints is not None else ():
            if key in block:
                # Compared with nothing, and the robot gets up by it all the same.
                self._per_joint(key, block[key], joints, out)
        if named is not None:
            name_twice(named, out, "which of its figures count is not known")
        stands_up = standing_up(scopes, out)
        ours = str(getattr(block.get("format"), "value", "")).startswith(OWN_FORMAT)
        if ours and joints is not None:
            fields.update(self._own_lists(block, joints))
        everything = {joint: None for values in fields.values() for joint in values}
        order = list(dict.fromkeys((*(joint for joint in joints or () if joint in everything), *everything)))
        groups = []
        for joint in order:
            own = {field: values[joint] for field, values in fields.items() if joint in values}
            groups.append(ActuatorGroup(joint, "deploy", next(iter(own.values())).span, (joint,), own))
        timing = block.get("timing")
        if ours and isinstance(timing, yaml.MappingNode):
            scopes = (self.mapping(timing), *scopes)
        settings = steps_of(scopes, out)
        if count is not None:
            settings["joint_count"] = count
        if joints is not None and names is not None:
            at = node_span(block.get("joint_mapping", node)) if elsewhere else next(iter(names.values()))
            settings["joint_order"] = Setting(joints, at, places=names)
        if ours:
            settings["sdk_order"] = self._sdk_order(block)
        nameless = {} if joints is not None else self._nameless(scopes, fields)
        config = RobotConfig(
            Framework.DEPLOY,
            name,
            node_span(node),
            tuple(groups),
            settings,
            notes=tuple(map(_of_fewer, out) if elsewhere else out),
            nameless=nameless,
            nameless_lists=lists,
            motors=motors,
            stands_up=stands_up,
            by_name=any(_ROS_PARAMETERS in scope for scope in above),
            mapped=names is not None and [*names] != [*(written or ())],
        )
        return config if joints is not None else called(config, called_so)

    def _nameless(
        self, scopes: Sequence[_Block], fields: Mapping[str, Any]
    ) -> dict[str, tuple[Setting, ...]]:
        """Gains of joints without names, whichever each is of: kp and kd of one length, as a pair may be a range."""
        lists = {field: nearest(scopes, self.keys[field]) for field in ("kp", "kd")}
        nodes = {field: found[1] for field, found in lists.items() if found is not None}
        counts = {len(node.value) if isinstance(node, yaml.SequenceNode) else 0 for node in nodes.values()}
        if len(nodes) < 2 or len(counts) > 1 or max(counts) < LEAST_JOINTS:
            return {}
        return {
            field: tuple(filter(None, map(setting_of, node.value)))
            for field, node in nodes.items()
            if field not in fields
        }

    def _own_lists(self, block: _Block, joints: tuple[str, ...]) -> Iterator[tuple[str, dict[str, Setting]]]:
        """The lists that only actspec writes: setting, and joint to its value."""
        for name, (key, part) in OWN_LISTS.items():
            node = block.get(key)
            if part:
                node = self.mapping(node).get(part) if isinstance(node, yaml.MappingNode) else None
            if not isinstance(node, yaml.SequenceNode) or len(node.value) != len(joints):
                continue
            found: dict[str, Setting] = {}
            for joint, item in zip(joints, node.value, strict=True):
                self._step(item)
                value = item.value if name == "command" else number_of(item)
                if isinstance(value, (str, float)):
                    found[joint] = Setting(value, node_span(item))
            yield name, found

    def _sdk_order(self, block: _Block) -> Setting:
        """The robot's numbering in a file that actspec wrote: names, None for a gap; empty: none is stated."""
        order = block.get("order")
        node = self.mapping(order).get("sdk") if isinstance(order, yaml.MappingNode) else None
        if not isinstance(node, yaml.SequenceNode):
            return Setting((), node_span(block["format"]))
        names: list[str | None] = []
        for item in node.value:
            self._step(item)
            if not isinstance(item, yaml.ScalarNode):
                return Setting((), node_span(node))
            names.append(None if item.tag == "tag:yaml.org,2002:null" else str(item.value))
        return Setting(tuple(names), node_span(node))

    def _names(self, block: _Block, above: tuple[_Block, ...]) -> dict[str, Span] | None:
        """The list of joint names that is nearest: in the block, above it, or in a mapping beside it."""
        for scope in (block, *reversed(above)):
            beside = [self.mapping(v) for v in scope.values() if isinstance(v, yaml.MappingNode)]
            for place in (scope, *beside):
                lists = [place.get(key) for key in NAMES]
                # What actspec writes: `order: {robot: [...]}`.
                order = place.get("order")
                if isinstance(order, yaml.MappingNode):
                    lists.append(self.mapping(order).get("robot"))
                found = next(filter(None, map(self._texts, lists)), None)
                if found:
                    return found
        return None

    def _texts(self, node: yaml.Node | None) -> dict[str, Span] | None:
        if not isinstance(node, yaml.SequenceNode) or not node.value:
            return None
        if len(node.value) > MOST_JOINTS and all(isinstance(item, yaml.ScalarNode) for item in node.value):
            raise Unfit(f"the list of joints has more than {MOST_JOINTS} names", position(node.start_mark))
        found: dict[str, Span] = {}
        for item in node.value:
            self._step(item)
            if not isinstance(item, yaml.ScalarNode) or item.tag != "tag:yaml.org,2002:str":
                return None
            found[str(item.value)] = node_span(item)
        if len(found) == len(node.value):
            return found
        # A name twice would put every later number on a wrong joint.
        self.refused.append(node)
        return None

    def _per_joint(
        self, key: str, node: yaml.Node, joints: tuple[str, ...] | None, out: Collector
    ) -> dict[str, Setting]:
        """Joint to its value; with `.*` for all joints where the names do not matter."""
        span = node_span(node)
        if joints is not None and not any(map(str.isdecimal, "".join(joints))):
            node = in_a_row(node, self.mapping, first=1)
        if isinstance(node, yaml.MappingNode):
            return self._by_name(key, node, joints, out)
        single = number_of(node)
        if single is not None:
            return {joint: Setting(single, span) for joint in joints or (".*",)}
        if not isinstance(node, yaml.SequenceNode):
            if is_meant_for_one(node) or is_empty(node):
                no_number(key, [("it", node)], out)
            return {}
        values: list[tuple[float | None, Span]] = []
        for item in node.value:
            self._step(item)
            values.append((number_of(item), node_span(item)))
        if joints is not None and len(joints) == len(values):
            no_number(key, [*zip(joints, node.value, strict=True)], out)
            return {
                joint: Setting(value, at)
                for joint, (value, at) in zip(joints, values, strict=True)
                if value is not None
            }
        first = values[0][0] if values else None
        if joints is not None:
            message = f"it has {many(len(values), 'value')} for {many(len(joints), 'joint name')}"
            help = f"the names are {listed(joints)}"
            if first is not None and len(values) > len(joints) and all(value == first for value, _ in values):
                # Whoever reads it takes the right one for each joint.
                out.info(LENGTH, f"{message}, all {first:g}", where=key, span=span, help=help)
                return {joint: Setting(first, span) for joint in joints}
            out.warning(LENGTH, message, where=key, span=span, help=help)
            return {}
        if first is not None and all(value == first for value, _ in values):
            return {".*": Setting(first, span)}
        if values:
            form = "by number," if node.tag.endswith(":map") else "a list"
            message = f"it is {form} without joint names: which joint a value belongs to is not guessed"
            help = f"add {names_wanted(self.motors, len(values))}"
            if self.motors is not None:
                help = f"name the env.yaml of its run with it, which has them, or {help}"
            if any(len(twice.value) == len(values) for twice in self.refused[:1]):
                message = message.replace("without joint names", "whose joint names have one twice")
                help = f"name each of its {len(values)} joints once"
            out.info(NAMELESS, message, where=key, span=span, help=help)
        return {}

    def _by_name(
        self, name: str, node: yaml.MappingNode, joints: tuple[str, ...] | None, out: Collector
    ) -> dict[str, Setting]:
        found: dict[str, Setting] = {}
        odd: dict[str, Setting] = {}
        block = self.mapping(node)
        if block.keys() <= _COMMANDS:
            return {}
        of_gains = name in self.keys["kp"] or name in self.keys["kd"]
        sides = by_side([*block.items()], joints) if joints is not None and of_gains else ""
        if sides:
            help = "write one list in the order of the joint names, or {JOINT: NUMBER, ...}"
            out.warning(NO_NUMBER, f"it has {sides}", where=name, span=node_span(node), help=help)
        else:
            # A mapping below is no joint's figure, but has some of its own.
            figures = [one for one in block.items() if not isinstance(one[1], yaml.MappingNode)]
            no_number(name, figures, out)
        for key, value_node in block.items():
            setting = setting_of(value_node)
            if setting is None:
                continue
            if joints is None or key in joints:
                found[key] = setting
            else:
                # A key is part of the joint's name, as legged_gym has it, or a pattern.
                fit = (one for one in joints if key in one or matching(Framework.ISAACLAB, key, [one]))
                own = dict.fromkeys(fit, setting)
                found = {**own, **found}
                odd.update({} if own else {key: setting})
        for key, setting in odd.items():
            meant = slip(key, (joint for joint in joints or () if joint not in found))
            if meant is not None:
                message = f"it has '{shortened(key)}', which is no joint of the list"
                help = f"did you mean '{shortened(meant)}'?"
                out.warning(MISSPELT, message, where=name, span=setting.span, help=help)
        return found

    def _step(self, node: yaml.Node) -> None:
        self.steps += 1
        if self.steps > MOST_STEPS:
            raise Unfit(f"it has more than {MOST_STEPS} values", position(node.start_mark))


def _of_fewer(note: Diagnostic) -> Diagnostic:
    """What is said of a list of fewer values than the robot has joints: a policy may move some of them alone."""
    few = note.code == LENGTH and note.where in PER_JOINT["action_scale"]
    return replace(note, severity=Severity.INFO) if few else note
