from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.joints import own_figure, partner_rows, shown, unit
from actspec.diagnostics import Span
from actspec.fields import PLACEHOLDER
from actspec.ir import JointActuator, Quantity
from actspec.readings.artifact import FileKind
from actspec.readings.ledger import LedgerRow
from actspec.units import format_number

_Subject = tuple[LedgerRow, LedgerRow, str, Quantity, str, float, float]


class AboveDatasheet(RuleOver[_Subject]):
    code = "LIM108"
    name = "limit-above-datasheet"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    paired = True
    needs = "no spec with a motor's figures beside another file that limits the joint"
    options: ClassVar[dict[str, float]] = {"ratio": 1.1}

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for index, artifact in case.of_kind(FileKind.SPEC):
            assert artifact.spec is not None
            actuators = {actuator.joint: actuator for actuator in artifact.spec.joints}
            for spec in case.rows_of(index):
                torque, speed = _motor_torque(actuators[spec.joint]), actuators[spec.joint].no_load_speed
                for row in partner_rows(case, spec):
                    for field, motor, noun in (
                        ("effort_limit", torque, "torque"),
                        ("no_load_speed", speed, "no-load speed"),
                    ):
                        limit: float | None = getattr(row, field)
                        if motor is None or motor.value is None or limit is None or field not in row.stated:
                            continue
                        yield spec, row, field, motor, noun, limit, motor.value

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Compare with the specs' motors."""
        spec, row, field, motor, noun, limit, most = subject
        if self.option(case, "ratio") * most <= limit < PLACEHOLDER:
            yield self._finding(row, field, limit, motor, most, noun, spec.span)

    def _finding(
        self, row: LedgerRow, field: str, limit: float, motor: Quantity, most: float, noun: str, span: Span
    ) -> Finding:
        source = "" if motor.source is None else f" (source {motor.source})"
        return Finding(
            self.code,
            f"{own_figure(row, field)} is {format_number(limit / most, 3)} times the {noun} of "
            f"{shown(row, field, most)} that the "
            f"motor has by its spec{source}: the simulated robot can do what the real one cannot",
            row.place(field),
            row.joint,
            limit,
            unit(row, field),
            most,
            "set the limit to the motor's figure, or correct the spec",
            (motor.span or span,),
            fields=(field,),
        )


def _motor_torque(actuator: JointActuator) -> Quantity | None:
    """The largest torque that the motor is said to have."""
    curve = actuator.curve
    candidates = [actuator.peak_torque, actuator.stall_torque]
    candidates += [] if curve is None else [curve.drive_torque, curve.brake_torque]
    known = [(one.value, one) for one in candidates if one is not None and one.value is not None]
    return max(known, key=lambda pair: pair[0])[1] if known else None
