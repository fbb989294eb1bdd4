"""Objects of a running program as readings: a compiled MuJoCo model, a cfg of Isaac Lab or mjlab.

A cfg becomes what the reader of `.py` files folds its text to, and is read by the same functions. Its place is the
way to it: `ArticulationCfg.actuators['legs'].stiffness`.
"""

from __future__ import annotations

import dataclasses
import math
import sys
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import Span
from actspec.readings.artifact import Artifact, FileKind, FileReading
from actspec.readings.python import isaaclab, mjlab
from actspec.readings.python.settings import fields_of
from actspec.readings.python.values import MAX_NESTING, Data, External, Obj, Seq, Table, Unknown, Value

if TYPE_CHECKING:
    from actspec.readings.artifact import RobotConfig

_FRAMEWORKS = ("isaaclab", "mjlab")


def read_live(thing: object) -> tuple[FileReading, ...]:
    """The robot that an object describes; behind it the model that an entity of mjlab is made from.

    Args:
        thing: `mujoco.MjModel` or `MjSpec`; of Isaac Lab an `ArticulationCfg` or its `actuators`; of mjlab an
            `EntityCfg`, an `EntityArticulationInfoCfg`, or an `Entity`, whose `spec` is taken.

    Returns: Named after the object's class; empty for any other object.
    """
    name = "actuators" if isinstance(thing, Mapping) else type(thing).__name__
    model = _compiled(thing)
    if model is not None:
        from actspec.robot.read_mjcf import read_model

        view = read_model(model, name)
        return (_reading(Artifact(name, FileKind.MJCF, view.name, robot=view)),)
    spec = getattr(thing, "spec", None)
    if _compiled(spec) is not None:
        return read_live(spec)
    value = folded(thing, name)
    if mjlab.is_entity(value):
        articulation = fields_of(value)["articulation"]
        config = mjlab.articulation(name, articulation, value, lambda maker: maker, {})
        make = getattr(thing, "spec_fn", None)
        return (_reading(_artifact(name, config)), *(read_live(make()) if callable(make) else ()))
    if mjlab.is_articulation(value) or mjlab.is_group(value):
        config = mjlab.articulation(name, value, None, lambda maker: maker, {})
        return (_reading(_artifact(name, config)),)
    if isaaclab.is_robot(value) or isaaclab.is_group_dict(value) or isaaclab.is_group(value):
        return (_reading(_artifact(name, isaaclab.robot(name, value, value.span))),)
    return ()


def _compiled(thing: object) -> Any:
    """The compiled model of a MuJoCo object; None for any other. A spec is compiled as a copy."""
    mujoco = sys.modules.get("mujoco")
    if mujoco is None or not isinstance(thing, mujoco.MjModel | mujoco.MjSpec):
        return None
    return thing.copy().compile() if isinstance(thing, mujoco.MjSpec) else thing


def _artifact(name: str, config: RobotConfig) -> Artifact:
    return Artifact(name, FileKind.CFG, name, config=config)


def _reading(artifact: Artifact) -> FileReading:
    return FileReading(artifact.path, artifact.kind, None, (artifact,))


def folded(thing: object, place: str, depth: int = 0) -> Value:
    """An object as the reader of Python files has it.

    Args:
        thing: The object.
        place: The way to it.
        depth: How many objects it is within.
    """
    span = Span(place)
    if depth > MAX_NESTING:
        return Value(Unknown(f"nested deeper than {MAX_NESTING}"), span)
    return Value(_data(thing, place, depth + 1), span)


def _data(thing: Any, place: str, depth: int) -> Data:
    if thing is None or isinstance(thing, bool | int | str):
        return thing
    if isinstance(thing, float):
        return thing if not math.isnan(thing) else Unknown("not a number")
    if isinstance(thing, Mapping):
        return Table({key: folded(one, f"{place}[{key!r}]", depth) for key, one in thing.items()})
    if isinstance(thing, list | tuple | set | frozenset):
        kind = "list" if isinstance(thing, list) else "tuple"
        return Seq([folded(one, f"{place}[{at}]", depth) for at, one in enumerate(thing)], kind)
    if isinstance(thing, type) or (callable(thing) and hasattr(thing, "__qualname__")):
        return External(f"{thing.__module__}.{thing.__qualname__}")
    if dataclasses.is_dataclass(thing) or type(thing).__name__.endswith("Cfg"):
        fields = {name: folded(one, f"{place}.{name}", depth) for name, one in _fields(thing)}
        return Obj(_class(type(thing)), fields, [], Span(place))
    if getattr(thing, "size", None) == 1 and callable(getattr(thing, "item", None)):
        return _data(thing.item(), place, depth)
    return Unknown(f"a {type(thing).__name__}, which is not read")


def _fields(thing: object) -> Iterator[tuple[str, object]]:
    """Fields that are set: neither None nor `MISSING`, which leave the number to others."""
    for name, one in vars(thing).items():
        if one is not None and one is not dataclasses.MISSING and not name.startswith("_"):
            yield name, one


def _class(cls: type) -> External:
    """The class of a framework that a class is or derives from, else itself."""
    known = (one for one in cls.__mro__ if one.__module__.partition(".")[0] in _FRAMEWORKS)
    own = next(known, cls)
    return External(f"{own.__module__}.{own.__qualname__}")
