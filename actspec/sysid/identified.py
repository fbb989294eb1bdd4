"""What a fit says: figures with intervals, what the logs cannot tell, and why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from actspec.diagnostics import Diagnostic
from actspec.joints import JointKind
from actspec.units import Kind, format_number

METHODS = ("rollout", "frequency", "step", "friction")
"""Ways to fit a log; results of another method are another tool's, and name its file in place of logs."""


class State(str, Enum):
    """How a figure came out."""

    IDENTIFIED = "identified"
    HELD = "held"
    UNIDENTIFIABLE = "unidentifiable"
    AT_BOUND = "at_bound"


FIELDS: Mapping[str, tuple[str, Kind]] = {
    "kp": ("kp", Kind.STIFFNESS),
    "kd": ("kd", Kind.VELOCITY_GAIN),
    "armature": ("armature", Kind.INERTIA),
    "coulomb": ("friction.coulomb", Kind.TORQUE),
    "viscous": ("friction.viscous", Kind.VELOCITY_GAIN),
    "static": ("friction.static", Kind.TORQUE),
    "stribeck_velocity": ("friction.stribeck_velocity", Kind.SPEED),
    "delay": ("delay", Kind.TIME),
    "bias": ("encoder_bias", Kind.POSITION),
    "lag": ("bandwidth", Kind.FREQUENCY),
}
"""Figure of a motion to its name in a spec's `randomize` and in results, and its kind."""

FIGURE = {field: name for name, (field, _) in FIELDS.items()}
"""The reverse."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """One figure of a joint.

    Attributes:
        field: As in `randomize`, and `bandwidth`.
        state: How it came out.
        value: SI; None unless identified or held.
        std: Standard deviation; None unless identified.
        low: Lower end of the 95 % interval; None unless identified or at a bound.
        high: Upper end.
        unit: SI unit.
        why: Why it is not identified, or where it is held from; "" where there is nothing to say.
    """

    field: str
    state: State
    value: float | None
    std: float | None
    low: float | None
    high: float | None
    unit: str
    why: str = ""


def bounded(field: str, value: float, std: float, low: float, high: float, unit: str) -> Parameter:
    """A figure that cannot be below 0: identified, or at its bound where the interval reaches 0."""
    if low > 0.0:
        return Parameter(field, State.IDENTIFIED, value, std, low, high, unit)
    shown = f"{format_number(1e3 * high, 2)} ms" if unit == "s" else f"{format_number(high, 2)} {unit}"
    return Parameter(field, State.AT_BOUND, None, None, 0.0, high, unit, f"anything from 0 to {shown} fits")


@dataclass(frozen=True, slots=True)
class Combination:
    """What a log tells of several figures together.

    Attributes:
        name: As a formula of fields, such as `kd+friction.viscous`.
        value: SI.
        std: Standard deviation.
        unit: SI unit.
    """

    name: str
    value: float
    std: float
    unit: str


@dataclass(frozen=True, slots=True)
class Indicator:
    """What a log tells of the experiment or of the closed loop; no figure of the spec, and never compiled.

    Attributes:
        name: Such as `torque_scale`.
        value: SI; None: the log does not tell it.
        std: Standard deviation; None: unknown.
        unit: SI unit; `1` for a share or a factor.
        why: Why it has no value; "" where it has one.
    """

    name: str
    value: float | None
    std: float | None
    unit: str
    why: str = ""


@dataclass(frozen=True, slots=True)
class JointFit:
    """One joint.

    Attributes:
        joint: Name.
        kind: Hinge or slide.
        parameters: In the order of `FIELDS`.
        combinations: Where single figures cannot be told.
        correlation: Pairs of fields and their correlation, where it is above a half.
        position_rmse: Of the fit [rad or m]; this and the next three are None where no motion was fitted.
        held_out_rmse: On pieces that the fit did not see [rad or m]; None where there are too few.
        misfit: Position residual over the noise of the readings; about 1 where nothing is left to explain.
        condition: Condition number of the scaled normal matrix.
        diagnostics: Of the experiment or the closed loop.
    """

    joint: str
    kind: JointKind
    parameters: tuple[Parameter, ...]
    combinations: tuple[Combination, ...]
    correlation: tuple[tuple[str, str, float], ...]
    position_rmse: float | None
    held_out_rmse: float | None
    misfit: float | None
    condition: float | None
    diagnostics: tuple[Indicator, ...] = ()

    def parameter(self, field: str) -> Parameter:
        """That of a field."""
        return next(item for item in self.parameters if item.field == field)


@dataclass(frozen=True, slots=True)
class Identification:
    """A whole fit.

    Attributes:
        robot: Name of the robot.
        method: One of `METHODS`.
        joints: In the robot's order.
        findings: What is wrong with logs or fit, and what was left out.
        seconds: Time it took.
    """

    robot: str
    method: str
    joints: tuple[JointFit, ...]
    findings: tuple[Diagnostic, ...]
    seconds: float
