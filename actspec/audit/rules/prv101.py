from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.ir import ActuatorSet, Origin
from actspec.readings.artifact import FileKind
from actspec.units import format_quantity

_MEASURED = (
    "effort_limit", "velocity_limit", "stall_torque", "no_load_speed", "peak_torque", "continuous_torque",
    "armature", "reflected_inertia", "friction_coulomb", "friction_static", "friction_viscous",
)  # fmt: skip
"""Figures of the hardware. Gains, delays, filters and scales are the author's choice and need no source."""


class FigureWithoutSource(RuleOver[ActuatorSet]):
    code = "PRV101"
    name = "figure-without-source"
    severity = Severity.INFO
    confidence = Confidence.HIGH
    needs = "no spec among the files"

    def subjects(self, case: Case) -> Iterator[ActuatorSet]:
        for _, artifact in case.of_kind(FileKind.SPEC):
            if artifact.spec is not None:
                yield artifact.spec

    def judge(self, case: Case, spec: ActuatorSet) -> Iterator[Finding]:
        """Look at every authored figure of the hardware."""
        for actuator in spec.joints:
            for field, quantity in actuator.quantities():
                if field not in _MEASURED or quantity.origin is not Origin.AUTHORED:
                    continue
                if quantity.source or quantity.note or quantity.span is None or quantity.value is None:
                    continue
                figure = format_quantity(quantity.value, quantity.unit, 3)
                yield Finding(
                    self.code,
                    f"no source given for {field.replace('_', ' ')} {figure}: it may be a datasheet's or a guess",
                    quantity.span,
                    actuator.joint,
                    quantity.value,
                    quantity.unit,
                    help="write {value: ..., source: KEY}, with KEY in `sources`, or a note that says whence it is",
                )
