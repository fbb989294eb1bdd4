"""mjlab's configurations: articulations, entities and environments, from folded values.

Settings keep mjlab's names; nothing is converted.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Mapping

from actspec.diagnostics import Span
from actspec.readings.artifact import Framework, RobotConfig
from actspec.readings.config import VOLTS
from actspec.readings.python.actions import take_actions
from actspec.readings.python.isaaclab import is_mjlab
from actspec.readings.python.settings import (
    UNFOLDED,
    Draft,
    Events,
    comes_from,
    fields_of,
    function_of,
    has_actuators,
    is_actuator,
    is_named,
)
from actspec.readings.python.values import External, Func, Obj, Seq, Table, Unknown, Value, reason_of

_EVENTS: Events = {
    "pd_gains": ({"kp_range": "kp", "kd_range": "kd"}, "scale"),
    "effort_limits": ({"effort_limit_range": "effort_limit"}, "scale"),
    "encoder_bias": ({"bias_range": "encoder_bias"}, "add"),
    "joint_armature": ({"ranges": "armature"}, "abs"),
    "dof_armature": ({"ranges": "armature"}, "abs"),
    "joint_friction": ({"ranges": "friction"}, "abs"),
    "dof_frictionloss": ({"ranges": "friction"}, "abs"),
    "joint_damping": ({"ranges": "joint_damping"}, "abs"),
    "dof_damping": ({"ranges": "joint_damping"}, "abs"),
    "joint_stiffness": ({"ranges": "joint_stiffness"}, "abs"),
    "joint_default_pos": ({"ranges": "joint_default_pos"}, "add"),
}
"""What randomises actuators. Source: mjlab 1.6.0, mjlab/envs/mdp/dr/."""

Call = Callable[[Value], Value]
"""Calls a function without arguments."""


def is_articulation(value: Value) -> bool:
    """Whether a value is an `EntityArticulationInfoCfg` with actuators."""
    data = value.data
    return isinstance(data, Obj) and is_named(data, "EntityArticulationInfoCfg") and has_actuators(data)


def is_entity(value: Value) -> bool:
    """Whether a value is an `EntityCfg` with an articulation."""
    return (
        isinstance(value.data, Obj)
        and is_named(value.data, "EntityCfg")
        and "articulation" in value.data.fields
        and is_articulation(value.data.fields["articulation"])
    )


def is_group(value: Value) -> bool:
    """Whether a value is an actuator cfg of mjlab."""
    data = value.data
    return isinstance(data, Obj) and is_actuator(value) and is_mjlab(data)


def is_environment(value: Value) -> bool:
    """Whether a value is an environment's cfg."""
    data = value.data
    return isinstance(data, Obj) and is_named(data, "EnvCfg") and comes_from(data, "mjlab")


def is_events(value: Value) -> bool:
    """Whether a value is a dict of event terms that randomise actuators."""
    terms = () if isinstance(value.data, Obj) else fields_of(value).values()
    return any(function_of(term) in _EVENTS for term in terms)


def articulation(
    name: str, value: Value, entity: Value | None, call: Call, names: Mapping[int, str]
) -> RobotConfig:
    """An articulation, or one actuator cfg alone.

    Args:
        name: Of the constant or function that has it.
        value: It.
        entity: The one `EntityCfg` that uses it; None when there is none.
        call: For its `spec_fn`, which tells the model.
        names: Names of objects by identity, for the groups.
    """
    draft = Draft()
    if is_group(value):
        _group(draft, name, value)
    else:
        _articulation(draft, value, names)
    _entity(draft, entity, call)
    span = value.data.span if isinstance(value.data, Obj) else value.span
    return draft.config(Framework.MJLAB, name, span)


def environment(
    name: str, value: Value, span: Span, call: Call, names: Mapping[int, str], robot: str | None = None
) -> RobotConfig:
    """An environment's cfg: step, decimation, action scale, randomisation, and its robot.

    Args:
        name: What it is called.
        value: It.
        span: Where it is.
        call: As in `articulation`.
        names: Likewise.
        robot: Key of the robot that is meant, of those that `robots_in` has; None: the first, which has the ranges.
    """
    draft = Draft()
    fields = fields_of(value)
    mujoco = fields_of(fields_of(fields.get("sim")).get("mujoco"))
    draft.set("physics_dt", mujoco.get("timestep"))
    draft.set("decimation", fields.get("decimation"))
    robots = robots_in(value)
    if robot in (None, *robots[:1]):
        draft.events(fields.get("events"), _EVENTS)
    entities = _entities(value)
    own = robot if robot is not None else next(iter(robots), "")
    take_actions(draft, fields.get("actions"), own)
    for key, one in entities.items():
        if isinstance(one.data, (Unknown, External)):
            draft.note(f"scene.entities.{key}", reason_of(one.data) or "", one.span)
    if own:
        _articulation(draft, fields_of(entities[own])["articulation"], names)
        _entity(draft, entities[own], call)
    for other in robots[1:] if robot is None else ():
        draft.left_out(f"scene.entities.{other}", entities[other].span)
    return draft.config(Framework.MJLAB, name, span)


def robots_in(value: Value) -> list[str]:
    """Keys of the robots of an environment's scene."""
    return [key for key, one in _entities(value).items() if is_entity(one)]


def _entities(value: Value) -> dict[str, Value]:
    return fields_of(fields_of(fields_of(value).get("scene")).get("entities"))


def events(name: str, value: Value, span: Span) -> RobotConfig:
    """A dict of event terms alone."""
    draft = Draft()
    draft.events(value, _EVENTS)
    return draft.config(Framework.MJLAB, name, span)


def _articulation(draft: Draft, value: Value, names: Mapping[int, str]) -> None:
    fields = fields_of(value)
    draft.set("soft_joint_pos_limit_factor", fields.get("soft_joint_pos_limit_factor"))
    actuators = fields.get("actuators")
    if actuators is None:
        return
    several = actuators.data.items if isinstance(actuators.data, Seq) else ()
    if is_group(actuators):
        # Read all the same: what is wrong with its figures would come to light one run later.
        draft.refused(
            "actuators",
            "it is one actuator cfg and no tuple of them, of which mjlab cannot make the robot",
            value.span,
            "add a comma behind it: `(cfg,)`",
        )
        several = [actuators]
    elif isinstance(actuators.data, Table) and actuators.data.items:
        draft.refused(
            "actuators",
            "it is a dict and no tuple of actuator cfgs, of which mjlab cannot make the robot",
            actuators.span,
            "write the cfgs alone: `(cfg,)`",
        )
        several = [*actuators.data.items.values()]
    elif not isinstance(actuators.data, Seq):
        draft.note("actuators", reason_of(actuators.data) or "no sequence of cfgs", actuators.span)
    for index, one in enumerate(several):
        place = f"actuators[{index}]"
        if isinstance(one.data, Obj):
            _group(draft, names.get(id(one.data), place), one)
        else:
            draft.note(place, reason_of(one.data) or "no actuator cfg", one.span)


def _group(draft: Draft, name: str, value: Value) -> None:
    if not isinstance(value.data, Obj):
        return
    fields = dict(value.data.fields)
    # mjlab 1.0 to 1.2 wrapped an actuator to delay it.
    inner = fields.pop("base_cfg", None)
    if inner is not None and isinstance(inner.data, Obj):
        fields = {**inner.data.fields, **fields, "base_cfg": Value(inner.data.cls.name, inner.data.span)}
    joints = fields.pop("target_names_expr", None) or fields.pop("joint_names_expr", None)
    if is_named(value.data, "BuiltinDcMotorActuatorCfg"):
        for gain in ("stiffness", "damping"):
            if gain in fields:
                said = f"{gain} is unknown at the joint: it is {VOLTS}"
                draft.notes.info(UNFOLDED, said, where=f"{name}.{gain}", span=fields[gain].span)
    draft.group(name, value.data, joints, fields)


def _entity(draft: Draft, entity: Value | None, call: Call) -> None:
    fields = fields_of(entity)
    draft.pose(fields_of(fields.get("init_state")).get("joint_pos"))
    maker = fields.get("spec_fn")
    if maker is not None and isinstance(maker.data, Func):
        draft.edited = frozenset(_called_and_set(maker.data, set()))
        made = call(maker).data
        if isinstance(made, Obj) and made.cls.name == "from_file":
            draft.set("model", made.args[0], "file")


def _called_and_set(function: Func, seen: set[str]) -> Iterator[str]:
    """Names of the methods that a function calls and of the attributes that it sets; those of its file's own too.

    By its text: a loop over what the model has is not folded.
    """
    seen.add(function.name)
    for node in ast.walk(function.node):
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield node.attr
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            yield node.func.attr
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            own = function.scope.module.names.get(node.func.id)
            if isinstance(own, Value) and isinstance(own.data, Func) and own.data.name not in seen:
                yield from _called_and_set(own.data, seen)
