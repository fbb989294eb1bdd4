from __future__ import annotations

from collections.abc import Iterable, Iterator

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.actuator_texts import WrittenActuator, written_actuators
from actspec.diagnostics import Span
from actspec.readings.versions import Meant, mujoco_of
from actspec.simulators.mujoco import TORQUE_SPACE
from actspec.units import format_number

_VOLTAGE_INPUTS = frozenset({"position", "velocity"})

_TORQUE_INPUTS = frozenset({"pos", "vel", "ff", "none"})


_Subject = list[tuple[WrittenActuator, str]]
"""The motors of one file, each with its dialect."""


class DcmotorDialect(RuleOver[_Subject]):
    code = "VER102"
    name = "dcmotor-dialect"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    needs = "no dcmotor among the files"

    def subjects(self, case: Case) -> Iterable[_Subject]:
        """Tell the dialects apart."""
        motors: dict[str, _Subject] = {}
        for found in written_actuators(case, b"<dcmotor"):
            if found.element.tag == "dcmotor":
                motors.setdefault(found.artifact.path, []).append((found, _dialect(found)))
        return motors.values()

    def judge(self, case: Case, members: _Subject) -> Iterator[Finding]:
        meant = mujoco_of(case.versions)
        voltage = [found for found, dialect in members if dialect == "voltage"]
        torque = [found for found, dialect in members if dialect == "torque"]
        for found, dialect in members:
            finding = self._open_loop(found) if dialect == "" else None
            if dialect == "voltage":
                finding = self._voltage(found, meant, torque)
            elif dialect == "torque":
                finding = self._torque(found, meant, voltage)
            if finding is not None:
                yield finding

    def _open_loop(self, found: WrittenActuator) -> Finding | None:
        if not any(found.text.gain[slot] for slot in (4, 5, 6)):
            return None
        return Finding(
            self.code,
            "controller gains without an input that closes the loop: MuJoCo 3.7 to 3.11 drives this motor by voltage "
            "and ignores them, and 3.12 and later refuses the file",
            found.view.span,
            found.joint,
            help='add input="pos" (3.12 and later, gains in N*m/rad) or input="position" (3.7 to 3.11, gains in V/rad)',
        )

    def _voltage(
        self, found: WrittenActuator, meant: Meant | None, torque: list[WrittenActuator]
    ) -> Finding | None:
        written = _input(found)
        text = f'input="{written}" is the dialect of MuJoCo 3.7 to 3.11, with gains in V/rad'
        if meant is None and not torque:
            return self._finding(found, f"{text}: 3.12 and later refuses the file", (), Severity.INFO)
        if meant is not None:
            return None if meant.before(TORQUE_SPACE) else self._refused(found, text, meant)
        other = torque[0]
        return self._finding(
            found,
            f'{text}, and input="{_input(other)}" that of 3.12 and later: no release loads this file',
            (other.view.span,),
            self.severity,
        )

    def _torque(
        self, found: WrittenActuator, meant: Meant | None, voltage: list[WrittenActuator]
    ) -> Finding | None:
        # Beside the other dialect one finding is enough, and the older one has to be changed.
        if meant is None or not meant.before(TORQUE_SPACE):
            return None
        text = f'input="{_input(found)}" is the dialect of MuJoCo 3.12 and later, with gains in N*m/rad'
        return self._refused(found, text, meant)

    def _refused(self, found: WrittenActuator, text: str, meant: Meant) -> Finding:
        return self._finding(found, f"{text}: {meant.text} refuses the file", (), self.severity)

    def _finding(
        self, found: WrittenActuator, text: str, related: tuple[Span, ...], severity: Severity
    ) -> Finding:
        return Finding(
            self.code,
            text,
            found.view.span,
            found.joint,
            help=_translation(found),
            related=related,
            severity=severity,
            about=f"input={_input(found)}",
        )


def _input(found: WrittenActuator) -> str:
    owner = found.owner("input")
    return " ".join((owner.get("input") or "").split()) if owner is not None else ""


def _dialect(found: WrittenActuator) -> str:
    """`voltage` (3.7 to 3.11), `torque` (3.12 and later), or "" for a motor that both drive by voltage."""
    words = set(_input(found).split())
    if words & _VOLTAGE_INPUTS:
        return "voltage"
    return "torque" if words & _TORQUE_INPUTS else ""


def _translation(found: WrittenActuator) -> str:
    """The same motor in the other dialect: R/K turns torque into voltage, and back-EMF is K w."""
    resistance, constant, kp, kd = (found.text.gain[slot] for slot in (0, 1, 4, 6))
    if not (resistance > 0.0 and constant > 0.0):
        return "K/R times a gain in V/rad is the gain in N*m/rad"
    ratio = resistance / constant
    if _dialect(found) == "voltage":
        if "velocity" in _input(found):
            return f'from 3.12 on: input="vel" with the gains times {format_number(1.0 / ratio)}'
        return (
            f'from 3.12 on: input="pos" with kp {format_number(kp / ratio)} N*m/rad and kd '
            f"{format_number(kd / ratio + constant / ratio)} N*m*s/rad as first and third number of the controller"
        )
    return (
        f'up to 3.11: input="position" with {format_number(kp * ratio)} V/rad and '
        f"{format_number(kd * ratio - constant)} V*s/rad as first and third number of the controller"
    )
