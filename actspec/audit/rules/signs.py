"""SGN: figures that cannot be negative."""

from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.ledger import LedgerRow
from actspec.audit.rule import Rule
from actspec.audit.rules.joint_units import shown, unit
from actspec.diagnostics import Severity
from actspec.readings.artifact import FileKind
from actspec.robot.view import ActuatorView


class NegativeGain(Rule):
    """A drive's gain has the wrong sign.

    ## What it does
    Reports drives whose stiffness or velocity gain is negative in force: a position servo with `kp` below 0 or with a
    positive second number in `biasprm`, a velocity gain below 0, a configuration with a negative stiffness or damping.

    ## Why it matters
    A negative kp pushes the joint away from where it is told to be; a negative kd drives every motion on. Both run
    away until a limit stops them.

    ## Example
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <general joint="knee" gainprm="50" biastype="affine" biasprm="0 50 -2"/>
      </actuator>
    </mujoco>
    ```

    ## Use instead
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <general joint="knee" gainprm="50" biastype="affine" biasprm="0 -50 -2"/>
      </actuator>
    </mujoco>
    ```

    ## Limits
    A `general` actuator whose gain is 0 is a passive spring, and not judged.

    ## Source
    MuJoCo 3.7, 3.11 and 4.0, measured: force = gainprm[0] u + biasprm[0] + biasprm[1] q + biasprm[2] w. A negative
    kp compiles everywhere; a negative kv only in `general` and `velocity`.
    """

    code = "SGN101"
    name = "negative-drive-gain"
    severity = Severity.ERROR
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find negative kp and kd."""
        looked = False
        springs = {a.span for a in _actuators(case) if a.control == "position" and a.gain == 0.0}
        for row in case.rows:
            if row.kp is None and row.kd is None:
                continue
            looked = True
            if row.span in springs:
                continue
            if row.kp is not None and row.kp < 0.0:
                yield self._finding(row, "kp", row.kp, "it pushes the joint away from its target")
            if row.kd is not None and row.kd < 0.0:
                yield self._finding(row, "kd", row.kd, "it drives every motion on instead of braking it")
        if not looked:
            yield Skipped(self.code, "no drive with a gain among the files")

    def _finding(self, row: LedgerRow, field: str, value: float, effect: str) -> Finding:
        return Finding(
            self.code,
            f"{field} is {shown(row, field, value)}: {effect}",
            row.place(field),
            row.joint,
            value,
            unit(row, field),
            -value,
            'gains are positive; in biasprm the feedback stands with a minus: biasprm="0 -kp -kd"',
        )


def _actuators(case: Case) -> Iterator[ActuatorView]:
    for _, artifact in case.of_kind(FileKind.MJCF):
        if artifact.robot is not None:
            yield from artifact.robot.actuators


class NegativePassiveValue(Rule):
    """A passive property of a joint is negative.

    ## What it does
    Reports joint damping, actuator damping, dry friction and armature below 0, in any file.

    ## Why it matters
    Nature has none of them. MuJoCo takes all: negative damping feeds energy into the joint until it runs away,
    negative armature takes inertia away from the links, negative dry friction pushes the joint on.

    ## Example
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee" damping="-0.5"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
    </mujoco>
    ```

    ## Use instead
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee" damping="0.5"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
    </mujoco>
    ```

    ## Limits
    Damping with quadratic or cubic terms is not judged by its linear term alone.

    ## Source
    MuJoCo 3.7, 3.11 and 4.0, measured: all four compile when negative; with frictionloss -0.3 and inertia 1 a joint at
    1 rad/s runs at 1.3 rad/s after a second.
    """

    code = "SGN105"
    name = "negative-passive-value"
    severity = Severity.ERROR
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find passive values below 0."""
        looked = False
        polynomial = _with_polynomial(case)
        for row in case.rows:
            for field, effect in _EFFECTS.items():
                value: float | None = getattr(row, field)
                if value is None or field not in row.stated:
                    continue
                looked = True
                if value >= 0.0 or ("damping" in field and (row.artifact, row.joint) in polynomial):
                    continue
                yield Finding(
                    self.code,
                    f"the {field.replace('_', ' ')} of {shown(row, field, value)} is negative: {effect}",
                    row.place(field),
                    row.joint,
                    value,
                    unit(row, field),
                    -value,
                    "write it without the minus, or leave it out",
                )
        if not looked:
            yield Skipped(self.code, "no file states damping, friction or armature of a joint")


_EFFECTS = {
    "joint_damping": "it feeds energy into every motion",
    "actuator_damping": "it feeds energy into every motion",
    "frictionloss": "it pushes a moving joint on",
    "armature": "it takes inertia away from the links",
}


def _with_polynomial(case: Case) -> set[tuple[int, str]]:
    """Joints with damping terms of higher order, their own or an actuator's."""
    found = set()
    for index, artifact in case.of_kind(FileKind.MJCF):
        if artifact.robot is not None:
            found |= {(index, joint.name) for joint in artifact.robot.joints if any(joint.damping_polynomial)}
            found |= {(index, act.target) for act in artifact.robot.actuators if any(act.damping[1:])}
    return found


RULES: tuple[type[Rule], ...] = (NegativeGain, NegativePassiveValue)
