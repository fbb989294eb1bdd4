"""`params/env.yaml` of a run of Isaac Lab or mjlab: the environment's configuration as it was trained with.

Both write it when a training begins, with all defaults filled in. Isaac Lab names classes and functions by text
(`isaaclab.actuators.actuator_pd:DCMotor`); mjlab names functions by YAML tags, and leaves out which class an actuator
or an action has. Nothing is constructed: tags are names here. What is read goes the way of a Python configuration.

Source: Isaac Lab 2.3.2, isaaclab/utils/io/yaml.py and utils/dict.py (`class_to_dict`); mjlab 1.6.0,
mjlab/scripts/train.py and utils/os.py; 91 such files of strangers.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import PurePosixPath
from typing import Any

import yaml

from actspec.diagnostics import Collector
from actspec.readings.artifact import ActuatorGroup, Artifact, FileKind, FileReading, RobotConfig
from actspec.readings.python import isaaclab, mjlab
from actspec.readings.python.settings import UNFOLDED
from actspec.readings.python.values import Data, External, Key, Obj, Scalar, Seq, Table, Unknown, Value
from actspec.readings.twice import keys_twice
from actspec.readings.yaml_nodes import node_span
from actspec.robot.view import ModelFile
from actspec.simulators.classes import MJLAB

_YAML = "tag:yaml.org,2002:"
_PYTHON = f"{_YAML}python/"

_CALLABLE = re.compile(r"([A-Za-z_][\w.]*):([A-Za-z_]\w*)")
"""How Isaac Lab writes a class or a function."""

_BY_FIELDS = (
    ({"network_file"}, "LearnedMlpActuatorCfg"),
    ({"motor_params"}, "BuiltinDcMotorActuatorCfg"),
    ({"saturation_effort", "velocity_limit"}, "DcMotorActuatorCfg"),
    ({"stiffness", "damping", "effort_limit"}, "BuiltinPositionActuatorCfg"),
    ({"damping", "effort_limit"}, "BuiltinVelocityActuatorCfg"),
    ({"effort_limit", "gear"}, "BuiltinMotorActuatorCfg"),
    ({"command_field"}, "XmlActuatorCfg"),
)
"""Fields to the class of mjlab's that has them, the first that fits. Three have those of a position drive, and one law:
all of mjlab's own robots have the one that is taken. Source: mjlab 1.6.0, mjlab/actuator/."""

_ROBOT = "robot"
"""Key of a scene's robot where there is one; what stands beside it is another's, or a door."""

_ONE_OF_THREE = "BuiltinPositionActuatorCfg"
_UNSAID = (
    f"position drives are taken for {_ONE_OF_THREE}: a run's file has their figures and not their class, and "
    "BuiltinPdActuatorCfg and IdealPdActuatorCfg have the same"
)


def read_run(file: ModelFile, root: yaml.Node) -> FileReading | None:
    """Read the configuration of a run; None where it is none.

    Args:
        file: It.
        root: Its nodes.
    """
    keys = _keys(root)
    if not {"scene", "sim", "decimation"} <= set(keys):
        return None
    of_isaaclab = _is_isaaclab(keys)
    if not of_isaaclab and not _keys(_keys(keys["scene"]).get("entities")):
        return None
    artifacts = tuple(
        Artifact(file.path, FileKind.CFG, config.name, config=config)
        for config in _configs(root, of_isaaclab)
    )
    return FileReading(file.path, FileKind.CFG, None, artifacts, (file,), keys_twice(root), record=True)


def _keys(node: yaml.Node | None) -> dict[str, yaml.Node]:
    """A mapping's values by key; {} for anything else."""
    if not isinstance(node, yaml.MappingNode):
        return {}
    return {key.value: value for key, value in node.value if isinstance(key, yaml.ScalarNode)}


def _is_isaaclab(keys: Mapping[str, yaml.Node]) -> bool:
    """Whether the scene, or in a direct task the configuration itself, has a robot of Isaac Lab."""
    return any(
        {"actuators", "class_type"} <= set(_keys(one))
        for one in (*_keys(keys["scene"]).values(), *keys.values())
    )


def _configs(root: yaml.Node, of_isaaclab: bool) -> Iterator[RobotConfig]:
    """Each robot of the scene, the one that the task is for first; what has none is one, too."""
    whole = _Folder().value(root)
    whole = whole if of_isaaclab else _of_mjlab(whole)
    robots: list[str] = isaaclab.robots_in(whole) if of_isaaclab else mjlab.robots_in(whole)
    every: list[str | None] = [*robots] or [None]
    for robot in every:
        if of_isaaclab:
            found = isaaclab.environment("", whole, whole.span, robot)
        else:
            found = mjlab.environment("", whole, whole.span, lambda maker: maker, {}, robot)
            unsaid = Collector()
            for group in [group for group in found.groups if group.cls == _ONE_OF_THREE][:1]:
                unsaid.info(UNFOLDED, _UNSAID, where="actuators", span=group.span)
            groups = tuple(replace(group, own=_own(group)) for group in found.groups)
            found = replace(found, groups=groups, notes=(*found.notes, *unsaid))
        name = PurePosixPath((found.model or "").replace("\\", "/")).stem
        if robot is not None and len(robots) > 1 and robot != _ROBOT:
            # Two arms of one file have their keys alone to tell them by.
            name = f"{name}.{robot}" if name else robot
        yield replace(found, name=name or "robot")


def _own(group: ActuatorGroup) -> tuple[str, ...]:
    """Settings that no class of mjlab's has: the group's was somebody's own."""
    known = frozenset().union(*(cls.fields for cls in MJLAB.values()))
    return tuple(name for name in group.settings if name not in known)


def _of_mjlab(whole: Value) -> Value:
    """With the classes that mjlab leaves out; of actions nobody knows them."""

    def inside(value: Value | None, change: Callable[[Value], Value]) -> None:
        data = None if value is None else value.data
        if isinstance(data, Table):
            data.items.update({key: change(one) for key, one in data.items.items()})
        elif isinstance(data, Seq):
            data.items[:] = [change(one) for one in data.items]

    def at(value: Value | None, *keys: str) -> Value | None:
        for key in keys:
            value = value.data.items.get(key) if value is not None and isinstance(value.data, Table) else None
        return value

    def entity(value: Value) -> Value:
        inside(at(value, "articulation", "actuators"), _actuator)
        if isinstance(value.data, Table) and (held := at(value, "articulation")) is not None:
            value.data.items["articulation"] = _made(held, "mjlab.entity.EntityArticulationInfoCfg")
        return _made(value, "mjlab.entity.EntityCfg")

    inside(at(whole, "scene", "entities"), entity)
    inside(at(whole, "actions"), lambda one: _made(one, "?.unnamed"))
    return whole


def _actuator(value: Value) -> Value:
    fields = set(value.data.items) if isinstance(value.data, Table) else set()
    cls = next((cls for own, cls in _BY_FIELDS if own <= fields), "ActuatorCfg")
    return _made(value, f"mjlab.actuator.{cls}")


def _made(value: Value, cls: str) -> Value:
    """A mapping as an object of a class; anything else as it is."""
    if not isinstance(value.data, Table):
        return value
    fields = {key: one for key, one in value.data.items.items() if isinstance(key, str)}
    return Value(Obj(External(cls), fields, [], value.span), value.span)


class _Folder:
    """Makes values of the nodes of one file, each once."""

    def __init__(self) -> None:
        self.made: dict[int, Value] = {}

    def value(self, node: yaml.Node) -> Value:
        """A node and what is in it; an alias shares what its anchor is."""
        if id(node) not in self.made:
            span = node_span(node)
            if isinstance(node, yaml.MappingNode):
                self._mapping(node)
            elif isinstance(node, yaml.SequenceNode) and node.tag in (f"{_YAML}seq", f"{_PYTHON}tuple"):
                items: list[Value] = []
                self.made[id(node)] = Value(Seq(items, "tuple"), span)
                items.extend(map(self.value, node.value))
            else:
                self.made[id(node)] = Value(_scalar(node), span)
        return self.made[id(node)]

    def _mapping(self, node: yaml.MappingNode) -> None:
        span = node_span(node)
        keys = _keys(node)
        cls = _class_of(node, keys)
        items: dict[Key, Value] = {}
        data = Table(items) if cls is None else Obj(External(cls), {}, [], span)
        self.made[id(node)] = Value(data, span)
        fields = items if isinstance(data, Table) else data.fields
        for key, one in keys.items():
            made = self.value(one)
            if key in ("class_type", "func") and isinstance(made.data, str):
                made = Value(_callable(made.data), made.span)
            fields[key] = made


def _class_of(node: yaml.MappingNode, keys: Mapping[str, yaml.Node]) -> str | None:
    """Class of the cfg that a mapping was: Isaac Lab's `class_type` names what the cfg is for."""
    if node.tag.startswith(f"{_PYTHON}object:"):
        return str(node.tag.removeprefix(f"{_PYTHON}object:"))
    made = keys.get("class_type")
    if not isinstance(made, yaml.ScalarNode) or not _CALLABLE.fullmatch(made.value):
        return None
    return f"{made.value.replace(':', '.')}Cfg"


def _callable(text: str) -> Data:
    return External(text.replace(":", ".")) if _CALLABLE.fullmatch(text) else text


def _scalar(node: yaml.Node) -> Scalar | External | Unknown:
    """A number, text, truth value or None; a name of Python's for a tag that is one."""
    if node.tag.startswith(f"{_PYTHON}name:"):
        return External(node.tag.removeprefix(f"{_PYTHON}name:"))
    if isinstance(node, yaml.ScalarNode) and node.tag.removeprefix(_YAML) in (
        "int",
        "float",
        "bool",
        "null",
        "str",
    ):
        construct: Any = yaml.constructor.SafeConstructor()
        try:
            found: Scalar = construct.construct_object(node)
        except (ValueError, OverflowError):
            return Unknown("it is no number that can be read")
        return found
    applied = node.tag.removeprefix(f"{_PYTHON}object/apply:")
    if isinstance(node, yaml.SequenceNode) and applied != node.tag:
        given: list[yaml.Node] = node.value
        if len(given) == 1 and isinstance(given[0], yaml.ScalarNode):
            # A member of an enumeration, by its value: `TransmissionType` of `joint`.
            return External(f"{applied}.{given[0].value.upper()}")
    return Unknown(f"an object of Python's, {node.tag.removeprefix(_PYTHON)}")
