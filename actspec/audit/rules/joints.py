"""Joints of the ledger: the units of their figures, and the rows of one joint in the files of a robot."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from itertools import product

from actspec.audit.case import Case
from actspec.audit.rules.configs import names_model
from actspec.diagnostics import Span
from actspec.fields import (
    PLACEHOLDER,
    PLACEHOLDER_SPEED,
    PLACEHOLDER_SPEEDS,
    is_of_a_machine,
    is_power_of_ten,
)
from actspec.files import in_common
from actspec.ir import JointKind
from actspec.readings.artifact import FileKind, Framework
from actspec.readings.drive import largest
from actspec.readings.dynamics import undriven
from actspec.readings.ledger import LedgerRow
from actspec.readings.versions import Versions, friction_unit_of
from actspec.robot.view import JointView
from actspec.units import format_quantity

SPEEDS = ("velocity_limit", "no_load_speed")

SLOW = 5.0
"""Least acceleration that a joint's whole torque gives its own armature [rad/s^2]. Chosen: UNT105's `least`; legs have
hundreds."""

_DIGIT = 5.0
"""From this ratio on a speed has a digit more. Chosen: between the ten of a slip, beside sources that round (140 and
14.375), and a maker's figure beside a program's (2.7: Unitree's H2, an ankle of 100.7 in its URDF, 37 in training)."""


def unit(row: LedgerRow, field: str) -> str:
    """SI unit of a field; a joint of unknown kind is taken for a hinge, as nearly all are."""
    return row.unit(field)


def shown(row: LedgerRow, field: str, value: float | None, digits: int = 3) -> str:
    """A figure for a message, with its unit: three digits, so that equal joints read the same.

    Args:
        row: Whose joint it is of.
        field: Field of the row that it is a value of, or compares with.
        value: The figure; None reads `unknown`.
        digits: More, for figures that a file states and that grow large.
    """
    return format_quantity(value, unit(row, field), digits)


def own_figure(row: LedgerRow, field: str, digits: int = 3) -> str:
    """A row's own figure for a message, with what the file has where a gear makes it: `3900 N*m (39 x gear 100)`."""
    text, made = shown(row, field, getattr(row, field), digits), row.made.get(field)
    return f"{text} ({made})" if made else text


def effort_noun(row: LedgerRow) -> str:
    """What a joint's drive gives, in one word: `force` at a slide, else `torque`."""
    return "force" if row.kind is JointKind.SLIDE else "torque"


def friction_unit(row: LedgerRow, versions: Versions) -> str:
    found = friction_unit_of(versions)
    return "1" if found is not None and found.coefficient else unit(row, "frictionloss")


def partner_rows(case: Case, row: LedgerRow, *kinds: FileKind) -> Iterator[LedgerRow]:
    """Rows of the row's joint in other artifacts of its robot.

    Args:
        case: The case.
        row: Of one artifact.
        kinds: Only of artifacts of these kinds; none: of all.
    """
    if kinds and case.kinds_by_artifact[row.artifact].isdisjoint(kinds):
        return
    for other in case.robot_of(row.artifact).artifacts:
        if other != row.artifact and (not kinds or case.artifacts[other].kind in kinds):
            if row.joint:
                yield from case.joints.get((other, row.joint), ())
            else:
                yield from (found for found in case.rows_of(other) if not found.joint)


def folders_in_common(row: LedgerRow, other: LedgerRow) -> int:
    """How many folders the files of two rows have in common: of one robot's variants the files of one lie together."""
    return in_common(*(os.path.dirname(one.file).split(os.sep) for one in (row, other)))


def starts_there_alone(case: Case, row: LedgerRow) -> bool:
    """Whether a file's default position is where the joint starts and no zero of its command.

    A task of the robot says so, whose actions are not added to it; or a deploy file of which only standing up is told,
    as rl_sar's `base.yaml`: each policy's own `config.yaml` has its pose again (16 of 16).
    """
    artifact = case.artifacts[row.artifact]
    if artifact.kind is not FileKind.CFG:
        return artifact.config is not None and artifact.config.stands_up
    return any("action_zero" in other.places for other in (row, *partner_rows(case, row, FileKind.CFG)))


def is_left_at_zero(case: Case, row: LedgerRow) -> bool:
    """Whether a joint is at 0 in the default pose since no key of Isaac Lab's `joint_pos` is for it.

    Source: Isaac Lab 2.3.2, articulation.py, `_process_cfg` fills zeros by the keys.
    """
    config = case.artifacts[row.artifact].config
    zero = row.default_position == 0.0 and "default_position" not in row.stated
    return zero and config is not None and config.framework is Framework.ISAACLAB


def by_joint(case: Case, *kinds: FileKind) -> Mapping[tuple[int, str], Sequence[LedgerRow]]:
    """Rows of each joint of each artifact, in their order; rows without a joint are left out.

    Args:
        case: The case.
        kinds: Only of artifacts of these kinds; none: of all.
    """
    if not kinds:
        return case.joints
    wanted = {index for index, _ in case.of_kind(*kinds)}
    if len(wanted) == len(case.artifacts):
        return case.joints
    return {key: rows for key, rows in case.joints.items() if key[0] in wanted}


def shared_joints(case: Case) -> Iterator[list[LedgerRow]]:
    """The first row of a joint in each file of one robot that has it, for joints that two files have."""
    for joints in case.once(_shared):
        for rows in joints:
            yield [row for _, row in rows]


def joint_pairs(
    case: Case, figures: Callable[[LedgerRow], Hashable], tells: Callable[[LedgerRow, LedgerRow], bool]
) -> Iterator[tuple[LedgerRow, LedgerRow]]:
    """The first rows of one joint in two files of one robot that tell something together, in the files' order.

    Many files of a robot have the same figures, so what they tell is asked once for all with equal ones.

    Args:
        case: The case.
        figures: All of a row that `tells` looks at.
        tells: Whether two rows, in the files' order, are wanted.
    """
    for joints in case.once(_shared):
        found: list[tuple[_Place, _Place, LedgerRow, LedgerRow]] = []
        for rows in joints:
            alike: dict[Hashable, list[tuple[_Place, LedgerRow]]] = {}
            for place, row in rows:
                alike.setdefault(figures(row), []).append((place, row))
            for some, others in product(alike.values(), repeat=2):
                # Files are in order, so the last of the others is the latest.
                if some[0][0][0] < others[-1][0][0] and tells(some[0][1], others[0][1]):
                    found += [
                        (at, there, one, other)
                        for at, one in some
                        for there, other in others
                        if at[0] < there[0]
                    ]
        found.sort(key=lambda each: (each[0][0], each[1][0], each[0][1]))
        yield from ((one, other) for _, _, one, other in found)


_Place = tuple[int, int]
"""Of a joint: its file among those of the robot, and its place there."""


def _shared(case: Case) -> list[list[list[tuple[_Place, LedgerRow]]]]:
    """For each robot the joints that two of its files have, each with its first row in each file."""
    found = []
    for robot in case.robots:
        joints: dict[str, list[tuple[_Place, LedgerRow]]] = {}
        for file, artifact in enumerate(robot.artifacts if len(robot.artifacts) > 1 else ()):
            for at, (joint, own) in enumerate(case.joints_by_artifact.get(artifact, {}).items()):
                joints.setdefault(joint, []).append(((file, at), own[0]))
        found.append([rows for rows in joints.values() if len(rows) > 1])
    return found


def top_speed(row: LedgerRow) -> float | None:
    """The joint's top speed: its limit or the end of its torque-speed line, what comes first; no placeholder."""
    limit = finite(row.velocity_limit)
    nobodys = limit is None or limit >= PLACEHOLDER_SPEED or is_exporters(row)
    speeds = (None if nobodys else limit, finite(row.no_load_speed))
    return min(filter(None, speeds), default=None)


def is_exporters(row: LedgerRow) -> bool:
    """Whether effort and speed of a joint are those that an exporter writes to every joint where nobody stated any.

    Source: onshape-to-robot writes 10 and 10, 1 and 20 in earlier releases; fusion2urdf 100 and 100.
    """
    limits = row.effort_limit, row.velocity_limit
    return limits in ((10.0, 10.0), (1.0, 20.0), (1.0, 1.0), (100.0, 100.0))


def is_nobodys(row: LedgerRow, field: str, least: float = PLACEHOLDER) -> bool:
    """Whether a file states a placeholder for a limit, which LIM101 has: no other rule judges by it.

    Args:
        row: Whose limit it is.
        field: `effort_limit` or `velocity_limit`.
        least: From where on no motor reaches it [N*m, N, rad/s or m/s].
    """
    limit: float | None = getattr(row, field) if field in row.stated else None
    if limit is None:
        return False
    turns = field == "velocity_limit" and row.kind is not JointKind.SLIDE and not is_called_undriven(row)
    if field == "effort_limit" and is_of_a_machine(limit):
        return False
    return least <= limit < math.inf or (turns and limit in PLACEHOLDER_SPEEDS)


def leaves_speed_open(case: Case, row: LedgerRow, ratio: float) -> bool:
    """Whether a URDF's speed limit is one that no joint reaches, which leaves the limit to others, and no slip.

    Placeholders are powers of ten, on every joint alike (`PLACEHOLDER_SPEED`). A slip is none, has a digit more than
    the other figure, and most hinges of its file have speeds that joints do reach.

    Args:
        case: The case.
        row: Of the URDF.
        ratio: Its speed over the other figure.
    """
    speed = row.velocity_limit or 0.0
    if speed < PLACEHOLDER_SPEED:
        return False
    if ratio < _DIGIT or is_power_of_ten(speed):
        return True
    speeds = [
        other.velocity_limit
        for other in case.rows_of(row.artifact)
        if other.velocity_limit and "velocity_limit" in other.stated and other.kind is not JointKind.SLIDE
    ]
    return 2 * sum(speed < PLACEHOLDER_SPEED for speed in speeds) <= len(speeds)


def clamp_of(joint: JointView | None) -> float | None:
    """Largest torque that a joint of a model lets its actuators apply [N*m or N]; None: no limit, or unknown."""
    if joint is None or joint.effort_range is None or "effort_range" in joint.unknown:
        return None
    return largest(joint.effort_range)


def is_undriven(case: Case, row: LedgerRow) -> bool:
    """Whether nothing drives a joint of an MJCF, so that its limit there bounds no torque.

    No actuator of the file does, which has others, or was met in a folder without a configuration of its robot that may
    give it some.

    Source: MuJoCo, XML reference, joint/actuatorfrcrange: the range clamps what actuators give.
    """
    if row.control != "none" or case.artifacts[row.artifact].kind is not FileKind.MJCF:
        return False
    if any(other.control != "none" for other in case.rows_of(row.artifact)):
        return True
    return case.is_met(row.artifact) and not is_driven_by_mjlab(case, row)


def undriven_joints(case: Case) -> dict[int, frozenset[str]]:
    """Joints without an actuator of each whole model, where others have one."""
    parts = {file.path for file in case.files if file.included}
    return {
        index: undriven(artifact.robot)
        for index, artifact in case.of_kind(FileKind.MJCF)
        if artifact.path not in parts
    }


def is_driven_by_mjlab(case: Case, row: LedgerRow) -> bool:
    """Whether an mjlab configuration that loads a model gives it its actuators, and decides on step and integrator.

    One that does not tell which model it loads may load each.
    """
    model = case.artifacts[row.artifact]
    configs = (case.artifacts[other.artifact].config for other in partner_rows(case, row, FileKind.CFG))
    return any(
        config is not None and config.framework is Framework.MJLAB and names_model(case, config, model)
        for config in configs
    )


_UNDRIVEN = re.compile(
    r"rotor|prop(?:eller)?s?(?:_|\b|\d)|caster|castor|roller|free_?wheel|knuckle|inner_finger|spring|dummy|virtual|"
    r"passive|fake|not_?used?(?:_|\b)|unused",
    re.IGNORECASE,
)


def is_called_undriven(row: LedgerRow) -> bool:
    """Whether a joint's name says that it has no drive whose limits would matter.

    A drone's rotors are driven by their thrust, the links of a gripper by one of its fingers, and a motor's place in an
    order that nothing has is not used.
    """
    return names_undriven(row.joint)


def names_undriven(name: str) -> bool:
    """The same of a name."""
    return _UNDRIVEN.search(name) is not None


_HELD = 0.01
"""Range up to which a hinge is held where it is [rad]. Chosen: half a degree, less than the play of most gears."""


def is_held(row: LedgerRow) -> bool:
    """Whether a hinge's range leaves it no room: its limits are of no consequence."""
    return has_no_room(row.kind, row.position_range)


def has_no_room(kind: JointKind | None, limits: tuple[float, float] | None) -> bool:
    """The same of a joint's kind and range."""
    return kind is JointKind.HINGE and limits is not None and 0.0 < limits[1] - limits[0] <= _HELD


def limiting_row(case: Case, row: LedgerRow) -> LedgerRow | None:
    """The row whose finite effort limit holds for the joint: its own, else the least that other files state.

    What an exporter wrote into another file nobody stated.
    """
    if finite(row.effort_limit) is not None:
        return row
    others = [
        other
        for other in partner_rows(case, row)
        if finite(other.effort_limit) is not None and not is_exporters(other)
    ]
    return min(others, key=lambda other: other.effort_limit or 0.0, default=None)


def limit_of(case: Case, row: LedgerRow) -> float | None:
    """The finite effort limit that holds for a joint [N*m or N]; None: no file states one."""
    limiting = limiting_row(case, row)
    return None if limiting is None else limiting.effort_limit


def acceleration(row: LedgerRow, limit: float | None, armature: float | None) -> float | None:
    """What its whole torque gives a hinge's armature alone [rad/s^2]; None of a slide, and without one of the two."""
    torque, inertia = limit or 0.0, armature or 0.0
    return torque / inertia if torque > 0.0 < inertia and row.kind is not JointKind.SLIDE else None


def finite(limit: float | None) -> float | None:
    return limit if limit is not None and 0.0 < limit < math.inf else None


def driving_limit(row: LedgerRow) -> tuple[str, float | None]:
    """The field that bounds what drives a joint, and the bound [N*m or N]; None: unknown.

    A torque-speed line falls from its stall torque, at standstill: an effort limit above that bounds nothing but what
    brakes the joint. So does a limit that is only the larger torque of an asymmetric curve.
    """
    limit, curve = row.effort_limit, "curve.drive_torque"
    of_curve = None if "effort_limit" in row.stated else row.more.get(curve)
    for field, most in (("stall_torque", row.stall_torque), (curve, of_curve)):
        if most is not None and limit is not None and 0.0 < most < limit:
            return field, most
    return "effort_limit", limit


def driving_place(row: LedgerRow) -> Span:
    """Where `driving_limit` is written."""
    return row.place(driving_limit(row)[0])


def keeps_for_model(case: Case, row: LedgerRow) -> bool:
    """Whether a row is that of a spec without its model beside it: what it leaves out it has from there."""
    models = {FileKind.MJCF, FileKind.URDF}
    is_spec = case.artifacts[row.artifact].kind is FileKind.SPEC
    return is_spec and case.kinds_by_artifact[row.artifact].isdisjoint(models)
