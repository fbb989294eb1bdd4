"""Joints of files beside the same joints of a spec, and what the rules about that have in common."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from actspec.audit.case import Case
from actspec.audit.rules.joints import by_joint, leaves_speed_open
from actspec.audit.rules.source_blame import GRAVE
from actspec.audit.rules.source_rule import shown
from actspec.ir import JointActuator
from actspec.readings.artifact import FileKind
from actspec.readings.compare import Figure, times, torque_slip
from actspec.readings.dynamics import figure
from actspec.readings.joint import SERVOS
from actspec.readings.ledger import LedgerRow
from actspec.robot.view import ActuatorView
from actspec.units import format_number

NO_SPEC = "no spec among the files that describes a robot of the others"
SHARE = 0.1
"""Least part of the spec's kd that is a second one and no friction. Chosen: as DMP101's `share`."""


@dataclass(frozen=True, slots=True)
class SpecJoint:
    """One joint of one file and of the spec.

    Attributes:
        rows: The joint's rows in the file.
        spec: Its row in the spec.
        actuator: Its actuator in the spec.
        kind: What the file is.
        drives: The actuators of an MJCF that act on it.
    """

    rows: Sequence[LedgerRow]
    spec: LedgerRow
    actuator: JointActuator
    kind: FileKind
    drives: Sequence[ActuatorView] = ()

    def mine(self, field: str) -> Figure | None:
        """What the file says; None where it leaves that to others."""
        found = figure(self.rows, field)
        # Such an actuator is all that drives the joint: what the file leaves out is the engine's 0.
        runs = self.kind is FileKind.MJCF and self.rows[0].control in SERVOS
        return found if found.value is not None and (found.stated or runs) else None

    def wanted(self, field: str) -> Figure | None:
        """What the spec says; None where it says nothing."""
        found = figure((self.spec,), field)
        return found if found.value is not None and found.stated else None


def spec_joints(case: Case) -> Iterator[SpecJoint]:
    """Every joint of every file that a spec of the same robot describes."""
    rows = by_joint(case)
    for index, artifact in case.of_kind(FileKind.SPEC):
        assert artifact.spec is not None
        for other in case.robot_of(index).artifacts:
            kind = case.artifacts[other].kind
            if kind is FileKind.SPEC:
                continue
            robot = case.artifacts[other].robot
            drives: dict[str, list[ActuatorView]] = {}
            for drive in robot.actuators if robot is not None else ():
                drives.setdefault(drive.target, []).append(drive)
            for actuator in artifact.spec.joints:
                mine, wanted = rows.get((other, actuator.joint)), rows.get((index, actuator.joint))
                if mine and wanted:
                    yield SpecJoint(mine, wanted[0], actuator, kind, drives.get(actuator.joint, ()))


def faster_than_line(case: Case, joint: SpecJoint) -> tuple[Figure, Figure] | None:
    """A URDF's speed limit of `GRAVE` times the speed or more at which the spec's motor has no torque, and that speed.

    None where the spec states a speed limit beside its motor's line, and for a placeholder.

    Args:
        case: The case.
        joint: The joint.
    """
    mine, wanted = joint.mine("velocity_limit"), joint.wanted("no_load_speed")
    if joint.kind is not FileKind.URDF or joint.wanted("velocity_limit") is not None:
        return None
    if mine is None or wanted is None or not mine.value or not wanted.value:
        return None
    ratio = mine.value / wanted.value
    return None if ratio < GRAVE or leaves_speed_open(case, joint.rows[0], ratio) else (mine, wanted)


def counted_twice(joint: SpecJoint, tolerance: float) -> float | None:
    """Damping of a file beyond the spec's kd and viscous friction that is a second kd; None: there is none.

    The passive part beyond the spec's friction is all of the extra, or the extra is the spec's kd once more.

    Args:
        joint: The joint.
        tolerance: Relative difference of equal figures.
    """
    wanted_kd, viscous = joint.spec.kd, joint.spec.joint_damping
    kd = figure(joint.rows, "kd").value
    first = joint.rows[0]
    actuator = figure(joint.rows, "actuator_damping").value or 0.0
    if not wanted_kd or viscous is None or kd is None or first.joint_damping is None:
        return None
    passive = first.joint_damping + actuator
    extra = kd + passive - (wanted_kd + viscous)
    if passive - viscous < SHARE * wanted_kd:
        return None
    explained = (passive - viscous, wanted_kd)
    return extra if any(math.isclose(extra, part, rel_tol=tolerance) for part in explained) else None


def is_sum(joint: SpecJoint, tolerance: float) -> bool:
    """Whether a configuration that states no passive damping has the spec's in its kd."""
    kd, total = figure(joint.rows, "kd").value, joint.spec.total_damping
    if kd is None or total is None or joint.kind not in (FileKind.CFG, FileKind.DEPLOY):
        return False
    return "joint_damping" not in joint.rows[0].stated and math.isclose(kd, total, rel_tol=tolerance)


def unit_confused(case: Case, joint: SpecJoint, tolerance: float) -> tuple[Figure, str] | None:
    """Friction of a file that is the spec's in another unit.

    Args:
        case: The case; its versions decide what Isaac Lab's `friction` is.
        joint: The joint.
        tolerance: Relative difference of equal figures.

    Returns: The file's figure, and what happened; None where nothing of the kind did.
    """
    wanted = joint.wanted("frictionloss")
    if wanted is None or not wanted.value:
        return None
    first = joint.rows[0]
    found = joint.mine("frictionloss")
    written, place = first.more.get("friction_setting"), first.place("friction_setting")
    if found is None and written is not None:
        found = Figure(written, wanted.unit, place, True)
        coefficient = _coefficient(case)
        if coefficient is not None and math.isclose(written, wanted.value, rel_tol=tolerance):
            return Figure(written, "", place, True), (
                f"is {format_number(written, 3)}, the spec's {shown(wanted.value, wanted.unit)}: in {coefficient} "
                "the field is a coefficient without unit, and the joint's load decides on the torque"
            )
    if found is None or not found.value:
        return None
    ratio = found.value / wanted.value
    other = torque_slip(ratio, wanted.unit, tolerance)
    if other is None:
        return None
    return found, (
        f"is {format_number(found.value, 3)}, and the spec says {shown(wanted.value, wanted.unit)}: that is the spec's "
        f"figure in {other}, where the file means {wanted.unit}{times(found.value, wanted.value)}"
    )


def _coefficient(case: Case) -> str | None:
    """The named stack in which Isaac Lab's `friction` is a coefficient; None: it is not, or nobody named one."""
    versions = case.versions
    if versions.isaaclab is None:
        return None
    if int(versions.isaaclab.split(".")[0]) >= 3:
        return f"Isaac Lab {versions.isaaclab} on OVPhysX" if versions.backend == "ovphysx" else None
    if versions.isaac_sim is None or int(versions.isaac_sim.split(".")[0]) >= 5:
        return None
    return f"Isaac Lab {versions.isaaclab} on Isaac Sim {versions.isaac_sim}"
