"""Ledger rows of a configuration: what its actuator classes do with what is written.

A configuration speaks in patterns; which joints they mean, and the joints' inertia, come from the
model that it is paired with. Without one, each pattern is a row of its own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from actspec.joints import InertiaRange, JointKind
from actspec.readings.artifact import ActuatorGroup, Artifact, Framework, RobotConfig
from actspec.readings.config_figures import (
    Found,
    control_of_group,
    figures_of,
    models_of,
    selected,
    value_of,
)
from actspec.readings.joint import explicit_ratio, resonance
from actspec.readings.ledger import LedgerRow
from actspec.readings.pair import joint_names
from actspec.readings.versions import Versions
from actspec.robot.view import JointView, ModelFormat, RobotView

_PASSIVE = (Framework.ISAACLAB, Framework.MJLAB)
"""Frameworks whose viscous friction is the joint's, outside the drive's limit."""

_CLAMPED = ("implicit", "ideal_pd", "dc_motor", "position", "velocity", "dcmotor")


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
    models = models_of(config, partners)
    named = next((names for names in map(joint_names, (*models, *partners)) if names), None)
    if named is None and config.framework is Framework.DEPLOY:
        named = joint_names(artifact)
    massive = next((m.robot for m in models if m.robot is not None and m.robot.inertia is not None), None)
    passive = next((m.robot for m in models if m.robot and m.robot.format is ModelFormat.MJCF), None)
    model = next((m.robot for m in models), None)
    members = [
        (group, joint, pattern)
        for group in config.groups
        for joint, pattern in selected(config, group, named)
    ]
    armature: dict[str, float | None] = {}
    for group, joint, pattern in members:
        setting = group.settings.get("armature")
        found = None if setting is None else value_of(config.framework, setting, joint, pattern, named)
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
    control = control_of_group(config.framework, group)
    values = figures_of(config, group, joint, pattern, named, versions)
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
    frequency, ratio = resonance(kp, total, held)
    explicit = control in ("ideal_pd", "dc_motor", "network") and config.framework is not Framework.DEPLOY
    implicit = True if control == "implicit" else False if explicit else None
    step = config.physics_dt
    stability = explicit_ratio(step, kd, free) if explicit else None
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
        joint_damping_clamped=False if config.framework in _PASSIVE else None,
        actuator_damping=0.0 if own is not None else None,
        actuator_damping_clamped=False if own is not None else None,
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


def _delay(config: RobotConfig, group: ActuatorGroup) -> Found | None:
    """A fixed delay in seconds; a range has no single value, and steps without a step length have none."""
    low, high = (
        group.settings.get(f"{end}_delay", group.settings.get(f"delay_{end}_lag")) for end in ("min", "max")
    )
    step = config.physics_dt
    if high is None or not isinstance(high.value, int | float) or step is None:
        return None
    least = low.value if low is not None else high.value
    return Found(float(high.value) * step if least == high.value else None, high.span)


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
