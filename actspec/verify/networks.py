"""Torque agreement of networks: what an engine computes along courses against the law of the network's ONNX file."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from actspec.ir import ActuatorSet, Command, JointActuator
from actspec.laws.network import NetworkDrive
from actspec.simulate.excitation import COURSES, HeldMotion, HeldMotions, torque_scale
from actspec.simulate.reference import PassiveFriction, held_network_torque
from actspec.targets.base import Approximation
from actspec.verify.agreement import Row, TargetFiles, alike, worst_of
from actspec.verify.engines.asking import EngineAnswer
from actspec.verify.joint_laws import JointLaws
from actspec.verify.response import without_loss
from actspec.verify.torque import ROUNDINGS, SINGLE, draws, lags, least_error, row_of

if TYPE_CHECKING:
    from actspec.laws.arrays import Floats as Array

HISTORY = "network.initial_history"


def network_rows(
    target: TargetFiles, actuators: ActuatorSet, laws: JointLaws, motions: HeldMotions, answer: EngineAnswer
) -> Iterator[Row]:
    """Rows of an engine's networks.

    Args:
        target: What was asked.
        actuators: What the spec asks for.
        laws: Of its joints.
        motions: What the engine was asked.
        answer: What it made of it.
    """
    if COURSES not in motions:
        return
    step = actuators.physics_dt.require()
    motion = motions[COURSES].single() if answer.single else motions[COURSES]
    for members in alike(actuators):
        known = [member for member in members if member.joint in laws.networks]
        judged = (_judge(target, one, laws, motion, answer, step) for one in known)
        yield from worst_of(judged, lambda row: row.ok)


def _judge(
    target: TargetFiles,
    actuator: JointActuator,
    laws: JointLaws,
    motion: HeldMotion,
    answer: EngineAnswer,
    step: float,
) -> tuple[float, Row]:
    """The row of one joint, and its error in tolerances."""
    import numpy as np

    asked, column = laws.networks[actuator.joint], laws.columns[actuator.joint]
    got, unit = answer.torques[COURSES][:, :, column], actuator.effort_limit.unit
    if not np.isfinite(got).all():
        what = "the engine has no drive for the joint"
        row = target.fault(COURSES, "VFY109", what, actuator=actuator, unit=unit, engine=answer.engine)
        return math.inf, row
    # What the target is known to lose is lost in the law too, exactly: what is left must agree.
    drive, lost = _left(asked, target.losses_of(actuator.joint, _FIELDS))
    late = drive.clip.delay == asked.clip.delay
    right = lags(drive.clip, actuator, step, ranged=draws(target)) if late else (0,)
    command, q, qd = (part[:, :, column] for part in motion.arrays)
    wanted = [held_network_torque(drive, command, q, qd, step, lag) for lag in right]
    # Where large terms cancel in a network, single precision itself is further off.
    short = [_floats(part) for part in (command, q, qd)]
    rounded = held_network_torque(_in_single(drive), short[0], short[1], short[2], step, right[0])
    tolerance = SINGLE * torque_scale(asked.clip) + ROUNDINGS * float(np.abs(rounded - wanted[0]).max())
    error = least_error(got, wanted, actuator)
    posed = replace(asked.clip, command=Command.POSITION)
    than = "the network's" + (", known approximations aside," if lost else "")
    return row_of(
        target, actuator, COURSES, error, tolerance, posed, motion, column, lost, answer.engine, than
    )


def _floats(array: Array) -> Array:
    """In single precision, whatever the type says."""
    import numpy as np

    found: Any = array.astype(np.float32)
    return found  # type: ignore[no-any-return]


def _in_single(drive: NetworkDrive) -> NetworkDrive:
    """The same computed in single precision."""

    def of(layer: Any) -> Any:
        names = ("inputs", "hidden", "bias") if hasattr(layer, "hidden") else ("weight", "bias")
        return replace(layer, **{name: _floats(getattr(layer, name)) for name in names})

    layers = drive.network.layers
    layers = replace(layers, recurrent=tuple(map(of, layers.recurrent)), dense=tuple(map(of, layers.dense)))
    return replace(drive, network=replace(drive.network, layers=layers))


# Not `network`: what MuJoCo's file loses of it the runtime has, which is asked here.
_FIELDS = (
    HISTORY,
    "delay",
    "command_filter",
    "encoder_bias",
    "command_range",
    "effort_limit",
    "torque_speed_curve",
)


def _left(drive: NetworkDrive, losses: Sequence[Approximation]) -> tuple[NetworkDrive, list[Approximation]]:
    """The drive without what a target is known to lose of it, and those losses."""
    counted = []
    for loss in losses:
        changed = drive
        if loss.field == HISTORY:
            changed = replace(drive, network=replace(drive.network, backfill="first" in loss.emitted))
        elif (kept := without_loss(loss, drive.clip, PassiveFriction(0.0, 0.0))) is not None:
            changed = replace(drive, clip=kept[0])
        if (changed.clip, changed.network.backfill) != (drive.clip, drive.network.backfill):
            counted.append(loss)
            drive = changed
    return drive, counted
