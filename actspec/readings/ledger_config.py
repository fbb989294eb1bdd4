"""Rows of the ledger from configurations: what their actuator classes make of what is written.

A configuration speaks in patterns; which joints they mean, and the joints' inertia, come from the
model that it is paired with. Without one, each pattern is a row of its own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from actspec.joints import JointKind
from actspec.readings.artifact import ActuatorGroup, Artifact, Framework
from actspec.readings.config_figures import Found, control_of_group, figures_of, models_of, selected
from actspec.readings.ledger import LedgerRow, dynamics_at
from actspec.readings.pair import joint_names
from actspec.readings.versions import Versions
from actspec.robot.view import JointInertia, JointView, ModelFormat, RobotView

_PASSIVE = (Framework.ISAACLAB, Framework.MJLAB)
"""Frameworks whose viscous friction is the joint's, outside the drive's limit."""

_CLAMPED = ("implicit", "ideal_pd", "dc_motor", "position", "velocity", "dcmotor")


def rows_of_config(
    artifact: Artifact, index: int, partners: Sequence[Artifact], versions: Versions
) -> tuple[LedgerRow, ...]:
    """The rows of one configuration: what its actuator classes do with what is written.

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
    robots = [model.robot for model in models if model.robot is not None]
    massive = next((robot for robot in robots if robot.inertia is not None), None)
    passive = next((robot for robot in robots if robot.format is ModelFormat.MJCF), None)
    members = [
        (group, joint, figures_of(config, group, joint, pattern, named, versions, config.physics_dt))
        for group in config.groups
        for joint, pattern in selected(config, group, named)
    ]
    inertia = _inertia(massive, {joint: figures.get("armature") for _, joint, figures in members})
    rows = []
    for group, joint, figures in members:
        view = robots[0].joint(joint) if robots else None
        own = passive.joint(joint) if passive is not None and config.framework is Framework.MJLAB else None
        rows.append(_of_group(artifact, index, group, joint, figures, view, inertia.get(joint), own))
    if named is not None:
        order = {name: place for place, name in enumerate(named)}
        rows.sort(key=lambda row: order.get(row.joint, len(order)))
    return tuple(rows)


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
    figures = {**figures, **_delay(figures, config.physics_dt)}
    figures = {name: found for name, found in figures.items() if name in LedgerRow.__dataclass_fields__}
    numbers: dict[str, Any] = {field: found.value for field, found in figures.items()}
    if own is not None:
        # mjlab's actuators act on the XML's joints, whose passive part stays unless the cfg sets it.
        numbers = {"joint_damping": own.damping, "frictionloss": own.frictionloss, **numbers}
    kd, joint_damping = numbers.get("kd"), numbers.get("joint_damping")
    total = None if kd is None or joint_damping is None else kd + joint_damping
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
        kd_clamped=True if control in _CLAMPED else None,
        kd_implicit=True if control == "implicit" else False if explicit else None,
        joint_damping_clamped=False if config.framework in _PASSIVE else None,
        actuator_damping=0.0 if own is not None else None,
        actuator_damping_clamped=False if own is not None else None,
        back_emf=0.0 if kd is not None else None,
        position_range=view.range if view is not None and view.kind is not JointKind.BALL else None,
        places={field: found.span for field, found in figures.items()},
        stated=frozenset(field for field, found in figures.items() if found.stated),
        **dynamics_at(numbers.get("kp"), total, held, free, config.physics_dt, kd if explicit else None),
        **numbers,
    )


def _delay(figures: Mapping[str, Found], step: float | None) -> dict[str, Found]:
    """A fixed delay in seconds; a range has no single value, and steps without a step length have none."""
    high = figures.get("delay_high")
    if high is None or high.why is not None or (high.value is None and step is None):
        return {}
    low = figures.get("delay_low")
    least = 0.0 if low is None else low.value
    return {"delay": Found(high.value if least == high.value else None, high.span)}


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
    return {joint: JointInertia(held[view.dof], free[view.dof]) for joint, view in views.items()}
