"""UNT: the same figure in two files, in two units."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.ledger import LedgerRow
from actspec.audit.rule import Rule
from actspec.audit.rules.joint_units import shown, unit
from actspec.audit.rules.partners import joint_pairs, shared_joints
from actspec.diagnostics import Severity, Span
from actspec.ir import JointKind

_DEGREES = 180.0 / math.pi
_RPM = 30.0 / math.pi
_ONE_FILE = "no two files of one robot with the same joint"


class Factor57(Rule):
    """Two files of a robot differ by 57.3, which is degrees per radian.

    ## What it does
    Compares gains, damping, speed limits, ranges and default positions of the same joint in two files, and reports
    pairs off by 180/pi, within `relative` (default 0.005). An error where two or more figures of a joint are.

    ## Why it matters
    A gain per degree is 57.3 times smaller than the same gain per radian. Where it lands in a slot for the other, the
    joint is 57 times too soft (it falls) or too stiff (it shakes, or the simulation diverges).

    ## Example
    ```xml leg.xml
    <mujoco model="leg">
      <worldbody>
        <body>
          <joint name="knee_joint"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <position joint="knee_joint" kp="0.4363" kv="0.008727"/>
      </actuator>
    </mujoco>
    ```
    ```python leg_cfg.py
    from isaaclab.actuators import ImplicitActuatorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={"legs": ImplicitActuatorCfg(joint_names_expr=[".*_joint"], stiffness=25.0, damping=0.5)}
    )
    ```

    ## Use instead
    ```xml leg.xml
    <mujoco model="leg">
      <worldbody>
        <body>
          <joint name="knee_joint"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <position joint="knee_joint" kp="25" kv="0.5"/>
      </actuator>
    </mujoco>
    ```

    ## Source
    isaac-sim/IsaacSim#842 and newton-physics/newton#2504: converters copied per-degree gains of USD to per-radian
    slots. Chosen: 0.5 %, three rounded digits.
    """

    code = "UNT103"
    name = "off-by-degrees-per-radian"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    paired = True
    options: ClassVar[dict[str, float]] = {"relative": 0.005}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare figures of the same joint."""
        relative = self.option(case, "relative")

        def off_pairs(one: LedgerRow, other: LedgerRow) -> list[_Pair]:
            if JointKind.SLIDE in (one.kind, other.kind):
                return []
            return [pair for pair in _angular(one, other) if _off_by(*pair.values, _DEGREES, relative)]

        for one, other in joint_pairs(case, _figures, lambda one, other: bool(off_pairs(one, other))):
            off = off_pairs(one, other)
            severity = Severity.ERROR if len({pair.place for pair in off}) > 1 else self.severity
            for pair in off:
                yield self._finding(one, other, pair, severity)
        if next(shared_joints(case), None) is None:
            yield Skipped(self.code, _ONE_FILE)

    def _finding(self, one: LedgerRow, other: LedgerRow, pair: _Pair, severity: Severity) -> Finding:
        first, second = pair.values
        # A gain is smaller per degree, an angle or a speed is larger in degrees.
        per_angle = pair.place in _PER_ANGLE
        if (abs(first) < abs(second)) != per_angle:
            one, other, first, second = other, one, second, first
        factor = "1/57.3 of" if per_angle else "57.3 times"
        what = (
            "a figure per degree, taken per radian" if per_angle else "a figure in degrees, taken for radians"
        )
        return Finding(
            self.code,
            f"the {pair.name} of {shown(one, pair.unit, first, 4)} is {factor} the "
            f"{shown(one, pair.unit, second, 4)} in {other.place(pair.place).path}: {what}",
            one.place(pair.place),
            one.joint,
            first,
            unit(one, pair.unit),
            second,
            "1 rad is 57.3 degrees: convert the figure, or correct the other file",
            (other.place(pair.place),),
            severity=severity,
        )


@dataclass(frozen=True, slots=True)
class _Pair:
    """A figure of one joint in two files.

    Attributes:
        place: Field of the row that tells where it is written.
        unit: Field of the row that has its unit.
        name: For messages.
        values: In the one file and in the other.
    """

    place: str
    unit: str
    name: str
    values: tuple[float, float]


_PER_ANGLE = ("kp", "kd", "joint_damping")
_SPEEDS = ("velocity_limit", "no_load_speed")


def _figures(row: LedgerRow) -> tuple[object, ...]:
    """What is compared of a row."""
    stated = (*_PER_ANGLE, *_SPEEDS, "position_range")
    return (
        row.kind,
        row.default_position,
        *(getattr(row, name) if name in row.stated else None for name in stated),
    )


def _angular(one: LedgerRow, other: LedgerRow) -> Iterator[_Pair]:
    """Figures that have an angle in their unit and that both files state."""
    for field in _PER_ANGLE:
        yield from _both(one, other, field)
    yield from _speeds(one, other)
    pose = one.default_position, other.default_position
    if pose[0] is not None and pose[1] is not None and pose[0] != pose[1]:
        yield _Pair("default_position", "default_position", "default position", (pose[0], pose[1]))
    mine, its = one.position_range, other.position_range
    if mine is None or its is None or mine == its:
        return
    if "position_range" not in one.stated or "position_range" not in other.stated:
        return
    for end, name in enumerate(("lower", "upper")):
        yield _Pair("position_range", "default_position", f"{name} end of the range", (mine[end], its[end]))


def _both(one: LedgerRow, other: LedgerRow, field: str) -> Iterator[_Pair]:
    mine, its = getattr(one, field), getattr(other, field)
    if mine is not None and its is not None and mine != its and field in one.stated and field in other.stated:
        yield _Pair(field, field, field.replace("_", " "), (mine, its))


def _speeds(one: LedgerRow, other: LedgerRow) -> Iterator[_Pair]:
    """Speed limits and no-load speeds, each with its like."""
    for field in _SPEEDS:
        yield from _both(one, other, field)


def _off_by(one: float, other: float, factor: float, relative: float) -> bool:
    """Whether two figures differ by a factor, either way."""
    if one == 0.0 or other == 0.0 or not (math.isfinite(one) and math.isfinite(other)):
        return False
    ratio = one / other
    return math.isclose(max(ratio, 1.0 / ratio), factor, rel_tol=relative)


class SpeedInRpm(Rule):
    """A speed is in revolutions per minute where rad/s are read.

    ## What it does
    Reports speed limits and no-load speeds that are 9.55 times the same joint's in another file, within `relative`
    (default 0.005); and, as a remark, hinges whose speed is `least` (default 150 rad/s) or more and a round number.

    ## Why it matters
    200 rpm are 20.9 rad/s. Read as 200 rad/s the limit never acts, and a torque-speed line hardly falls: the policy
    has full torque at speeds at which the motor has none.

    ## Example
    ```xml leg.urdf
    <robot name="leg">
      <link name="base"/>
      <link name="shank"/>
      <joint name="knee_joint" type="revolute">
        <parent link="base"/>
        <child link="shank"/>
        <axis xyz="0 1 0"/>
        <limit lower="-2" upper="0" effort="33.5" velocity="200"/>
      </joint>
    </robot>
    ```

    ## Use instead
    ```xml leg.urdf
    <robot name="leg">
      <link name="base"/>
      <link name="shank"/>
      <joint name="knee_joint" type="revolute">
        <parent link="base"/>
        <child link="shank"/>
        <axis xyz="0 1 0"/>
        <limit lower="-2" upper="0" effort="33.5" velocity="20.9"/>
      </joint>
    </robot>
    ```

    ## Limits
    Propellers and wheels without a gear do turn that fast.

    ## Source
    1 rad/s is 9.549 rpm. Chosen: the fastest joint in Unitree's URDF has 100.7 rad/s (H2, ankle roll).
    """

    code = "UNT104"
    name = "speed-in-rpm"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    paired = True
    options: ClassVar[dict[str, float]] = {"relative": 0.005, "least": 150.0}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare speeds with other files', and with what joints do."""
        looked = False
        told: set[tuple[Span, str]] = set()
        relative = self.option(case, "relative")

        def in_rpm(one: LedgerRow, other: LedgerRow) -> list[tuple[LedgerRow, str, float, float, Span]]:
            if JointKind.SLIDE in (one.kind, other.kind):
                return []
            return [
                (mine, *ratio)
                for mine, its in ((one, other), (other, one))
                for ratio in _speed_ratios(mine, its)
                if math.isclose(ratio[1] / ratio[2], _RPM, rel_tol=relative)
            ]

        for one, other in joint_pairs(case, _speed_figures, lambda one, other: bool(in_rpm(one, other))):
            for mine, field, limit, right, place in in_rpm(one, other):
                told.add((mine.place(field), mine.joint))
                yield Finding(
                    self.code,
                    f"{shown(mine, field, limit, 4)} is 9.55 times the {shown(mine, field, right, 4)} in "
                    f"{place.path}: a figure in rpm",
                    mine.place(field),
                    mine.joint,
                    limit,
                    unit(mine, field),
                    right,
                    f"{limit:.4g} rpm is {limit / _RPM:.3g} rad/s",
                    (place,),
                )
        for row in case.rows:
            for field in _SPEEDS:
                speed: float | None = getattr(row, field)
                if speed is None or field not in row.stated or row.kind is JointKind.SLIDE:
                    continue
                looked = True
                if (row.place(field), row.joint) in told or speed % 10.0 != 0.0:
                    continue
                if self.option(case, "least") <= speed < _PLACEHOLDER:
                    yield Finding(
                        self.code,
                        f"{shown(row, field, speed, 4)} is more than a joint behind a gear turns; {speed:.4g} rpm "
                        f"would be {speed / _RPM:.3g} rad/s",
                        row.place(field),
                        row.joint,
                        speed,
                        unit(row, field),
                        help="speeds are in rad/s",
                        severity=Severity.INFO,
                        confidence=Confidence.LOW,
                    )
        if not looked:
            yield Skipped(self.code, "no file states the speed of a hinge")


_PLACEHOLDER = 1e5


def _speed_figures(row: LedgerRow) -> tuple[object, ...]:
    """What is compared of a row."""
    return row.kind, *(getattr(row, name) if name in row.stated else None for name in _SPEEDS)


def _speed_ratios(one: LedgerRow, other: LedgerRow) -> Iterator[tuple[str, float, float, Span]]:
    """Speeds of one row, each with those of the other: field, the two values, and where the other stands."""
    for field in _SPEEDS:
        mine: float | None = getattr(one, field)
        for name in _SPEEDS:
            its: float | None = getattr(other, name)
            if mine and its and math.isfinite(mine) and field in one.stated and name in other.stated:
                yield field, mine, its, other.place(name)


RULES: tuple[type[Rule], ...] = (Factor57, SpeedInRpm)
