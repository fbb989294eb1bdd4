"""DRN: ranges whose ends are wrong, or far beyond what was measured."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.ledger import LedgerRow
from actspec.audit.rule import Rule
from actspec.audit.rules.randomized import DEVIATIONS, ends, nominal, range_unit, ranges, rows_in, written
from actspec.diagnostics import Severity
from actspec.ir import JointActuator, Quantity
from actspec.readings.artifact import Framework, RandomizedRange, RobotConfig
from actspec.units import format_quantity

_POSITIVE = ("kp", "kd", "armature", "friction", "joint_damping", "effort_limit", "strength")
"""Fields that are never negative."""


class RangeWiderThanIdentified(Rule):
    """A range is many times as wide as what an identification left open.

    ## What it does
    Compares the ranges of a configuration with the spec of the robot where that states a standard deviation: reported
    from `ratio` times (default 5) three deviations to either side, and where the range leaves out the value.

    ## Why it matters
    What has been measured need not be guessed. A range far beyond the measurement's doubt costs performance for
    robots that there are not; one beside it trains for another robot.

    ## Example
    ```yaml robot.yaml
    actspec: 1
    robot: {name: leg, model: none, joints: [knee_joint]}
    timing: {physics_dt: 5 ms, decimation: 4}
    actuators:
      legs:
        joints: [knee_joint]
        level: ideal_pd
        kp: {value: 20 N*m/rad, std: 0.2 N*m/rad}
        kd: 0.5 N*m*s/rad
        effort_limit: 30 N*m
        armature: 0.01 kg*m^2
        friction: {coulomb: 0.1 N*m, viscous: 0.01 N*m*s/rad}
    ```
    ```python dog_config.py
    class DogCfg:
        class control:
            control_type = "P"
            stiffness = {"joint": 20.0}
            damping = {"joint": 0.5}

        class domain_rand:
            randomize_kp = True
            kp_range = [0.5, 1.5]
    ```

    ## Use instead
    ```python dog_config.py
    class DogCfg:
        class control:
            control_type = "P"
            stiffness = {"joint": 20.0}
            damping = {"joint": 0.5}

        class domain_rand:
            randomize_kp = True
            kp_range = [0.97, 1.03]
    ```

    ## Limits
    A deviation covers one robot on one day; units of a series and wear are wider.

    ## Source
    Chosen: three deviations hold 99.7 % of what the measurement allows; five times that is no longer its doubt.
    """

    code = "DRN103"
    name = "range-wider-than-identified"
    severity = Severity.INFO
    confidence = Confidence.MEDIUM
    paired = True
    options: ClassVar[dict[str, float]] = {"ratio": 5.0}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare ranges with deviations."""
        looked = False
        for index, config, one in ranges(case):
            for row in rows_in(case, index, one):
                measured = _identified(case, row, one)
                value = nominal(case, config, row, one)
                if measured is None or measured.value is None or not measured.std:
                    continue
                if value is None and one.operation != "abs":
                    continue
                looked = True
                found = self._judge(case, row, one, value or 0.0, measured)
                if found is not None:
                    yield found
        if not looked:
            yield Skipped(self.code, "no range of a figure for which a spec states a standard deviation")

    def _judge(
        self, case: Case, row: LedgerRow, one: RandomizedRange, value: float, measured: Quantity
    ) -> Finding | None:
        low, high = ends(one)
        if one.operation == "scale":
            low, high = sorted((low * value, high * value))
        elif one.operation == "add":
            low, high = low + value, high + value
        middle, std = measured.require(), measured.std or 0.0
        ratio = (high - low) / (2.0 * DEVIATIONS * std)
        unit = measured.unit
        if low <= middle <= high and ratio < self.option(case, "ratio"):
            return None
        told = (
            f"which is {ratio:.2g} times its three deviations to either side"
            if low <= middle <= high
            else "which leaves that out"
        )
        low_, high_ = (middle - DEVIATIONS * std, middle + DEVIATIONS * std)
        return Finding(
            self.code,
            f"{one.field} was measured as {format_quantity(middle, unit, 3)} with a deviation of "
            f"{format_quantity(std, unit, 2)}, and is randomised from {written(low, high, unit)}, {told}",
            one.span,
            row.joint,
            help=f"three deviations are {written(low_, high_, unit)}",
            related=() if measured.span is None else (measured.span,),
        )


def _identified(case: Case, row: LedgerRow, one: RandomizedRange) -> Quantity | None:
    """The spec's figure of the randomised field."""
    for index in case.robot_of(row.artifact).artifacts:
        spec = case.artifacts[index].spec
        for joint in spec.joints if spec is not None else ():
            if joint.joint == row.joint:
                return _figure(joint, one.field)
    return None


def _figure(joint: JointActuator, field: str) -> Quantity | None:
    figures = {
        "kp": joint.kp,
        "kd": joint.kd,
        "armature": joint.armature,
        "friction": joint.friction_coulomb,
        "joint_damping": joint.friction_viscous,
        "effort_limit": joint.effort_limit,
    }
    return figures.get(field)


class RangeInvertedOrNegative(Rule):
    """A range is the wrong way round, or reaches values that no joint has.

    ## What it does
    Reports ranges whose lower end is above the upper one, ranges of a log-uniform distribution that reach 0, normal
    distributions with a negative deviation, and ranges in which a gain, friction, armature, limit or strength is
    negative.

    ## Why it matters
    A negative kp pushes the joint away from its target, a negative kd drives it on, and a negative armature can make
    the mass matrix indefinite; the logarithm of 0 fills the simulation with nan. Isaac Lab 2.3 refuses some
    of these for scale, when the environment is made; none for add and abs.

    ## Example
    ```python cfg.py
    import isaaclab.envs.mdp as mdp
    from isaaclab.managers import EventTermCfg, SceneEntityCfg
    from isaaclab.utils import configclass


    @configclass
    class EventCfg:
        gains = EventTermCfg(
            func=mdp.randomize_actuator_gains,
            mode="reset",
            params={
                "asset_cfg": SceneEntityCfg("robot", joint_names=".*"),
                "damping_distribution_params": (0.0, 2.0),
                "operation": "scale",
                "distribution": "log_uniform",
            },
        )
    ```

    ## Use instead
    ```python cfg.py
    import isaaclab.envs.mdp as mdp
    from isaaclab.managers import EventTermCfg, SceneEntityCfg
    from isaaclab.utils import configclass


    @configclass
    class EventCfg:
        gains = EventTermCfg(
            func=mdp.randomize_actuator_gains,
            mode="reset",
            params={
                "asset_cfg": SceneEntityCfg("robot", joint_names=".*"),
                "damping_distribution_params": (0.5, 2.0),
                "operation": "scale",
                "distribution": "log_uniform",
            },
        )
    ```

    ## Limits
    The tails of a normal distribution are not judged. Isaac Lab sets friction that would be negative to 0.

    ## Source
    Isaac Lab 2.3.2, envs/mdp/events.py (`_validate_scale_range`) and utils/math.py; mjlab 1.6.0, envs/mdp/dr.
    """

    code = "DRN106"
    name = "range-inverted-or-negative"
    severity = Severity.ERROR
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Look at the ends."""
        looked = False
        for index, config, one in ranges(case):
            looked = True
            if one.distribution == "gaussian":
                if one.high < 0.0:
                    yield Finding(
                        self.code,
                        f"{one.field} has a deviation of {one.high:g}: for `gaussian` the range is mean and deviation",
                        one.span,
                    )
                continue
            if one.low > one.high:
                yield Finding(
                    self.code,
                    f"{one.field} is randomised from {one.low:g} to {one.high:g}: the lower end is above the upper one",
                    one.span,
                    help=f"({one.high:g}, {one.low:g})",
                    severity=Severity.WARNING,
                )
            low, high = ends(one)
            if one.distribution == "log_uniform" and low <= 0.0:
                yield Finding(
                    self.code,
                    f"{one.field} is drawn log-uniformly from {written(low, high)}: the logarithm of {low:g} is not a "
                    "number",
                    one.span,
                )
            elif one.field in _POSITIVE and not _clamped(config, one):
                yield from self._negative(case, index, config, one)
        if not looked:
            yield Skipped(self.code, "no configuration randomises actuators")

    def _negative(
        self, case: Case, index: int, config: RobotConfig, one: RandomizedRange
    ) -> Iterator[Finding]:
        low, high = ends(one)
        if one.operation in ("scale", "abs"):
            if low < 0.0:
                yield Finding(
                    self.code,
                    f"{one.field} is randomised by {one.operation} {written(low, high)}, and is negative at its low "
                    "end",
                    one.span,
                )
            return
        for row in rows_in(case, index, one):
            value = nominal(case, config, row, one)
            if value is not None and value + low < 0.0 <= value:
                unit = range_unit(config, row, one)
                yield Finding(
                    self.code,
                    f"{one.field} is {format_quantity(value, unit, 3)} and is randomised by add {written(low, high)}: "
                    f"it is negative down to {format_quantity(value + low, unit, 3)}",
                    one.span,
                    row.joint,
                    value + low,
                    unit,
                    help="randomise by scale",
                    related=(row.span,),
                )


def _clamped(config: RobotConfig, one: RandomizedRange) -> bool:
    return one.field == "friction" and config.framework is Framework.ISAACLAB


RULES: tuple[type[Rule], ...] = (RangeWiderThanIdentified, RangeInvertedOrNegative)
