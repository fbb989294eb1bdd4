"""Isaac Lab's configurations, 2.x and 3.0: robots, loose actuators and environments, from folded values.

Settings keep the names of the version that they are written for; nothing is converted.
"""

from __future__ import annotations

from actspec.diagnostics import Span
from actspec.readings.artifact import Framework, RobotConfig
from actspec.readings.python.actions import take_action_scale, take_actions
from actspec.readings.python.settings import (
    Draft,
    Events,
    comes_from,
    fields_of,
    function_of,
    has_actuators,
    is_actuator,
    is_named,
)
from actspec.readings.python.values import (
    Cls,
    External,
    Obj,
    Seq,
    Table,
    Unknown,
    Value,
    ancestors,
    reason_of,
    unread_module,
)

_EVENTS: Events = {
    "randomize_actuator_gains": (
        {"stiffness_distribution_params": "kp", "damping_distribution_params": "kd"},
        "abs",
    ),
    "randomize_joint_parameters": (
        {
            "friction_distribution_params": "friction",
            "armature_distribution_params": "armature",
            "lower_limit_distribution_params": "lower_limit",
            "upper_limit_distribution_params": "upper_limit",
        },
        "abs",
    ),
    # Of whole_body_tracking: https://github.com/HybridRobotics/whole_body_tracking, tasks/tracking/mdp/events.py.
    "randomize_joint_default_pos": ({"pos_distribution_params": "joint_default_pos"}, "abs"),
}
"""What randomises actuators. Source: Isaac Lab 2.3.2, isaaclab/envs/mdp/events.py."""

_ROBOT = ("robot_cfg", "robot")
"""Fields of a scene, or of a direct task, that hold the robot."""


def is_mjlab(obj: Obj) -> bool:
    """Whether an object is mjlab's: by its class, or by a field that only mjlab's actuators have."""
    return comes_from(obj, "mjlab") or (
        "target_names_expr" in obj.fields and not comes_from(obj, "isaaclab", "omni")
    )


def is_group(value: Value) -> bool:
    """Whether a value is an actuator group of Isaac Lab."""
    data = value.data
    return isinstance(data, Obj) and is_actuator(value) and not is_mjlab(data)


def is_group_dict(value: Value) -> bool:
    """Whether a value is a dict of actuator groups, as `ArticulationCfg.actuators` takes it."""
    data = value.data
    return isinstance(data, Table) and bool(data.items) and all(is_group(one) for one in data.items.values())


def is_robot(value: Value) -> bool:
    """Whether a value is a robot's cfg: an `ArticulationCfg`, or an object that holds actuator groups by name."""
    data = value.data
    if not isinstance(data, Obj) or is_mjlab(data) or not has_actuators(data):
        return False
    return is_named(data, "ArticulationCfg") or is_group_dict(data.fields["actuators"])


def is_environment(value: Value) -> bool:
    """Whether a value is an environment's cfg."""
    data = value.data
    if not isinstance(data, Obj) or is_mjlab(data):
        return False
    return is_named(data, "EnvCfg") and bool(
        {"decimation", "sim", "actions", "scene", "events"} & set(data.fields)
    )


def is_events(value: Value) -> bool:
    """Whether a value holds event terms that randomise actuators, as a class `EventCfg` does."""
    data = value.data
    return (
        isinstance(data, Obj)
        and not comes_from(data, "mjlab")
        and any(function_of(term) in _EVENTS for term in fields_of(value).values())
    )


def robot(name: str, value: Value, span: Span) -> RobotConfig:
    """A robot's cfg, a dict of actuator groups, or one group alone."""
    draft = Draft()
    _robot(draft, name, value)
    return draft.config(Framework.ISAACLAB, name, span)


def environment(name: str, value: Value, span: Span, robot: str | None = None) -> RobotConfig:
    """An environment's cfg: step, decimation, action scale, randomisation, and its robot.

    Args:
        name: What it is called.
        value: It.
        span: Where it is.
        robot: Key of the robot that is meant, of those that `robots_in` has; None: the first, which has the ranges.
    """
    draft = Draft()
    fields = fields_of(value)
    draft.set("physics_dt", fields_of(fields.get("sim")).get("dt"))
    draft.set("decimation", fields.get("decimation"))
    if "actions" not in fields and "action_scale" in fields:
        take_action_scale(draft, value, fields["action_scale"])
    if robot in (None, *robots_in(value)[:1]):
        draft.events(fields.get("events"), _EVENTS)
    take_actions(draft, fields.get("actions"), _scene(draft, value, fields, robot))
    return draft.config(Framework.ISAACLAB, name, span)


def robots_in(value: Value) -> list[str]:
    """Keys of the robots of an environment's scene, or of itself in a direct task: the one that it is for first."""
    places = _places(fields_of(value))
    return [key for key in _candidates(places) if is_robot(places[key])]


def events(name: str, value: Value, span: Span) -> RobotConfig:
    """A class of event terms alone."""
    draft = Draft()
    draft.events(value, _EVENTS)
    return draft.config(Framework.ISAACLAB, name, span)


def _robot(draft: Draft, name: str, value: Value) -> None:
    if is_group(value):
        _group(draft, name, value)
        return
    fields = fields_of(value)
    actuators = fields.get("actuators") if isinstance(value.data, Obj) else value
    if actuators is not None:
        _groups(draft, actuators, value.span)
    if not isinstance(value.data, Obj):
        return
    draft.set("soft_joint_pos_limit_factor", fields.get("soft_joint_pos_limit_factor"))
    draft.pose(fields_of(fields.get("init_state")).get("joint_pos"))
    spawn = fields_of(fields.get("spawn"))
    draft.set("model", spawn.get("usd_path", spawn.get("asset_path")), "usd_path")
    # Of unitree_rl_lab: the robot's own order; https://github.com/unitreerobotics/unitree_rl_lab.
    order = fields.get("joint_sdk_names")
    if order is not None and isinstance(order.data, Seq):
        draft.set("joint_order", order)


def _groups(draft: Draft, actuators: Value, robot: Span) -> None:
    data = actuators.data
    parts = data.items if isinstance(data, Seq) else [actuators]
    if not parts or not all(isinstance(one.data, Table) or is_group(one) for one in parts):
        draft.note("actuators", reason_of(data) or "no dict of groups", actuators.span)
        return
    if wrong := _is_no_dict(actuators):
        # Read all the same: what is wrong with its figures would come to light one run later.
        what, help = wrong
        # One cfg may be written elsewhere, where nothing is wrong with it.
        place = robot if parts == [actuators] else actuators.span
        draft.refused("actuators", f"it is {what}, of which Isaac Lab cannot make the robot", place, help)
    for index, part in enumerate(parts):
        if not isinstance(part.data, Table):
            _group(draft, f"actuators[{index}]", part)
            continue
        if part.data.open is not None:
            draft.note("actuators", part.data.open, part.span)
        for key, one in part.data.items.items():
            if isinstance(one.data, Obj):
                _group(draft, str(key), one)
            elif one.data is not None:
                draft.note(f"actuators.{key}", reason_of(one.data) or "no actuator cfg", one.span)


def _is_no_dict(actuators: Value) -> tuple[str, str] | None:
    """What stands where Isaac Lab asks for the items of a dict of groups, and what to do; None for a dict.

    Source: Isaac Lab 2.3.2, articulation.py, `_process_actuators_cfg`.
    """
    data = actuators.data
    if isinstance(data, Table):
        return None
    if not isinstance(data, Seq):
        return "one actuator cfg and no dict of them", 'give it a name: `{"legs": cfg}`'
    dicts = sum(isinstance(one.data, Table) for one in data.items)
    if dicts == 0:
        return f"a {data.kind} of actuator cfgs and no dict of them", 'give each a name: `{"legs": cfg}`'
    if len(data.items) > 1:
        return f"a {data.kind} and no dict of actuator cfgs", "write one dict with all groups"
    comma = "take the comma behind the dict away" if data.kind == "tuple" else "write the dict alone"
    return f"a {data.kind} with one dict", comma


def _group(draft: Draft, name: str, value: Value) -> None:
    if isinstance(value.data, Obj):
        fields = dict(value.data.fields)
        draft.group(name, value.data, fields.pop("joint_names_expr", None), fields)


def _places(fields: dict[str, Value]) -> dict[str, Value]:
    return {**fields, **fields_of(fields.get("scene"))}


def _candidates(places: dict[str, Value]) -> list[str]:
    """Keys of what may be the robot: `robot`, and then every articulation."""
    first = [name for name in _ROBOT if name in places][:1]
    return first + [name for name, one in places.items() if name not in first and is_robot(one)]


def _scene(draft: Draft, value: Value, fields: dict[str, Value], robot: str | None) -> str:
    """The robot: `scene.robot`, else the first articulation of the scene or, in a direct task, of the cfg itself.

    Returns: Its key; "" where it is not known.
    """
    places = _places(fields)
    robots = _candidates(places) if robot is None else [robot]
    for name in robots:
        one = places[name]
        if is_robot(one):
            _robot(draft, name, one)
            for other in robots[1:]:
                if is_robot(places[other]):
                    draft.left_out(other, places[other].span)
            return name
        if isinstance(one.data, (Unknown, External)):
            draft.note(name, reason_of(one.data) or "", one.span)
        elif isinstance(one.data, Obj) and one.data.open is not None:
            draft.note(name, one.data.open, one.span)
    if not robots:
        classes = [one.data.cls for one in (fields.get("scene"), value) if one and isinstance(one.data, Obj)]
        draft.robot_missing = next(filter(None, map(_missing_robot, classes)), None)
    if not robots and "scene" in fields and (why := _unread_scene(fields["scene"])):
        draft.note("scene", why, fields["scene"].span)
    return ""


def _missing_robot(cls: Cls | External) -> Span | None:
    """The class that leaves its robot to those that are derived from it."""
    for one in ancestors(cls) if isinstance(cls, Cls) else ():
        names = one.scope.names if isinstance(one, Cls) else {}
        held = [names[name] for name in _ROBOT if name in names]
        if isinstance(one, Cls) and any(
            isinstance(value, Value) and isinstance(value.data, External) and value.data.name == "MISSING"
            for value in held
        ):
            return one.span
    return None


def _unread_scene(scene: Value) -> str:
    """Why the robot of a scene is not known; "" where it has none."""
    if isinstance(scene.data, (Unknown, External)):
        return reason_of(scene.data) or ""
    if not isinstance(scene.data, Obj) or unread_module(scene.data.cls) is None:
        return ""
    cls = scene.data.cls
    known = [cls] if isinstance(cls, External) else ancestors(cls)
    return next((one.reason for one in known if isinstance(one, External)), "")
