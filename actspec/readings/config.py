"""Configurations, joint by joint: what their actuator classes make of the settings that are written, and the ledger's
rows of that.

A configuration speaks in patterns; which joints they mean, and the joints' inertia, come from the model that it is
paired with. Without one, each pattern is a row of its own, under the joint's name where it means one.

Source for the rules by framework and version: Isaac Lab 2.2.0 and 2.3.2 classes, mjlab 1.6.0 classes,
legged_gym's `_compute_torques`; measured.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from actspec.fields import FIELDS
from actspec.joints import JointKind
from actspec.readings.actions import acted, command_of
from actspec.readings.artifact import (
    NETWORK,
    PHYSX,
    ActuatorGroup,
    Artifact,
    FileKind,
    Framework,
    RobotConfig,
    Setting,
)
from actspec.readings.called import agreement
from actspec.readings.dict_keys import Found, may_match, plain_name, settled, value_of
from actspec.readings.isaaclab import has_curve, idle_speeds, settle_friction, take_curve, take_limits
from actspec.readings.joint import total
from actspec.readings.joint_names import fits, joint_names, matching
from actspec.readings.ledger import LedgerRow, dynamics_at
from actspec.readings.overlap import has_last, last_of_each, left_by, taken_by
from actspec.readings.versions import Versions, is_native
from actspec.robot.view import JointInertia, JointView, ModelFormat, RobotView

_OF_EVERY = {"kp": "stiffness", "kd": "damping", "armature": "armature"}

_FIELDS: dict[Framework, dict[str, str]] = {
    Framework.ISAACLAB: {
        **_OF_EVERY,
        "joint_damping": "viscous_friction",
        "stall_torque": "saturation_effort",
    },
    Framework.MJLAB: {
        **_OF_EVERY,
        "effort_limit": "effort_limit",
        "frictionloss": "frictionloss",
        "joint_damping": "viscous_damping",
        "stall_torque": "saturation_effort",
    },
    Framework.LEGGED_GYM: _OF_EVERY,
    Framework.DEPLOY: {
        **{name: name for name in ("kp", "kd", "effort_limit", "velocity_limit", "armature", "frictionloss")},
        **{name: name for name in ("joint_damping", "position_low", "position_high")},
        **{name: name for name in ("command_low", "command_high", "delay_low", "delay_high")},
        "delay_nominal": "delay",
    },
}
"""Figure to the setting that holds it, where no class or version decides."""

_OF_OWN_CLASS = {
    **{name: name for name in ("stall_torque", "no_load_speed", "encoder_bias", "filter_cutoff")},
    **{name: name for name in ("command_low", "command_high")},
    **{f"curve.{name}": name for name in ("drive_torque", "brake_torque", "knee_speed")},
}
"""Likewise of the class that actspec writes for Isaac Lab (`class: custom`)."""

_STOCK = frozenset(
    {
        "class_type", "effort_limit", "velocity_limit", "effort_limit_sim", "velocity_limit_sim", "stiffness",
        "damping", "armature", "friction", "dynamic_friction", "viscous_friction", "min_delay", "max_delay",
        "physics_dt",
    }
)  # fmt: skip
"""Fields of Isaac Lab's own PD class."""

IN_FIGURES = frozenset(
    {
        *_STOCK, "joint_effort_limit", "actuator_effort_limit", "joint_velocity_limit", "actuator_velocity_limit",
        "delay_min_lag", "delay_max_lag", "default_position", "action_scale", *_OF_OWN_CLASS.values(),
        *(setting for settings in _FIELDS.values() for setting in settings.values()),
    }
) - {"class_type", "physics_dt"}  # fmt: skip
"""Settings that a figure is made from."""

OF_ALL_CLASSES = IN_FIGURES - frozenset(_OF_OWN_CLASS.values())
"""Those of them that are read of a class of somebody's own."""

VOLTS = "in volts: constant and resistance of the motor make a torque of it"
"""Why the gains of mjlab's `BuiltinDcMotorActuatorCfg` are none at the joint. Source: mjlab 1.6.0, its docstring."""


def selected(config: RobotConfig, group: ActuatorGroup, named: Sequence[str] | None) -> list[tuple[str, str]]:
    """The joints of a group, each with the pattern that selects it; the patterns themselves without a model.

    A pattern that means one name is that name.
    """
    found: dict[str, str] = {}
    for pattern in group.joints or ():
        if named is None:
            found.setdefault(plain_name(config.framework, pattern) or pattern, pattern)
        else:
            for joint in matching(config.framework, pattern, named):
                found.setdefault(joint, pattern)
    return list(found.items())


def lost_keys(
    config: RobotConfig, group: ActuatorGroup, setting: Setting, named: Sequence[str] | None
) -> list[str]:
    """Keys of a dict that can select none of the group's joints, for which Isaac Lab and mjlab refuse it."""
    joints = [joint for joint, _ in selected(config, group, named)]
    keys = setting.keys or ()
    return [key for key in keys if not any(may_match(config.framework, key, joint) for joint in joints)]


def models_of(config: RobotConfig, partners: Sequence[Artifact]) -> list[Artifact]:
    """The robot files among partners, the one first that a configuration is for.

    That is the one that it loads, else one in which all of its patterns match, that of the USD's name before others,
    then that in which it selects the most, an MJCF and then the first of equals.

    Args:
        config: The configuration.
        partners: Artifacts of the same robot.
    """
    return sorted((partner for partner in partners if partner.robot is not None), key=_fit(config))


def _fit(config: RobotConfig) -> Callable[[Artifact], tuple[int, bool, int, int, bool]]:
    """Sorting key of models: the one that a configuration loads, then by the joints that it selects in it.

    A USD has joints of its own, whichever model beside it has its name. Of equals an MJCF comes first: it says whether
    the base is free, and a URDF does not.
    """
    loads = _is_of_model(config.model)

    def key(model: Artifact) -> tuple[int, bool, int, int, bool]:
        joints = joint_names(model) or ()
        most = sum(len(selected(config, group, joints)) for group in config.groups)
        named = agreement(config.model or "", model.path)
        fitting = fits(config, joints)
        return -named if loads else 0, not fitting, -named, -most, model.kind is not FileKind.MJCF

    return key


def _is_of_model(path: str | None) -> bool:
    """Whether a path is a URDF's or an MJCF's."""
    return (path or "").lower().endswith((".urdf", ".xml", ".mjcf"))


def _simulated(config: RobotConfig, models: Sequence[Artifact]) -> list[RobotView]:
    """The models whose links a configuration moves: the file that it names, if it is one; nobody knows of a USD.

    A file that is not there, or has no inertia, has no other one's: a robot of the same joints weighs something else.
    """
    name = os.path.basename(config.model or "")
    if not _is_of_model(name):
        return [model.robot for model in models if model.robot is not None]
    named = [model for model in models if os.path.basename(model.path) == name]
    most = max((agreement(config.model or "", model.path) for model in named), default=0)
    return [
        model.robot
        for model in named
        if model.robot is not None and agreement(config.model or "", model.path) == most
    ]


def control_of(framework: Framework, *classes: str) -> str:
    """What a class of a framework is, in the ledger's words.

    Args:
        framework: Whose class.
        classes: Its name, then its bases, nearest first; each is judged by the stock name that it contains.
    """
    return next((kind for cls in classes if (kind := _control(framework, cls)) != "other"), "other")


def is_own_class(group: ActuatorGroup) -> bool:
    """Whether a class is the one that actspec writes: a PD drive with the fields of that class and no others."""
    made = group.settings.get("class_type")
    return (
        group.bases[:1] == ("IdealPDActuatorCfg",)
        and made is not None
        and f"{made.value}Cfg" == group.cls
        and set(group.settings) - _STOCK <= {"command", *_OF_OWN_CLASS.values()}
    )


def control_of_group(framework: Framework, group: ActuatorGroup) -> str:
    """What a group's class is; of a class that delays another (mjlab before 1.3), what that one is.

    legged_gym's `control_type` is P where none is written.
    """
    if framework is Framework.LEGGED_GYM and not group.cls:
        return "ideal_pd"
    inner = group.settings.get("base_cfg")
    inside = (inner.value,) if inner is not None and isinstance(inner.value, str) else ()
    found = control_of(framework, *inside, group.cls, *group.bases)
    # What a run's file has of that class is all that its law needs; a call of one that is not read leaves its defaults.
    curved = found == "other" and framework is Framework.ISAACLAB and group.of_run and has_curve(group)
    return "ideal_pd" if curved else found


def is_network(framework: Framework, group: ActuatorGroup) -> bool:
    """Whether a network gives the group's torque; of legged_gym its gains stand there, and are not used."""
    if framework is Framework.LEGGED_GYM:
        return group.cls == NETWORK
    return control_of(framework, group.cls, *group.bases) == "network"


def _control(framework: Framework, cls: str) -> str:
    if framework is Framework.DEPLOY:
        return "ideal_pd"
    if framework is Framework.LEGGED_GYM:
        return {"P": "ideal_pd", "V": "velocity", "T": "motor", PHYSX: "implicit"}.get(cls, "other")
    name = cls.lower().removeprefix("delayed").replace("_", "")
    table: tuple[tuple[str, str], ...]
    if framework is Framework.MJLAB:
        table = (
            ("builtinposition", "position"),
            ("builtinpd", "pid"),
            ("builtinvelocity", "velocity"),
            ("builtinmotor", "motor"),
            ("builtindcmotor", "dcmotor"),
            ("dcmotor", "dc_motor"),
            ("learned", "network"),
            ("idealpd", "ideal_pd"),
            ("xmlposition", "position"),
            ("xmlvelocity", "velocity"),
            ("xmlmotor", "motor"),
        )
    else:
        table = (
            ("implicit", "implicit"),
            ("actuatornet", "network"),
            ("dcmotor", "dc_motor"),
            ("idealpd", "ideal_pd"),
            ("remotized", "ideal_pd"),
            ("pdactuator", "ideal_pd"),
        )
    return next((kind for part, kind in table if part in name), "other")


def figures_of(
    config: RobotConfig,
    group: ActuatorGroup,
    joint: str,
    pattern: str,
    named: Sequence[str] | None,
    versions: Versions,
    step: float | None = None,
    earlier: Sequence[tuple[ActuatorGroup, str]] = (),
) -> dict[str, Found]:
    """What the class of a group makes of its settings for one joint, by the names of `fields.FIELDS`.

    Of a position at zero action that is not the default one there is `action_zero`, with the other one as `start` and
    no `default_position`, by which commands are held against each other. Of an action's clip there are `clip_low` and
    `clip_high`.
    Of a lag, which is a range of steps, there are `delay_low` and `delay_high`, and their steps where it is not known
    how long one is.

    Args:
        config: The configuration.
        group: One of its groups.
        joint: The joint; the pattern itself where no joint is known.
        pattern: What selects it.
        named: All joints of the robot; None: they are not known.
        versions: Decides what Isaac Lab's `friction` means; unknown without.
        step: Of the simulation, which lags count [s]; None: unknown, and so are they.
        earlier: Groups before it that have the joint too, each with what selects it: what they leave is its default.
    """
    left: dict[str, Found] = {}
    for one, its in earlier:
        control = control_of_group(config.framework, one)
        idle = idle_speeds(config.framework, control)
        acting = replace(one, settings={key: own for key, own in one.settings.items() if key not in idle})
        taken = taken_by(control, left, versions)
        figures = _figures_over(taken, config, acting, joint, its, named, versions, step)
        left = left_by(one.name, one.span, control, figures)
    taken = taken_by(control_of_group(config.framework, group), left, versions)
    return _figures_over(taken, config, group, joint, pattern, named, versions, step)


def _figures_over(
    values: dict[str, Found],
    config: RobotConfig,
    group: ActuatorGroup,
    joint: str,
    pattern: str,
    named: Sequence[str] | None,
    versions: Versions,
    step: float | None,
) -> dict[str, Found]:
    """The figures of one group, over those that stand where it states nothing."""
    control = control_of_group(config.framework, group)
    known = named is not None or plain_name(config.framework, pattern) is not None
    # legged_gym looks both gains up by the keys of one.
    order = group.settings.get("stiffness") if config.framework is Framework.LEGGED_GYM else None
    gains = (order.keys if order is not None else None) or ()

    def take(field: str, *settings: str) -> None:
        for name in settings:
            setting = group.settings.get(name, config.settings.get(name))
            if setting is None or (setting.value is None and setting.unknown is None):
                continue
            keys = gains if name in ("stiffness", "damping") else ()
            its = settled(config.framework, name, setting, joint, keys) if known else setting
            found = value_of(config.framework, its, joint, pattern, named)
            if found is None:
                continue
            lost = (
                () if found.stated or name not in group.settings else lost_keys(config, group, setting, named)
            )
            if lost and config.framework is Framework.ISAACLAB:
                why = f"no key of {name} is for the joint, and '{lost[0]}' for none, which Isaac Lab refuses"
                found = Found(None, setting.span, False, why)
            values[field] = found
            return

    for field, name in _FIELDS[config.framework].items():
        take(field, name)
    if "kd" in values and _is_undriven_in_legged_gym(config, group, joint, named):
        values["kd"] = Found(0.0, group.settings["stiffness"].span, stated=False)
    take("default_position", "default_position")
    if config.actions:
        values.update(acted(config, joint, pattern, named, command_of(control, values)))
        _at_zero_action(values)
    else:
        take("action_scale", "action_scale")
    if config.framework is Framework.ISAACLAB:
        curved = has_curve(group)
        take_limits(control, curved, take, versions)
        take("friction_setting", "friction")
        take("dynamic_friction_setting", "dynamic_friction")
        settle_friction(values, versions)
        for field, name in _OF_OWN_CLASS.items() if is_own_class(group) else ():
            take(field, name)
        if curved:
            take_curve(values, take)
    elif config.framework is Framework.MJLAB:
        take("no_load_speed" if control == "dc_motor" else "velocity_limit", "velocity_limit")
        if control == "dcmotor":
            values.update(
                (gain, Found(None, values[gain].span, why=VOLTS)) for gain in ("kp", "kd") if gain in values
            )
    for field, lag in zip(
        ("delay_low", "delay_high"), lags_of(config.framework, group, versions), strict=True
    ):
        if lag is not None:
            steps = lag.number
            seconds = None if steps is None or step is None else steps * step
            values[field] = Found(seconds, lag.span, why=lag.unknown)
            if step is None and steps is not None:
                values[f"{field}_steps"] = Found(steps, lag.span)
    return values


def _at_zero_action(values: dict[str, Found]) -> None:
    """Leave no default position where an action is not added to it: it is where the joint starts alone."""
    zero, pose = values.get("action_zero"), values.get("default_position")
    if zero is None:
        return
    if zero.value is not None and zero.value == (0.0 if pose is None else pose.value):
        del values["action_zero"]
        return
    if pose is not None:
        values["start"] = pose
    values["default_position"] = Found(None, zero.span, why="an action is not added to the default position")


def _is_undriven_in_legged_gym(
    config: RobotConfig, group: ActuatorGroup, joint: str, named: Sequence[str] | None
) -> bool:
    """Whether legged_gym gives a joint kp 0 and kd 0, because no key of `stiffness` is part of its name.

    Source: leggedrobotics/legged_gym, legged_robot.py, `_init_buffers`: the keys of `stiffness` alone are looked for,
    and `damping` is asked for the one that was found.
    """
    keys = group.settings["stiffness"].value if "stiffness" in group.settings else None
    gains = (
        config.framework is Framework.LEGGED_GYM and control_of_group(config.framework, group) in _OF_GAINS
    )
    if not gains or named is None or not isinstance(keys, Mapping):
        return False
    return not any(str(key) in joint for key in keys)


_OF_GAINS = ("ideal_pd", "velocity")
"""Controls of legged_gym that use its gains."""


def lags_of(
    framework: Framework, group: ActuatorGroup, versions: Versions
) -> tuple[Setting | None, Setting | None]:
    """The least and the largest lag of a group's command [physics steps]; Isaac Lab 3.0 has one, the largest."""
    names = {Framework.ISAACLAB: "{}_delay", Framework.MJLAB: "delay_{}_lag"}.get(framework)
    if names is None:
        return None, None
    low, high = (group.settings.get(names.format(end)) for end in ("min", "max"))
    return high if framework is Framework.ISAACLAB and is_native(versions) else low, high


_PASSIVE = (Framework.ISAACLAB, Framework.MJLAB)
"""Frameworks whose viscous friction is the joint's, outside the drive's limit."""

_CLAMPED = ("implicit", "ideal_pd", "dc_motor", "position", "velocity", "dcmotor")


def rows_of_config(
    artifact: Artifact,
    index: int,
    partners: Sequence[Artifact],
    versions: Versions,
    *,
    whole: bool = False,
    joints: Sequence[str] = (),
) -> tuple[LedgerRow, ...]:
    """The rows of one configuration: what its actuator classes do with what is written.

    Args:
        artifact: With a `config`.
        index: Of the artifact in the case.
        partners: The other artifacts of the same robot. The first of `models_of` names the joints; without a model
            its own order of joints does, and then another configuration's.
        versions: Decides what Isaac Lab's `friction` means; unknown without.
        whole: Give a row to each joint that legged_gym gives gains of 0 too. Its default pose, which must have all
            joints, names them where no model does.
        joints: The robot's, where nothing else names them; empty: not known.
    """
    config = artifact.config
    assert config is not None
    models = models_of(config, partners)
    posed = _posed(config) if whole else ()
    names_of = (*map(joint_names, models), posed, *map(joint_names, (artifact, *partners)), joints)
    named = next((names for names in names_of if names), None)
    robots = [model.robot for model in models if model.robot is not None]
    massive = next((robot for robot in _simulated(config, models) if robot.inertia is not None), None)
    passive = next((robot for robot in robots if robot.format is ModelFormat.MJCF), None)
    one_has_it = has_last(config.framework, versions)
    before: dict[str, list[tuple[ActuatorGroup, str]]] = {}
    members = []
    for group in config.groups:
        left = _left(config, group, named) if whole else ()
        for joint, pattern in (*selected(config, group, named), *left):
            earlier = before.setdefault(joint, []) if one_has_it else []
            own = figures_of(config, group, joint, pattern, named, versions, config.physics_dt, earlier)
            members.append((group, joint, own))
            earlier.append((group, pattern))
    inertia = _inertia(massive, {joint: figures.get("armature") for _, joint, figures in members})
    rows = []
    for group, joint, figures in members:
        view = robots[0].joint(joint) if robots else None
        passives = (
            passive.joint(joint) if passive is not None and config.framework is Framework.MJLAB else None
        )
        rows.append(_of_group(artifact, index, group, joint, figures, view, inertia.get(joint), passives))
    if one_has_it:
        rows = last_of_each(rows)
    if named is not None:
        order = {name: place for place, name in enumerate(named)}
        rows.sort(key=lambda row: order.get(row.joint, len(order)))
    return tuple(rows)


def _posed(config: RobotConfig) -> tuple[str, ...]:
    """The joints of legged_gym's `default_joint_angles`: it looks each joint of the robot up there."""
    pose = config.settings.get("default_position")
    if config.framework is not Framework.LEGGED_GYM or pose is None or not isinstance(pose.value, Mapping):
        return ()
    return tuple(map(str, pose.value))


def _left(
    config: RobotConfig, group: ActuatorGroup, named: Sequence[str] | None
) -> Iterator[tuple[str, str]]:
    """The joints that no key of legged_gym's gains selects, which get gains of 0."""
    taken = {joint for joint, _ in selected(config, group, named)}
    for joint in named or () if group.joints else ():
        if joint not in taken and _is_undriven_in_legged_gym(config, group, joint, named):
            yield joint, joint


def _of_group(
    artifact: Artifact,
    index: int,
    group: ActuatorGroup,
    joint: str,
    figures: Mapping[str, Found],
    view: JointView | None,
    inertia: JointInertia | None,
    own: JointView | None,
) -> LedgerRow:
    """One joint of a group; `own` is the joint whose passive part mjlab's actuators leave as it is."""
    config = artifact.config
    assert config is not None
    control = control_of_group(config.framework, group)
    figures = _with_delay(figures, config.physics_dt)
    if has_curve(group):
        figures = _with_end_of_curve(figures)
    columns = {name: found for name, found in figures.items() if name in LedgerRow.__dataclass_fields__}
    numbers: dict[str, Any] = {field: found.value for field, found in columns.items()}
    if own is not None:
        # mjlab's actuators act on the XML's joints, whose passive part stays unless the cfg sets it.
        numbers = {"joint_damping": own.damping, "frictionloss": own.frictionloss, **numbers}
    kd, joint_damping = numbers.get("kd"), numbers.get("joint_damping")
    stiffness = total([numbers.get("kp"), 0.0 if own is None else own.spring])
    damping = total([kd, joint_damping])
    held, free = (None, None) if inertia is None else (inertia.held, inertia.free)
    explicit = control in ("ideal_pd", "dc_motor", "network") and config.framework is not Framework.DEPLOY
    return LedgerRow(
        file=artifact.path,
        artifact=index,
        span=group.span,
        joint=joint,
        actuator=group.name,
        control=control,
        kind=view.kind if view is not None else None,
        command=command_of(control, figures),
        kd_clamped=True if control in _CLAMPED else None,
        kd_implicit=True if control == "implicit" else False if explicit else None,
        joint_damping_clamped=False if config.framework in _PASSIVE else None,
        actuator_damping=0.0 if own is not None else None,
        actuator_damping_clamped=False if own is not None else None,
        back_emf=0.0 if kd is not None else None,
        position_range=view.range if view is not None and view.kind is not JointKind.BALL else None,
        more={
            field: found.value
            for field, found in figures.items()
            if field not in columns and field in FIELDS and found.value is not None
        },
        by_key={field: found.keys for field, found in figures.items() if found.keys},
        places={field: found.span for field, found in figures.items()},
        stated=frozenset(field for field, found in columns.items() if found.stated),
        **dynamics_at(stiffness, damping, held, free, config.physics_dt, kd if explicit else None),
        **numbers,
    )


def _with_end_of_curve(figures: Mapping[str, Found]) -> Mapping[str, Found]:
    """The figures of a class that clips by an asymmetric curve alone: its larger torque limits the joint, or a solver's
    limit below it.

    No file is held to that: what a maker publishes of a motor is the one torque or the other.
    """
    ends = [figures.get(f"curve.{name}") for name in ("drive_torque", "brake_torque")]
    known = [end for end in ends if end is not None and end.value is not None]
    if len(known) < len(ends):
        return figures
    least, solver = max(known, key=lambda end: end.value or 0.0), figures.get("solver_effort_limit")
    if solver is not None and 0.0 < (solver.value or 0.0) < (least.value or 0.0):
        least = solver
    return {**figures, "effort_limit": replace(least, stated=False)}


def _with_delay(figures: Mapping[str, Found], step: float | None) -> Mapping[str, Found]:
    """The figures, with a fixed delay in seconds in place of its ends.

    A range has no single value, and steps without a step length have none.
    """
    high, low = figures.get("delay_high"), figures.get("delay_low")
    if high is None or high.why is not None or (high.value is None and step is None):
        return figures
    if (0.0 if low is None else low.value) != high.value:
        return {**figures, "delay": Found(None, high.span)}
    others = {name: found for name, found in figures.items() if name not in ("delay_low", "delay_high")}
    return {**others, "delay": Found(high.value, high.span)}


def _inertia(robot: RobotView | None, armature: Mapping[str, Found | None]) -> dict[str, JointInertia]:
    """Inertia of each joint, with the configuration's armature on all of them, else the model's own."""
    if robot is None or robot.inertia is None:
        return {}
    views = {joint: view for joint in armature if (view := robot.joint(joint)) is not None and view.dof >= 0}
    own = {}
    for joint, view in views.items():
        found = armature[joint]
        own[view.dof] = view.armature if found is None or found.value is None else found.value
    held, free = robot.inertia.held(own), robot.inertia.free(own)
    return {
        joint: JointInertia(held[view.dof], free[view.dof])
        for joint, view in views.items()
        # An armature that nobody can tell is not 0.
        if (found := armature[joint]) is None or found.why is None
    }
