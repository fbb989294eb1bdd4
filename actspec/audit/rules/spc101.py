from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.joints import starts_there_alone
from actspec.audit.rules.source_rule import shown, stated
from actspec.audit.rules.spec_pairs import (
    NO_SPEC,
    SpecJoint,
    counted_twice,
    faster_than_line,
    is_sum,
    spec_joints,
    unit_confused,
)
from actspec.fields import FIELDS
from actspec.ir import Command, Level
from actspec.readings.compare import Figure, times
from actspec.readings.dynamics import is_turned
from actspec.units import format_number

_GAINS = ("kp", "kd")
_COMMAND = ("delay", "action_scale", "default_position")
_FIELDS = (
    *_GAINS,
    *("effort_limit", "velocity_limit", "stall_torque", "no_load_speed"),
    *("armature", "frictionloss", "joint_damping"),
    *_COMMAND,
)
_ABSOLUTE = 1e-3
"""Largest absolute difference of equal figures of the command path [s, rad or m]. Chosen: rounding."""


class FigureDeparts(RuleOver[SpecJoint]):
    code = "SPC101"
    name = "figure-departs-from-spec"
    aliases: ClassVar[dict[str, str]] = {
        "SPC101": "gain-departs-from-spec",
        "SPC102": "limit-departs-from-spec",
        "SPC103": "armature-or-friction-departs-from-spec",
        "SPC104": "command-path-departs-from-spec",
    }
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    paired = True
    needs = NO_SPEC
    options: ClassVar[dict[str, float]] = {"tolerance": 0.01}

    def subjects(self, case: Case) -> Iterator[SpecJoint]:
        yield from spec_joints(case)

    def judge(self, case: Case, joint: SpecJoint) -> Iterator[Finding]:
        """Compare what the file states of the joint with the spec."""
        tolerance = self.option(case, "tolerance")
        for field in _FIELDS:
            mine, wanted = joint.mine(field), joint.wanted(field)
            if mine is None or wanted is None or mine.value is None or wanted.value is None:
                continue
            absolute = _ABSOLUTE if field in _COMMAND else 0.0
            if math.isclose(mine.value, wanted.value, rel_tol=tolerance, abs_tol=absolute):
                continue
            if field == "default_position" and any(starts_there_alone(case, row) for row in joint.rows):
                continue
            if not _is_explained(case, joint, field, tolerance):
                yield self._finding(joint, field, mine, wanted)
        yield from self._turned(joint)
        yield from self._faster(case, joint)

    def _faster(self, case: Case, joint: SpecJoint) -> Iterator[Finding]:
        """A URDF's speed limit that is `GRAVE` times the speed at which the spec's motor has no torque, or more."""
        found = faster_than_line(case, joint)
        if found is None:
            return
        mine, wanted = found
        yield Finding(
            self.code,
            f"the velocity limit is {shown(mine.value, mine.unit)}, and by the spec the joint turns at "
            f"{shown(wanted.value, wanted.unit)} without load{times(mine.value, wanted.value)}",
            mine.place,
            joint.rows[0].joint,
            mine.value,
            mine.unit or None,
            expected=wanted.value,
            help="correct the file or the spec's no-load speed, or state velocity_limit in the spec",
            related=(wanted.place,),
            severity=Severity.WARNING,
            noted_in_folders=True,
            fields=("velocity_limit",),
        )

    def _turned(self, joint: SpecJoint) -> Iterator[Finding]:
        """Servos that go to minus their target; a gain that is not kp is SGN102's, with and without a spec."""
        kp = joint.wanted("kp")
        if joint.actuator.command is not Command.POSITION or kp is None:
            return
        for drive in filter(is_turned, joint.drives):
            yield Finding(
                self.code,
                f"the gear is {format_number(drive.gear)}: the servo goes to minus its target, and the spec's to its "
                "target",
                drive.places.get("gear", drive.span),
                joint.rows[0].joint,
                drive.gear,
                expected=-drive.gear,
                help="compile the file from the spec, or write the gear without the minus",
                related=(kp.place,),
                fields=("command_gain",),
            )

    def _finding(self, joint: SpecJoint, field: str, mine: Figure, wanted: Figure) -> Finding:
        assert mine.value is not None and wanted.value is not None
        if math.isinf(mine.value):
            text = f"there is no {FIELDS[field].noun}"
        elif mine.stated:
            text = f"the {FIELDS[field].noun} is {stated(mine)}"
        else:
            text = f"the {FIELDS[field].noun} is not written, so {shown(mine.value, mine.unit)}"
        return Finding(
            self.code,
            f"{text}, and the spec says {shown(wanted.value, wanted.unit)}{times(mine.value, wanted.value)}",
            mine.place,
            joint.rows[0].joint,
            mine.value,
            mine.unit or None,
            expected=wanted.value,
            help="compile the file from the spec, or correct the spec",
            related=(wanted.place,),
            fields=(field,),
        )


def _is_explained(case: Case, joint: SpecJoint, field: str, tolerance: float) -> bool:
    """Whether another rule says more about it: a network, damping that is counted twice, or a unit."""
    if field in _GAINS and joint.actuator.level is Level.ACTUATOR_NET:
        return True
    if field == "kd" and is_sum(joint, tolerance):
        return True
    if field in ("kd", "joint_damping"):
        return counted_twice(joint, tolerance) is not None
    return field == "frictionloss" and unit_confused(case, joint, tolerance) is not None
