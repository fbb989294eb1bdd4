from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import replace
from os.path import basename
from typing import ClassVar

from actspec.audit.known import GRIPS
from actspec.audit.rule import Case, Confidence, Finding, RuleInParts, Severity
from actspec.audit.rules.joints import (
    finite,
    is_called_undriven,
    is_exporters,
    is_held,
    is_undriven,
    own_figure,
    partner_rows,
    shown,
    top_speed,
    unit,
)
from actspec.diagnostics import Span
from actspec.ir import JointKind
from actspec.readings.artifact import FileKind
from actspec.readings.ledger import LedgerRow
from actspec.units import format_number


class DampingOutsideClamp(RuleInParts):
    code = "DMP103"
    name = "damping-outside-the-clamp"
    noted_in_folders = True
    counts_where_run = True
    written_over = frozenset({"dynamics", "urdf_dynamics", "damping", "urdf_effort"})
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    paired = True
    needs = "no joint with damping and an effort limit among the files"
    options: ClassVar[dict[str, float]] = {"share": 0.5, "speed": 2.0}

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        """Compare damping times speed with the limit."""
        everything = case.joints
        speeds: dict[tuple[int, str], LedgerRow | None] = {}
        for (artifact, joint), rows in everything.items():
            if case.artifacts[artifact].kind not in (FileKind.MJCF, FileKind.URDF):
                continue
            row = rows[0]
            actuators = [item.actuator_damping or 0.0 for item in rows]
            damping = None if row.joint_damping is None else row.joint_damping + sum(actuators)
            if damping is None:
                continue
            own = finite(row.effort_limit)
            if damping <= 0.0:
                if own is not None:
                    yield ()
                continue
            if row.effort_limit == math.inf and row.kp:
                # What another file says limits nothing here: a servo without a limit outruns the damping (LIM101). Of
                # a motor the controller may clip the torque.
                continue
            files = case.robot_of(artifact).artifacts
            others = (
                other for file in files if file != artifact for other in everything.get((file, joint), ())
            )
            bounded = (other for other in ((row,) if own else others) if finite(other.effort_limit))
            limit = min(bounded, key=lambda other: other.effort_limit or 0.0, default=None)
            if limit is None:
                continue
            # One for all files of the robot.
            key = files[0], joint
            if key not in speeds:
                every = [row for file in files for row in everything.get((file, joint), ())]
                # Whoever corrected an exporter's effort has left its speed.
                exported = {row.velocity_limit for row in every if is_exporters(row)}
                told = (row for row in every if row.velocity_limit not in exported and top_speed(row))
                speeds[key] = min(told, key=lambda one: top_speed(one) or 0.0, default=None)
            fastest = speeds[key]
            speed = None if fastest is None else top_speed(fastest)
            if speed is not None and top_speed(row) == speed:
                fastest = row
            bound = limit.effort_limit or 0.0
            if is_undriven(case, row) or _brakes_by_intent(case, row):
                yield ()
                continue
            stuck = _is_stuck(case, row, bound / damping)
            if fastest and speed and damping * speed >= self.option(case, "share") * bound:
                servo = row.control == "position" and row.kd == 0.0
                meant = not stuck and (servo or _has_spring(case, row))
                yield (self._known(row, damping, limit, fastest, meant),)
            elif speed is None and (
                stuck
                if row.kind is JointKind.SLIDE
                else unit(row, "velocity_limit") == "rad/s" and bound <= damping * self.option(case, "speed")
            ):
                yield (self._slow(row, damping, limit, stuck),)
            else:
                yield ()

    def _known(
        self, row: LedgerRow, damping: float, bounded: LedgerRow, fastest: LedgerRow, meant: bool
    ) -> Finding:
        limit, speed = bounded.effort_limit or 0.0, top_speed(fastest) or 0.0
        which = "velocity_limit" if fastest.velocity_limit == speed else "no_load_speed"
        left = limit - damping * speed
        effect = (
            f"leaves {shown(row, 'effort_limit', left)} to drive the joint"
            if left > 0.0
            else f"keeps the joint below {shown(row, 'velocity_limit', limit / damping)}"
        )
        found = Finding(
            self.code,
            f"at the joint's {shown(row, 'velocity_limit', speed)}{_from(row, fastest)} the damping of "
            f"{shown(row, 'kd', damping)} uses {shown(row, 'effort_limit', damping * speed)} of an effort limit of "
            f"{own_figure(bounded, 'effort_limit')}{_from(row, bounded)}, and is not limited: that {effect}",
            row.place("joint_damping"),
            row.joint,
            damping,
            unit(row, "kd"),
            help=_HELP,
            related=(*_places(row, bounded, "effort_limit"), *_places(row, fastest, which), row.span),
            fields=("joint_damping",),
            severity=None if damping * speed >= _HELD * limit and not meant else Severity.INFO,
        )
        low, high = row.position_range or (0.0, math.inf)
        if row.kind is not JointKind.SLIDE or high - low >= _CROSSED * speed:
            return found
        # A TIAGo's torso has 5 m/s in copies, in place of 0.07, beside the damping of all others.
        took = f"{format_number((high - low) / speed, 2)} s for its whole travel of "
        travel = shown(row, "default_position", high - low)
        return replace(
            found,
            message=f"{found.message}; {shown(row, 'velocity_limit', speed)} would be {took}{travel}",
            span=fastest.place(which),
            value=speed,
            unit=unit(row, which),
            help="state the joint's own velocity limit; if it is right, leave only friction in the joint's damping",
            related=(row.place("joint_damping"), *_places(row, bounded, "effort_limit")),
            fields=(which,),
        )

    def _slow(self, row: LedgerRow, damping: float, bounded: LedgerRow, stuck: bool) -> Finding:
        limit = bounded.effort_limit or 0.0
        way, far = (
            ("10 cm take", 0.1)
            if row.kind is JointKind.SLIDE
            else ("a quarter of a turn takes", math.pi / 2.0)
        )
        took = f": {way} it {format_number(far * damping / limit, 3)} s"
        return Finding(
            self.code,
            f"the damping of {shown(row, 'kd', damping)} is not limited: it uses the whole effort limit of "
            f"{own_figure(bounded, 'effort_limit')}{_from(row, bounded)} at "
            f"{shown(row, 'velocity_limit', limit / damping)}, and the joint "
            f"cannot be driven faster{took * stuck}",
            row.place("joint_damping"),
            row.joint,
            damping,
            unit(row, "kd"),
            help=_HELP,
            related=(*_places(row, bounded, "effort_limit"), row.span),
            fields=("joint_damping",),
            severity=None if stuck else Severity.INFO,
            confidence=None if stuck else Confidence.LOW,
        )


_HELD = 2.0
"""Torque at the joint's speed, as a share of the limit, from which it is a warning. Chosen: a motor has no torque left
at its top speed, and few joints come near the one that is published; damping that takes it all at half of that does."""

_CROSSED = 0.1
"""Time for its whole travel below which a slide's speed limit is none that it has [s]. Chosen: the fastest grippers
take twice as long."""

_STUCK = {JointKind.HINGE: 0.1, JointKind.SLIDE: 0.002}
"""Speed below which a joint whose whole torque goes into its damping cannot do its task [rad/s or m/s]. Chosen: 16 s
for a quarter of a turn, 50 s for 10 cm (the slowest linear servos have 4 mm/s); of 77 strangers' repositories whose
models have 1 N*m*s/rad or more, none has a driven hinge below 0.5 that is no finger, and of 484 none a robot's slide
below 0.2 (lift of an HSR; grippers have 0.01)."""

_HELP = (
    "leave only friction in the joint's damping; a D gain belongs to the drive (kv), a torque-speed line to a "
    "dcmotor or a DC motor class"
)

_DAMPED = re.compile(r"wheel|caster|castor|suspension|shock|roller|rotor|propeller", re.IGNORECASE)
"""Names of joints and bodies whose damping brakes them on purpose: they roll, spring or spin in air."""

_LOCKS = re.compile(r"lock|brake", re.IGNORECASE)
"""Names of joints and bodies that stay where they are, as a model means it."""


def _from(row: LedgerRow, other: LedgerRow) -> str:
    """Whose figure it is, where another file states it."""
    return "" if other.artifact == row.artifact else f" ({basename(other.file)})"


def _places(row: LedgerRow, other: LedgerRow, field: str) -> tuple[Span, ...]:
    """Where another file states a figure."""
    return () if other.artifact == row.artifact else (other.place(field),)


def _has_spring(case: Case, row: LedgerRow) -> bool:
    """Whether a joint has a stiffness beside its damping: gains of a drive, as Isaac Gym's importer reads them."""
    robot = case.artifacts[row.artifact].robot
    joint = None if robot is None else robot.joint(row.joint)
    return joint is not None and joint.stiffness > 0.0


def _is_stuck(case: Case, row: LedgerRow, speed: float) -> bool:
    """Whether a joint that is driven, and is no gripper's or held one's, moves no faster than would be of any use.

    Args:
        case: The case.
        row: The joint's.
        speed: At which its damping uses the whole effort limit [rad/s or m/s].
    """
    least = 0.0 if row.kind is None else _STUCK.get(row.kind, 0.0)
    if speed >= least or is_held(row) or is_called_undriven(row):
        return False
    return _is_driven(case, row) and not (_is_called(case, row, GRIPS) or _is_called(case, row, _LOCKS))


def _is_driven(case: Case, row: LedgerRow) -> bool:
    """Whether a file of the robot drives a joint."""
    rows = (row, *partner_rows(case, row, FileKind.MJCF, FileKind.CFG, FileKind.SPEC))
    return any(other.control != "none" for other in rows)


def _is_called(case: Case, row: LedgerRow, names: re.Pattern[str]) -> bool:
    """Whether a joint's name, or that of its body, has one of these words."""
    robot = case.artifacts[row.artifact].robot
    joint = None if robot is None else robot.joint(row.joint)
    return bool(names.search(row.joint) or (joint is not None and names.search(joint.body)))


def _brakes_by_intent(case: Case, row: LedgerRow) -> bool:
    """Whether the damping is the model's brake: of a wheel or suspension, or where nothing drives the joint."""
    robot = case.artifacts[row.artifact].robot
    if _is_called(case, row, _DAMPED):
        return True
    return bool(robot and robot.actuators) and not _is_driven(case, row)
