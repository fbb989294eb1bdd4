from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence

from actspec.audit.known import likenesses
from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.joints import by_joint, limit_of, unit
from actspec.audit.rules.unt105 import outweighs
from actspec.diagnostics import Span
from actspec.fields import is_placeholder, is_power_of_ten
from actspec.ir import JointKind
from actspec.readings.artifact import FileKind
from actspec.readings.compare import same
from actspec.readings.ledger import LedgerRow

_Subject = tuple[LedgerRow, Sequence[LedgerRow]]

_WEAK = 0.01
"""Spring of the joint over kp that no figure shows."""

_SERVOS = ("position", "pid", "dcmotor", "implicit", "ideal_pd", "dc_motor")
"""Drives whose kp and kd are gains of a position."""

_PASSIVE = ("joint_damping", "actuator_damping")

_MOTORS = ("dcmotor", "dc_motor")
"""Those with a torque-speed line, which are a motor's and no simulator's own servo."""

_OF_A_THING = re.compile(r"(?<![a-z])(?:door|drawer|cabinet|lid)s?(?![a-z])", re.IGNORECASE)
"""Words of joints with a drive that only brakes."""

_EXPLICIT = "ideal_pd"
"""Of a known robot this is its motors' too: an implicit drive and an MJCF's servo may hold an arm as stiff as one
likes."""


class GainsOfNoJoint(RuleOver[_Subject]):
    code = "UNT107"
    name = "gains-of-no-joint"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    written_over = frozenset({"actuators", "gains"})
    paired = True
    needs = "no configuration or MJCF with a kp among the files"

    def subjects(self, case: Case) -> Iterator[_Subject]:
        """Each joint of a configuration or an MJCF that one servo drives, with all of its actuators."""
        for rows in by_joint(case, FileKind.CFG, FileKind.MJCF).values():
            servos = [row for row in rows if row.kp]
            if len(servos) == 1 and servos[0].control in _SERVOS and "kp" in servos[0].stated:
                yield servos[0], rows

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Judge kp and kd by each other, by the effort limit and by the joint's inertia, as `validate` does."""
        from actspec.spec.plausible.gains import STIFF_RETURN, STIFF_SERVO_RETURN, Gains, gain_words
        from actspec.spec.plausible.relations import DEGREE
        from actspec.spec.plausible.swing import damping_words, frequency_words, is_short

        row, rows = subject
        kds = [each.kd for each in rows]
        if (
            row.kp is None
            or not 0.0 < row.kp < math.inf
            or None in kds
            or min(filter(None, kds), default=0.0) < 0.0
        ):
            return
        hinge = row.kind is not JointKind.SLIDE
        published = case.once(_known_joints).get((row.artifact, row.joint))
        # A motor's line is of an angle as good as always; what a simulator's own servo drives may be a lift.
        known = row.kind is not None or published is not None or row.control in _MOTORS
        driven = row.control in _MOTORS or (row.control == _EXPLICIT and published is not None)
        limit = self._limit(case, row, published if driven else None) if hinge else None
        stiff = 0.0 if is_power_of_ten(row.kp) else STIFF_SERVO_RETURN
        inertia = None if outweighs(row) else row.inertia
        gains = Gains(
            row.kp,
            sum(kd or 0.0 for kd in kds),
            (row.joint_damping or 0.0) + sum(each.actuator_damping or 0.0 for each in rows),
            limit,
            driven,
            STIFF_RETURN if driven else stiff,
            JointKind.HINGE if hinge else JointKind.SLIDE,
            1.0 if driven else math.inf,
            # Of an armature that no torque turns UNT105 tells.
            armature=inertia or 0.0,
            known=known,
        )
        meant = False
        field, message, help = gain_words(gains, {}) or (None, "", None)
        if field is None and hinge and inertia and _swings_by_kp(row):
            if words := frequency_words(gains, inertia):
                field, message, help = "kp", *words[:2]
                # As simulators are told that a joint is rigid.
                meant = not driven and is_power_of_ten(row.kp) and row.kp > inertia
                help = None if meant else help
            elif damped := damping_words(gains, inertia, "the joint's damping"):
                field, message, help = damped[:3]
                # As 80 beside 400, by which arms are held.
                kd = gains.kd or 0.0
                as_typed = field == "kd" and not driven and is_short(kd) and not is_short(kd * DEGREE)
                meant = as_typed and not row.armature and kd**2 > 4.0 * row.kp * inertia
                help = "that inertia is the links' alone: has the motor an armature?" if meant else help
        if field is None:
            return
        # As little kp beside much kd is a servo of the speed, where a program commands speeds, and brakes a door.
        slow = gains.kp < (gains.kd or 0.0) and (
            "positions" in case.written(row.span, row.joint) or _uncommanded(row)
        )
        if field == "viscous":
            # The larger of the two places of it.
            field = max(_PASSIVE, key=lambda name: getattr(row, name) or 0.0)
        yield Finding(
            self.code,
            message,
            row.place(field),
            row.joint,
            getattr(row, field),
            unit(row, field) if known else "",
            help=help,
            related=_other(row, field),
            fields=(field,) if field in _PASSIVE else ("kp", "kd"),
            noted_in_folders=meant or slow,
        )

    def _limit(self, case: Case, row: LedgerRow, published: float | None) -> float | None:
        """The hinge's effort limit, at most what is published of its motor [N*m]; None: unknown."""
        return min(
            (one for one in (limit_of(case, row), published) if one is not None and not is_placeholder(one)),
            default=None,
        )


def _uncommanded(row: LedgerRow) -> bool:
    """Whether a drive is called after a thing's part that a robot moves, and no program."""
    return _OF_A_THING.search(f"{row.actuator} {row.joint}") is not None


def _swings_by_kp(row: LedgerRow) -> bool:
    """Whether the joint swings as its kp and its inertia tell: alone, and without a spring of its own beside the kp."""
    if row.kp is None or row.inertia is None or row.natural_frequency is None:
        return False
    return same(row.natural_frequency**2 * row.inertia, row.kp, _WEAK)


def _known_joints(case: Case) -> dict[tuple[int, str], float]:
    """Rows of known robots, by artifact and joint, with the largest torque that is published of each."""
    return {
        (row.artifact, row.joint): max(effort for name in names for effort in known.robot.efforts(name))
        for known in case.once(likenesses)
        if not known.copied
        for row, names in known.joints
    }


def _other(row: LedgerRow, field: str) -> tuple[Span, ...]:
    """Where the other of kp and kd is written."""
    place = row.place("kd" if field == "kp" else "kp")
    return () if place == row.place(field) else (place,)
