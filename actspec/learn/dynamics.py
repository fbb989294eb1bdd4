"""The dynamics with which torques were inferred: their hash, figures that a person looks at, and what has changed."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Sequence
from typing import Any

from actspec.ir import JointActuator
from actspec.robot.view import RobotView
from actspec.spec.network import TrainedModel
from actspec.sysid.links import bench_model
from actspec.units import format_quantity

SAME = 1e-6
"""Of a figure that is the same. Chosen: below the digits of a datasheet, above those of another release's compiler."""
DIGITS = 9
"""Decimals of a figure in the hash. Chosen: releases of MuJoCo compile the same to 1e-15."""


def dynamics_entries(robot: RobotView, actuators: Sequence[JointActuator]) -> dict[str, Any]:
    """What a manifest holds of the dynamics: `model` and `dynamics`.

    Args:
        robot: The model; its links, springs and gravity count.
        actuators: Whose armature and friction count.

    Raises:
        RobotError: the model does not tell the links' inertia.
    """
    import numpy as np

    model, pose = bench_model(robot, [], None)
    digest = hashlib.sha256()
    links = (
        model.body_mass,
        model.body_inertia,
        model.body_ipos,
        model.body_iquat,
        model.body_pos,
        model.body_quat,
    )
    joints = (model.jnt_axis, model.jnt_pos, model.jnt_stiffness, model.qpos_spring)
    for array in (*links, *joints, model.opt.gravity, pose):
        digest.update((np.asarray(array, dtype=float).round(DIGITS) + 0.0).tobytes())
    figures = {}
    for actuator in actuators:
        held = actuator.inertia_held
        figures[actuator.joint] = {
            "armature": actuator.armature.value,
            "coulomb": actuator.friction_coulomb.value,
            "viscous": actuator.friction_viscous.value,
            "inertia": None if held is None else held.reference,
        }
        digest.update(repr((actuator.joint, *list(figures[actuator.joint].values())[:3])).encode())
    gravity = float(np.linalg.norm(model.opt.gravity))
    found = {"mass": float(model.body_mass.sum()), "gravity": gravity, "joints": figures}
    return {"model": digest.hexdigest(), "dynamics": found}


def changes(was: TrainedModel, now: TrainedModel, actuators: Sequence[JointActuator]) -> Iterator[str]:
    """Figures that differ, in words: `armature of hip is 0.02 kg*m^2, was 0.01 kg*m^2`.

    Args:
        was: At training.
        now: As `dynamics_entries` gives it.
        actuators: For units.
    """
    pairs: list[tuple[str, float | None, float | None, str]]
    pairs = [("mass of the robot", was.mass, now.mass, "kg"), ("gravity", was.gravity, now.gravity, "m/s^2")]
    for actuator in actuators:
        one, other = was.joints.get(actuator.joint), now.joints.get(actuator.joint)
        if one is None or other is None:
            continue
        of = f"of {actuator.joint}"
        inertia = actuator.armature.unit
        pairs += [
            (f"armature {of}", one.armature, other.armature, inertia),
            (f"coulomb friction {of}", one.coulomb, other.coulomb, actuator.friction_coulomb.unit),
            (f"viscous friction {of}", one.viscous, other.viscous, actuator.friction_viscous.unit),
            (f"inertia {of}", one.inertia, other.inertia, inertia),
        ]
    for name, before, after, unit in pairs:
        if not _same(before, after):
            yield f"{name} is {format_quantity(after, unit, 4)}, was {format_quantity(before, unit, 4)}"


def _same(one: float | None, other: float | None) -> bool:
    # Unknown counts as 0 where torques are inferred.
    return math.isclose(one or 0.0, other or 0.0, rel_tol=SAME, abs_tol=1e-12)
