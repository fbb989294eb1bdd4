"""Terms of an environment's actions, of Isaac Lab and mjlab: which joints each is for, and what it makes of an action.

Source: Isaac Lab 2.2.0 and 2.3.2, isaaclab/envs/mdp/actions/ (`actions_cfg.py`, `joint_actions.py`,
`joint_actions_to_limits.py`); mjlab 1.6.0, mjlab/envs/mdp/actions/actions.py. Measured in
tests/frameworks/test_actions.py.
"""

from __future__ import annotations

from actspec.readings.artifact import ActionTerm, Setting
from actspec.readings.python.direct import scales_positions
from actspec.readings.python.settings import Draft, comes_from, fields_of, known, setting, texts
from actspec.readings.python.values import Cls, External, Obj, Unknown, Value, class_names, reason_of

_COMMANDS = {
    "JointPositionActionCfg": "position",
    "JointVelocityActionCfg": "velocity",
    "JointEffortActionCfg": "effort",
}
"""Classes whose command is offset + scale x action, to what they command."""

_RELATIVE = "RelativeJointPositionActionCfg"
_LIMITS = ("EMAJointPositionToLimitsActionCfg", "JointPositionToLimitsActionCfg")

_JOINTS = ("joint_names", "actuator_names")
"""Fields that select a term's joints, of Isaac Lab and of mjlab."""

_ROBOT = ("asset_name", "entity_name")
"""Fields that say whose joints they are."""

_FIRST = "robot"
"""What both frameworks call the robot of a scene."""


def take_actions(draft: Draft, actions: Value | None, robot: str) -> None:
    """Take the terms that command joints.

    Args:
        draft: Gets them, and notes.
        actions: The terms, an object or a dict; None: there are none.
        robot: Key of the robot in the scene; "" where it is not known. Terms of another one are left out.
    """
    if actions is None:
        return
    if isinstance(actions.data, (Unknown, External)):
        draft.note("actions", reason_of(actions.data) or "", actions.span)
        return
    found = [
        (_robot_of(one), term)
        for name, one in fields_of(actions).items()
        if (term := _term(draft, name, one))
    ]
    if not found:
        for name, one in fields_of(actions).items():
            # A class of the author's own that finds its joints itself: the policy drives the robot by that alone.
            if isinstance(one.data, Obj):
                why = f"{one.data.cls.name} makes the command in a way of its own, and names no joints"
                draft.note(f"actions.{name}", why, one.span)
    named = {whose for whose, _ in found}
    own = next((name for name in (robot, _FIRST) if name in named), None)
    draft.actions.extend(term for whose, term in found if own is None or whose in (own, None))


def take_action_scale(draft: Draft, task: Value, value: Value) -> None:
    """Take `action_scale` of a direct task, which has no terms: a name of its author, of whatever its code does.

    Args:
        draft: Gets it as a term for all joints, and notes.
        task: The task's cfg.
        value: Its field.
    """
    cls = task.data.cls if isinstance(task.data, Obj) else None
    scale = setting(value)
    if scale.unknown is not None:
        draft.note("action_scale", scale.unknown, scale.span)
    name, why = "" if cls is None else cls.name, ""
    if not isinstance(cls, Cls) or not scales_positions(cls.scope.source.tree):
        size = ""
        if scale.number is not None:
            size = f" = {scale.number:g}"
            draft.entries["action_scale"] = scale
        why = f"what the environment's code makes of {name}.action_scale{size} is not known"
    command = None if why else "position"
    draft.actions.append(ActionTerm("action_scale", name, None, command, why, scale, None, None, task.span))


def _robot_of(value: Value) -> str | None:
    """Key of the robot that a term is for; None where it is not known."""
    fields = fields_of(value)
    found = next((known(fields[name]) for name in _ROBOT if name in fields), None)
    return found if isinstance(found, str) else None


def _term(draft: Draft, name: str, value: Value) -> ActionTerm | None:
    """A term that commands joints; None for any other."""
    obj, fields = value.data, fields_of(value)
    if not isinstance(obj, Obj):
        return None
    opened = isinstance(obj.cls, External) and obj.cls.dotted.startswith("?.")
    joints = next((fields[key] for key in _JOINTS if key in fields), None)
    stock = next((one for one in class_names(obj.cls) if one in (*_COMMANDS, _RELATIVE, *_LIMITS)), None)
    if joints is None and stock is None and not opened:
        return None
    cls = "" if opened else obj.cls.name
    # A class of another law may take anything.
    scale = _figure(draft, name, "scale", fields.get("scale"), judged=stock is not None)
    if scale is None and not opened and obj.open is None and comes_from(obj, "isaaclab", "omni", "mjlab"):
        # The default of all these classes.
        scale = Setting(1.0, obj.span)
    command, why = _command_by_name(name) if opened else _command(obj, stock, fields, scale)
    patterns = None if joints is None else texts(joints)
    if joints is not None and patterns is None:
        draft.note(f"actions.{name}", "its joints are no texts that are known", joints.span)
    return ActionTerm(
        name,
        cls,
        patterns,
        command,
        why,
        scale,
        _zero(draft, name, stock, fields),
        setting(fields["clip"]) if "clip" in fields and fields["clip"].data is not None else None,
        obj.span,
        known(fields.get("preserve_order")) is True,
    )


def _figure(
    draft: Draft, term: str, name: str, value: Value | None, *, judged: bool = True
) -> Setting | None:
    """A number, or numbers by pattern, of a term; None where nobody writes one.

    Args:
        draft: Gets notes.
        term: Its name.
        name: Of its field.
        value: Of that.
        judged: Whether the class takes nothing else, so that anything else is told.
    """
    if value is None:
        return None
    found = setting(value)
    if found.unknown is not None:
        draft.note("action_scale" if name == "scale" else f"actions.{term}.{name}", found.unknown, found.span)
        return found
    return draft.figure(f"actions.{term}.{name}", found) if judged else found


def _command(
    obj: Obj, stock: str | None, fields: dict[str, Value], scale: Setting | None
) -> tuple[str | None, str]:
    """What a term commands; None where that is no multiple of the action, and why."""
    cls = obj.cls.name
    made = fields.get("class_type")
    own = made.data.name if made is not None and isinstance(made.data, (Cls, External)) else None
    if stock is None or (own is not None and f"{own}Cfg" != stock):
        return None, f"{cls} makes the command in a way of its own"
    if stock == _RELATIVE:
        size = "scale" if scale is None or scale.number is None else f"{scale.number:g}"
        return None, f"{cls}: the command is the position now + {size} x action"
    if stock in _LIMITS:
        if known(fields.get("rescale_to_limits")) is not False:
            return None, f"{cls}: actions of -1 and 1 are the ends of the joint's range"
        if stock == _LIMITS[0]:
            return None, f"{cls}: the command is a moving average"
        return "position", ""
    return _COMMANDS[stock], ""


def _command_by_name(name: str) -> tuple[str, str]:
    """What a term commands whose class is not read. Chosen: Isaac Lab's own are `joint_pos`, `joint_vel`, ..."""
    if "vel" in name:
        return "velocity", ""
    return ("effort", "") if "effort" in name or "torque" in name else ("position", "")


def _zero(draft: Draft, name: str, stock: str | None, fields: dict[str, Value]) -> Setting | None:
    """The command at zero action, where that is a number of the term: `use_default_offset` takes the robot's."""
    flag = fields.get("rescale_to_limits" if stock in _LIMITS else "use_default_offset")
    if stock in _LIMITS:
        return None if flag is None else Setting(0.0, flag.span)
    if stock != "JointEffortActionCfg":
        if flag is None or known(flag) is True:
            return None
        if known(flag) is None:
            return Setting(None, flag.span, "whether it adds the default position is not known")
    offset = _figure(draft, name, "offset", fields.get("offset"))
    return Setting(0.0, flag.span) if offset is None and flag is not None else offset
