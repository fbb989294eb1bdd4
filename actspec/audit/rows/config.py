"""Ledger rows of a configuration: what its actuator classes do with what is written.

A configuration speaks in patterns; which joints they mean, and the joints' inertia, come from the
model that it is paired with. Without one, each pattern is a row of its own.

Source for the rules by framework and version: Isaac Lab 2.2.0 and 2.3.2 classes, mjlab 1.6.0 classes,
legged_gym's `_compute_torques`; measured.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from actspec.audit.artifact import ActuatorGroup, Artifact, FileKind, Framework, RobotConfig, Setting
from actspec.audit.case import Versions
from actspec.audit.isaaclab_friction import Meaning, friction_meaning
from actspec.audit.ledger import LedgerRow
from actspec.audit.pair import joint_names, matching
from actspec.diagnostics import Span
from actspec.ir import InertiaRange, JointKind
from actspec.robot.view import JointView, ModelFormat, RobotView

FIELDS: dict[Framework, dict[str, tuple[str, ...]]] = {
    Framework.ISAACLAB: {
        "kp": ("stiffness",),
        "kd": ("damping",),
        "armature": ("armature",),
        "joint_damping": ("viscous_friction",),
        "stall_torque": ("saturation_effort",),
    },
    Framework.MJLAB: {
        "kp": ("stiffness",),
        "kd": ("damping",),
        "effort_limit": ("effort_limit",),
        "armature": ("armature",),
        "frictionloss": ("frictionloss",),
        "joint_damping": ("viscous_damping",),
        "stall_torque": ("saturation_effort",),
    },
    Framework.LEGGED_GYM: {
        "kp": ("stiffness",),
        "kd": ("damping",),
        "armature": ("armature",),
        "action_scale": ("action_scale",),
    },
    Framework.DEPLOY: {
        name: (name,)
        for name in (
            "kp",
            "kd",
            "effort_limit",
            "velocity_limit",
            "armature",
            "frictionloss",
            "joint_damping",
            "default_position",
            "action_scale",
        )
    },
}
"""Ledger field to the settings that hold it, where no class or version decides."""

_CLAMPED = ("implicit", "ideal_pd", "dc_motor", "position", "velocity", "dcmotor")


@dataclass(frozen=True, slots=True)
class _Found:
    """A setting's value for one joint: None with `stated` is a value that could not be folded."""

    value: float | None
    span: Span
    stated: bool = True


def rows_of_config(
    artifact: Artifact, index: int, partners: Sequence[Artifact], versions: Versions
) -> tuple[LedgerRow, ...]:
    """The rows of one configuration.

    Args:
        artifact: With a `config`.
        index: Of the artifact in the case.
        partners: The other artifacts of the same robot. The model among them that the configuration names names the
            joints, else the one in which it selects the most, an MJCF and then the first of equals.
        versions: Decides what Isaac Lab's `friction` means; unknown without.
    """
    config = artifact.config
    assert config is not None
    models = sorted((partner for partner in partners if partner.robot is not None), key=_fit(config))
    named = next((names for names in map(joint_names, (*models, *partners)) if names), None)
    if named is None and config.framework is Framework.DEPLOY:
        named = joint_names(artifact)
    massive = next((m.robot for m in models if m.robot is not None and m.robot.inertia is not None), None)
    passive = next((m.robot for m in models if m.robot and m.robot.format is ModelFormat.MJCF), None)
    model = next((m.robot for m in models), None)
    members = [
        (group, joint, pattern) for group in config.groups for joint, pattern in _joints(config, group, named)
    ]
    armature: dict[str, float | None] = {}
    for group, joint, pattern in members:
        setting = group.settings.get("armature")
        found = None if setting is None else _value(config.framework, setting, joint, pattern, named)
        armature[joint] = None if found is None else found.value
    inertia = _inertia(massive, armature)
    rows = [
        _row(
            artifact,
            index,
            config,
            group,
            joint,
            pattern,
            named,
            None if model is None else model.joint(joint),
            inertia.get(joint, (None, None)),
            passive,
            versions,
        )
        for group, joint, pattern in members
    ]
    if named is not None:
        order = {name: place for place, name in enumerate(named)}
        rows.sort(key=lambda row: order.get(row.joint, len(order)))
    return tuple(rows)


def _fit(config: RobotConfig) -> Callable[[Artifact], tuple[bool, int, bool]]:
    """Sorting key of models: the one that a configuration names, then by the joints that it selects in it.

    Of equals an MJCF comes first: it says whether the base is free, and a URDF does not.
    """
    named = config.settings.get("model")
    text = named.value if named is not None and isinstance(named.value, str) else ""
    stem = os.path.splitext(os.path.basename(text))[0]

    def key(model: Artifact) -> tuple[bool, int, bool]:
        joints = joint_names(model) or ()
        selected = sum(len(_joints(config, group, joints)) for group in config.groups)
        other = os.path.splitext(os.path.basename(model.path))[0] != stem
        return other, -selected, model.kind is not FileKind.MJCF

    return key


def _joints(config: RobotConfig, group: ActuatorGroup, named: Sequence[str] | None) -> list[tuple[str, str]]:
    """The joints of a group, each with the pattern that selects it; the patterns themselves without a model."""
    found: dict[str, str] = {}
    for pattern in group.joints or ():
        if named is None:
            found.setdefault(pattern, pattern)
        else:
            for joint in matching(config.framework, pattern, named):
                found.setdefault(joint, pattern)
    return list(found.items())


def control_of(framework: Framework, *classes: str) -> str:
    """What a class of a framework is, in the ledger's words.

    Args:
        framework: Whose class.
        classes: Its name, then its bases, nearest first; each is judged by the stock name that it contains.
    """
    return next((kind for cls in classes if (kind := _control(framework, cls)) != "other"), "other")


def _control(framework: Framework, cls: str) -> str:
    if framework is Framework.DEPLOY:
        return "ideal_pd"
    if framework is Framework.LEGGED_GYM:
        return {"P": "ideal_pd", "V": "velocity", "T": "motor"}.get(cls, "other")
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


def _row(
    artifact: Artifact,
    index: int,
    config: RobotConfig,
    group: ActuatorGroup,
    joint: str,
    pattern: str,
    named: Sequence[str] | None,
    view: JointView | None,
    inertia: tuple[InertiaRange | None, InertiaRange | None],
    passive: RobotView | None,
    versions: Versions,
) -> LedgerRow:
    control = control_of(config.framework, group.cls, *group.bases)
    values: dict[str, _Found] = {}

    def take(field: str, *settings: str) -> None:
        for name in settings:
            setting = group.settings.get(name, config.settings.get(name))
            if setting is None or (setting.value is None and setting.unknown is None):
                continue
            found = _value(config.framework, setting, joint, pattern, named)
            if found is not None:
                values[field] = found
                return

    for field, settings in FIELDS[config.framework].items():
        take(field, *settings)
    take("default_position", "default_position")
    take("action_scale", "action_scale")
    if config.framework is Framework.ISAACLAB:
        _isaaclab_limits(control, take)
        if friction_meaning(versions) is Meaning.EFFORT:
            take("frictionloss", "dynamic_friction", "friction")
    elif config.framework is Framework.MJLAB:
        take("no_load_speed" if control == "dc_motor" else "velocity_limit", "velocity_limit")
    delay = _delay(config, group)
    if delay is not None:
        values["delay"] = delay

    numbers = {field: found.value for field, found in values.items()}
    own = passive.joint(joint) if passive is not None and config.framework is Framework.MJLAB else None
    joint_damping = numbers.get("joint_damping")
    if own is not None and "joint_damping" not in values:
        # mjlab's actuators act on the XML's joints, whose passive part stays unless the cfg sets it.
        joint_damping = own.damping
    if own is not None and "frictionloss" not in values:
        numbers["frictionloss"] = own.frictionloss
    kp, kd = numbers.get("kp"), numbers.get("kd")
    total = None if kd is None or joint_damping is None else kd + joint_damping
    held, free = inertia
    frequency = math.sqrt(kp / held.reference) if kp and kp > 0 and held and held.reference > 0 else None
    ratio = (
        total / (2.0 * math.sqrt(kp * held.reference))
        if total is not None and kp and kp > 0 and held is not None and held.reference > 0
        else None
    )
    explicit = control in ("ideal_pd", "dc_motor", "network") and config.framework is not Framework.DEPLOY
    implicit = True if control == "implicit" else False if explicit else None
    step = config.physics_dt
    stability = (
        step * kd / free.low
        if explicit and step is not None and kd is not None and free is not None and free.low > 0
        else None
    )
    return LedgerRow(
        file=artifact.path,
        artifact=index,
        span=group.span,
        joint=joint,
        actuator=group.name,
        control=control,
        kind=view.kind if view is not None else None,
        kp=kp,
        kd=kd,
        kd_clamped=True if control in _CLAMPED else None,
        kd_implicit=implicit,
        joint_damping=joint_damping,
        actuator_damping=0.0 if own is not None else None,
        back_emf=0.0 if kd is not None else None,
        total_damping=total,
        frictionloss=numbers.get("frictionloss"),
        effort_limit=numbers.get("effort_limit"),
        velocity_limit=numbers.get("velocity_limit"),
        stall_torque=numbers.get("stall_torque"),
        no_load_speed=numbers.get("no_load_speed"),
        armature=numbers.get("armature"),
        inertia_min=held.low if held is not None else None,
        inertia_max=held.high if held is not None else None,
        inertia_free_min=free.low if free is not None else None,
        natural_frequency=frequency,
        damping_ratio=ratio,
        stability=stability,
        delay=numbers.get("delay"),
        position_range=view.range if view is not None and view.kind is not JointKind.BALL else None,
        action_scale=numbers.get("action_scale"),
        default_position=numbers.get("default_position"),
        places={field: found.span for field, found in values.items()},
        stated=frozenset(field for field, found in values.items() if found.stated),
    )


def _isaaclab_limits(control: str, take: Callable[..., None]) -> None:
    """The limits by class, in the names of 2.x and 3.0.

    An implicit drive is clamped by the solver's limit, and its `velocity_limit` is ignored; an explicit
    one clamps in the model. `velocity_limit` of a DC motor is the no-load speed.
    """
    if control == "implicit":
        take("effort_limit", "effort_limit_sim", "joint_effort_limit", "effort_limit")
        take("velocity_limit", "velocity_limit_sim", "joint_velocity_limit")
        return
    take("effort_limit", "effort_limit", "actuator_effort_limit")
    take("velocity_limit", "velocity_limit_sim", "joint_velocity_limit")
    curve = control in ("dc_motor", "network")
    take("no_load_speed" if curve else "velocity_limit", "velocity_limit", "actuator_velocity_limit")


def _value(
    framework: Framework, setting: Setting, joint: str, pattern: str, named: Sequence[str] | None
) -> _Found | None:
    """A setting's value for a joint.

    A mapping that misses a joint gives 0 in Isaac Lab (2.x, measured) and in legged_gym; elsewhere nothing.
    Without a model only a key that is written like the group's pattern is known to cover it.
    """
    if setting.unknown is not None:
        return _Found(None, setting.span)
    value = setting.value
    if isinstance(value, bool):
        return None
    if isinstance(value, int | float):
        return _Found(float(value), setting.span)
    if not isinstance(value, Mapping):
        return None
    keys = [key for key, number in value.items() if isinstance(number, int | float)]
    if named is None:
        chosen = next((key for key in keys if key in (pattern, ".*")), None)
        return _Found(None, setting.span) if chosen is None else _Found(_float(value[chosen]), setting.span)
    chosen = next((key for key in keys if matching(framework, str(key), (joint,))), None)
    if chosen is not None:
        return _Found(_float(value[chosen]), setting.span)
    if framework in (Framework.ISAACLAB, Framework.LEGGED_GYM) and len(keys) == len(value):
        return _Found(0.0, setting.span, stated=False)
    return None


def _float(value: object) -> float | None:
    return float(value) if isinstance(value, int | float) else None


def _delay(config: RobotConfig, group: ActuatorGroup) -> _Found | None:
    """A fixed delay in seconds; a range has no single value, and steps without a step length have none."""
    low, high = (
        group.settings.get(f"{end}_delay", group.settings.get(f"delay_{end}_lag")) for end in ("min", "max")
    )
    step = config.physics_dt
    if high is None or not isinstance(high.value, int | float) or step is None:
        return None
    least = low.value if low is not None else high.value
    return _Found(float(high.value) * step if least == high.value else None, high.span)


def _inertia(
    robot: RobotView | None, armature: Mapping[str, float | None]
) -> dict[str, tuple[InertiaRange, InertiaRange]]:
    """Held and free inertia of each joint, with the configuration's armature on all of them, else the model's own."""
    if robot is None or robot.inertia is None:
        return {}
    views = {joint: view for joint in armature if (view := robot.joint(joint)) is not None and view.dof >= 0}
    own = {}
    for joint, view in views.items():
        stated = armature[joint]
        own[view.dof] = view.armature if stated is None else stated
    held, free = robot.inertia.held(own), robot.inertia.free(own)
    return {joint: (held[view.dof], free[view.dof]) for joint, view in views.items()}
