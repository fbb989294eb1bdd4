"""What all limits of a file together tell of one of them: zeros and round figures that nobody stated."""

from __future__ import annotations

import math
import re

from actspec.audit.case import MODELS, Case
from actspec.audit.rules.configs import names_model
from actspec.audit.rules.joints import is_called_undriven, partner_rows
from actspec.diagnostics import Span
from actspec.fields import GRAVITY, LONGEST_LEVER, PLACEHOLDER
from actspec.ir import JointKind
from actspec.readings.artifact import FileKind, Framework
from actspec.readings.ledger import LedgerRow

LIMITS = ("effort_limit", "velocity_limit")
"""Fields of a joint's limits."""

_ROUND = 1e3
"""One digit and zeros from here on are nobody's effort where all joints of a light robot have it [N*m]. Published: 1000
N*m on all joints of Solo 12, which weighs 2.5 kg, and of Bolt, 1.25 kg; 20,000 on those of a GR1 of 54 kg."""


_OF_LIMITS = re.compile("effort|torque|force|limit|^y1$", re.IGNORECASE)
"""Names of settings that may limit a torque."""


def limited_by_own(case: Case) -> frozenset[Span]:
    """Groups of somebody's class, or fork, with such settings of its own: what it clips at, nobody knows here."""
    configs = (artifact.config for _, artifact in case.of_kind(FileKind.CFG))
    groups = (group for config in configs if config is not None for group in config.groups)
    return frozenset(group.span for group in groups if any(map(_OF_LIMITS.search, group.own)))


def taken_by_gym(case: Case, row: LedgerRow) -> tuple[LedgerRow, LedgerRow] | None:
    """Who drives a joint with its URDF's effort of 0, and which other model limits it above that; None: nobody does.

    legged_gym names the URDF, and has its effort as the torque limit of every joint. Where no other model has one, the
    URDF may be for kinematics; a configuration with torque limits of its own may be of a fork that clips to these.

    Source: legged_gym, legged_robot.py: _process_dof_props reads props["effort"], and _compute_torques clips to it.
    """
    artifact = case.artifacts[row.artifact]
    if artifact.kind is not FileKind.URDF or row.effort_limit != 0.0:
        return None
    for one in partner_rows(case, row, FileKind.CFG):
        config = case.artifacts[one.artifact].config
        loads = config is not None and config.framework is Framework.LEGGED_GYM and config.model is not None
        if config is None or not loads or not one.kp or not names_model(case, config, artifact):
            continue
        if one.span in case.once(limited_by_own):
            continue
        for other in partner_rows(case, row, FileKind.MJCF):
            if other.control != "none" and 0.0 < (other.effort_limit or 0.0) < PLACEHOLDER:
                return one, other
    return None


def few_zeros(case: Case) -> frozenset[int]:
    """URDFs with an effort above 0 at most joints: those with 0 are springs, sensors and followers more often than not.

    Where a motor is among them the joint of the other side, or another file, has its limit (SYM101, SRC101).
    """
    found = set()
    for index, _ in case.of_kind(FileKind.URDF):
        efforts = [
            row.effort_limit for row in case.rows_of(index) if "effort_limit" in row.stated and row.joint
        ]
        if 2 * efforts.count(0.0) < len(efforts):
            found.add(index)
    return frozenset(found)


def _without_efforts(case: Case) -> frozenset[int]:
    """URDFs with speed limits and an effort of 0 at every joint: files for kinematics, which state no efforts."""
    return _without(case, "effort_limit", "velocity_limit")


def _without_speeds(case: Case) -> frozenset[int]:
    """URDFs with effort limits and a velocity of 0 at every joint: nobody stated speeds."""
    return _without(case, "velocity_limit", "effort_limit")


WITHOUT = {"effort_limit": _without_efforts, "velocity_limit": _without_speeds}
"""For each limit the URDFs in which all have none of it."""


def _without(case: Case, field: str, other: str) -> frozenset[int]:
    """URDFs with the one limit of 0 at every joint, and the other above it."""
    found = set()
    for index, _ in case.of_kind(FileKind.URDF):
        rows = [row for row in case.rows_of(index) if field in row.stated]
        if rows and all(getattr(row, field) == 0.0 and (getattr(row, other) or 0.0) > 0.0 for row in rows):
            found.add(index)
    return frozenset(found)


def round_for_all(case: Case) -> dict[tuple[int, float], float]:
    """Models and their round effort of every hinge, two or more, that would hold the robot on a lever which none has.

    Returns:
        The robot's mass [kg] by model and effort.
    """
    found = {}
    for index, artifact in case.of_kind(*MODELS):
        mass = None if artifact.robot is None else artifact.robot.mass
        rows = [
            row
            for row in case.rows_of(index)
            if row.joint and row.kind is JointKind.HINGE and "effort_limit" in row.stated
        ]
        motors = artifact.kind is FileKind.URDF or all(row.control == "motor" for row in rows)
        efforts = {row.effort_limit for row in rows if not is_called_undriven(row)}
        # Of each hinge the links that it moves are known, so that none of the mass is missing.
        if not (mass and motors and len(rows) > 1 and len(efforts) == 1 and all(r.inertia_max for r in rows)):
            continue
        effort = efforts.pop() or 0.0
        if (
            _ROUND <= effort < math.inf
            and effort == float(f"{effort:.0e}")
            and effort > LONGEST_LEVER * mass * GRAVITY
        ):
            found[index, effort] = mass
    return found


def furniture(case: Case) -> frozenset[int]:
    """URDFs whose limits nothing takes: without a limit on any joint, and no joint that moves another. A robot has
    joints behind each other.
    """
    found = set()
    for index, artifact in case.of_kind(FileKind.URDF):
        limits = [
            getattr(row, field) for row in case.rows_of(index) for field in LIMITS if field in row.stated
        ]
        joints = () if artifact.robot is None else artifact.robot.joints
        if limits and not any(limits) and not any(joint.parent for joint in joints):
            found.add(index)
    return frozenset(found)


def mimics(case: Case) -> frozenset[tuple[int, str]]:
    """Joints that follow another one and have no motor."""
    return frozenset(
        (index, joint.name)
        for index, artifact in case.of_kind(FileKind.URDF)
        if artifact.robot is not None
        for joint in artifact.robot.joints
        if joint.mimic is not None
    )
