"""Which joints a linkage drives, with which motors, by which Jacobian: the spec's `linkages` against the robot."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from actspec.diagnostics import Collector, listed
from actspec.ir import JointKind
from actspec.resolution.binding import Bindings
from actspec.resolution.gearbox import Train, gear_train, unfit
from actspec.resolution.linkage import Geometry, LinkedMotors, Matrix
from actspec.resolution.motor import Drivetrain, check_motor, joint_motor
from actspec.resolution.quantities import unit_of
from actspec.resolution.stated import Stated
from actspec.spec.gears import Linkage
from actspec.spec.paths import Path, dotted
from actspec.spec.rules.gears import number
from actspec.spec.validate import Spec
from actspec.spec.values import SpecValue
from actspec.units import Kind

ZERO = 1e-9
"""Entries of an inverse below this share of the largest are rounding of 0. Chosen."""
SINGULAR = 1e-6
"""Least ratio of smallest to largest singular value of a Jacobian, its joints' units apart.

Chosen: a linkage beyond a million to one is at a dead point, or a row is written twice.
"""
OUTSIDE = ("motor", "motors_per_joint", "reduction", "transmission")
"""Fields of a joint that its linkage states in their place."""


def linked_motors(
    spec: Spec, stated: Sequence[Stated], bindings: Bindings, collector: Collector
) -> tuple[LinkedMotors, ...]:
    """Every linkage of a spec that is sound; what is wrong with the others goes to the collector.

    Args:
        spec: The spec.
        stated: What it states of each managed joint.
        bindings: Its joints.
        collector: Takes what is wrong.
    """
    by_joint = {item.binding.joint.name: item for item in stated}
    found = (
        _linked(name, linkage, spec, by_joint, bindings, collector)
        for name, linkage in spec.model.linkages.items()
    )
    return tuple(item for item in found if item is not None)


def _linked(
    name: str,
    linkage: Linkage,
    spec: Spec,
    by_joint: Mapping[str, Stated],
    bindings: Bindings,
    collector: Collector,
) -> LinkedMotors | None:
    path: Path = ("linkages", name)
    members = _members(path, linkage, spec, by_joint, bindings, collector)
    if members is None:
        return None
    kind = members[0].kind
    pose = _default_pose(linkage, spec, bindings)
    geometries = _geometries(path, linkage, spec, collector)
    if geometries is None:
        return None
    used = min(geometries, key=lambda one: 0.0 if one.at is None else math.dist(one.at, pose), default=None)
    motors = []
    for index, key in enumerate(linkage.motors):
        output = _output_kind(path, linkage, index, kind, spec, collector)
        motor = spec.model.motors[key]
        drivetrain = Drivetrain(gear_train(motor, key, output), Train("", (), output, None), 1, output)
        check_motor(motor, key, drivetrain, f"the linkage '{name}'", spec, collector)
        motors.append(joint_motor(motor, key, drivetrain, spec))
    return LinkedMotors(
        name=name,
        joints=linkage.joints,
        motors=tuple(motors),
        used=used,
        table=geometries if linkage.table is not None else (),
        everywhere=linkage.at == "any",
        factor=None if linkage.factor is None else number(linkage.factor),
        together=linkage.limits == "together",
        text=_text(name, linkage, used, pose, kind),
    )


def _members(
    path: Path,
    linkage: Linkage,
    spec: Spec,
    by_joint: Mapping[str, Stated],
    bindings: Bindings,
    collector: Collector,
) -> list[Stated] | None:
    """The linkage's joints; None where one is missing, of another kind, or has a motor of its own."""
    members = []
    for index, joint in enumerate(linkage.joints):
        place = (*path, "joints", index)
        stated = by_joint.get(joint)
        if stated is None:
            collector.error(
                "RES014",
                f"the joint '{joint}' of the linkage is in no group"
                if joint in bindings.unmanaged
                else f"the robot has no hinge or slide joint '{joint}' for the linkage",
                where=dotted(place),
                span=spec.span(*place),
                help="put it into a group of `actuators`"
                if joint in bindings.unmanaged
                else f"joints: {listed(by_joint)}",
            )
            continue
        members.append(stated)
        for field in OUTSIDE:
            if stated.get(field) is not None:
                at = stated.path(field)
                collector.error(
                    "RES015",
                    f"'{joint}' is driven by the linkage '{path[-1]}', and its group states {field}",
                    where=dotted(at),
                    span=spec.span(*at),
                    help="remove it here: the linkage names the motors and how they drive; for other joints of the "
                    "group, give these a group of their own",
                )
    kinds = {stated.kind for stated in members}
    if len(kinds) > 1:
        collector.error(
            "RES014",
            "the linkage has hinge and slide joints",
            where=dotted((*path, "joints")),
            span=spec.span(*path, "joints"),
            help="its joints are of one kind",
        )
    if len(members) < len(linkage.joints) or len(kinds) > 1:
        return None
    _check_poses(path, linkage, members[0].kind, spec, collector)
    return members


def _check_poses(path: Path, linkage: Linkage, kind: JointKind, spec: Spec, collector: Collector) -> None:
    """Poses are in the unit of the joints."""
    poses: list[tuple[Path, tuple[SpecValue, ...] | str | None]] = [((*path, "at"), linkage.at)]
    poses += [((*path, "table", index, "at"), pose.at) for index, pose in enumerate(linkage.table or ())]
    for place, pose in poses:
        for value in pose if isinstance(pose, tuple) else ():
            if unfit(value, kind):
                collector.error(
                    "RES001",
                    f"the joints of the linkage are {kind.value} joints, but a position is given as {value.written}",
                    where=dotted(place),
                    span=spec.span(*place),
                    help="a hinge is in rad, a slide in m",
                )
                return


def _output_kind(
    path: Path, linkage: Linkage, index: int, joints: JointKind, spec: Spec, collector: Collector
) -> JointKind:
    """What a motor's output does: as the joints, or travel where its row is in m/rad."""
    matrices: list[tuple[Path, tuple[tuple[SpecValue, ...], ...]]] = []
    if linkage.jacobian is not None:
        matrices.append((("jacobian",), linkage.jacobian))
    matrices += [(("table", at, "jacobian"), pose.jacobian) for at, pose in enumerate(linkage.table or ())]
    travels: set[bool] = set()
    for place, matrix in matrices:
        travels |= {entry.linear is True for entry in matrix[index] if entry.value != 0.0}
        wrong = len(travels) > 1 or (True in travels and joints is JointKind.SLIDE)
        if wrong:
            at = (*path, *place, index)
            collector.error(
                "RES001",
                "a motor's row is in m/rad where the motor travels and the joints turn, and without a unit otherwise",
                where=dotted(at),
                span=spec.span(*at),
                help="write the whole row in one unit, in every pose",
            )
            break
    return JointKind.SLIDE if True in travels else joints


def _geometries(
    path: Path, linkage: Linkage, spec: Spec, collector: Collector
) -> tuple[Geometry, ...] | None:
    """The Jacobian at each pose; none for a plain factor, None where one cannot be inverted."""
    import numpy as np

    at = linkage.at if isinstance(linkage.at, tuple) else None
    poses: list[tuple[Path, tuple[SpecValue, ...] | None, tuple[tuple[SpecValue, ...], ...]]] = []
    if linkage.jacobian is not None:
        poses.append(((*path, "jacobian"), at, linkage.jacobian))
    poses += [((*path, "table", i, "jacobian"), p.at, p.jacobian) for i, p in enumerate(linkage.table or ())]
    found = []
    sound = True
    for place, pose, jacobian in poses:
        matrix = np.array([[number(entry) for entry in row] for row in jacobian])
        # Columns of joints with short arms are as good as others: each is scaled by its largest entry.
        scale = np.abs(matrix).max(axis=0)
        with np.errstate(all="ignore"):
            scaled = matrix / np.where(scale > 0.0, scale, 1.0)
            values = np.linalg.svd(scaled, compute_uv=False)
            invertible = values[-1] > SINGULAR * values[0]
            torques = np.linalg.inv(scaled).T / scale if invertible else matrix
        if not invertible or not np.isfinite(torques).all():
            sound = False
            collector.error(
                "RES016",
                "the Jacobian has no inverse: some movement of the joints moves no motor, or two rows are the same",
                where=dotted(place),
                span=spec.span(*place),
                help="signs tell a parallel linkage apart: `[[1, 0.6], [1, -0.6]]`; a linkage at its dead point "
                "has no limits",
            )
            continue
        torques[np.abs(torques) < ZERO * np.abs(torques).max(axis=0)] = 0.0
        positions = None if pose is None else tuple(number(value) for value in pose)
        found.append(Geometry(_tuples(matrix.tolist()), _tuples(torques.tolist()), positions))
    return tuple(found) if sound else None


def _tuples(rows: Sequence[Sequence[float]]) -> Matrix:
    return tuple(tuple(row) for row in rows)


def _default_pose(linkage: Linkage, spec: Spec, bindings: Bindings) -> tuple[float, ...]:
    patterns = (bindings.default_pose.get(joint) for joint in linkage.joints)
    poses = spec.model.robot.default_pose
    return tuple(0.0 if pattern is None else poses[pattern].value or 0.0 for pattern in patterns)


def _text(name: str, linkage: Linkage, used: Geometry | None, pose: Sequence[float], kind: JointKind) -> str:
    """The linkage in formulas: name, pose of its Jacobian, source."""
    unit = unit_of(Kind.POSITION, kind)
    text = f"linkage {name}"
    if used is not None and used.at is not None:
        at, wanted = (
            f"[{', '.join(f'{value:g}' for value in positions)}] {unit}" for positions in (used.at, pose)
        )
        text += f" at {at}"
        if linkage.table is not None and at != wanted:
            text += f", of {len(linkage.table)} poses the nearest to {wanted}"
    if linkage.source is not None:
        text += f" ({linkage.source})"
    return text
