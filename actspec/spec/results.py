"""Identification results, which a spec names under `identified`.

YAML like the spec, read as strictly. One entry a joint; each number carries unit and std.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from actspec.diagnostics import Collector, SpecError, did_you_mean, shortened
from actspec.spec.document import Document
from actspec.spec.validate import checked
from actspec.spec.values import Name, Number, SpecValue, Strict
from actspec.units import Kind

FORMAT = "actspec-results/1"


class FrictionResult(Strict):
    """Fitted passive friction at the joint."""

    coulomb: Annotated[SpecValue, Number(Kind.TORQUE, at_least=0.0)] | None = None
    """Kinetic dry friction [N*m or N]."""
    viscous: Annotated[SpecValue, Number(Kind.VELOCITY_GAIN, at_least=0.0)] | None = None
    """Passive viscous friction [N*m*s/rad or N*s/m]."""
    static: Annotated[SpecValue, Number(Kind.TORQUE, at_least=0.0)] | None = None
    """Break-away friction [N*m or N]."""
    stribeck_velocity: Annotated[SpecValue, Number(Kind.SPEED, above=0.0)] | None = None
    """Speed over which static falls to coulomb [rad/s or m/s]."""


class CombinationResult(Strict):
    """What the data tell of several fields together, in SI."""

    value: float
    """The number."""
    std: Annotated[float, Field(ge=0.0)]
    """Its standard deviation."""
    unit: str
    """SI unit."""


class DiagnosticResult(Strict):
    """What the data tell of the experiment or of the closed loop, in SI; no figure of the spec."""

    value: float
    """The number."""
    std: Annotated[float, Field(ge=0.0)] | None = None
    """Its standard deviation; left out: unknown."""
    unit: str
    """SI unit; 1 for a share or a factor."""


class HeldGains(Strict):
    """Gains that the fit took as given."""

    kp: Annotated[SpecValue, Number(Kind.STIFFNESS, at_least=0.0)]
    """Drive stiffness [N*m/rad or N/m]."""
    kd: Annotated[SpecValue, Number(Kind.VELOCITY_GAIN, at_least=0.0)]
    """Drive velocity gain [N*m*s/rad or N*s/m]."""


class JointResult(Strict):
    """What was fitted of one joint."""

    kp: Annotated[SpecValue, Number(Kind.STIFFNESS, at_least=0.0)] | None = None
    """Effective drive stiffness [N*m/rad or N/m]."""
    kd: Annotated[SpecValue, Number(Kind.VELOCITY_GAIN, at_least=0.0)] | None = None
    """Effective drive velocity gain [N*m*s/rad or N*s/m]."""
    armature: Annotated[SpecValue, Number(Kind.INERTIA, at_least=0.0)] | None = None
    """Inertia added to the joint [kg*m^2 or kg]."""
    friction: FrictionResult = FrictionResult()
    """Passive friction."""
    delay: Annotated[SpecValue, Number(Kind.TIME, at_least=0.0)] | None = None
    """Delay of the command [s]."""
    bandwidth: Annotated[SpecValue, Number(Kind.FREQUENCY, above=0.0)] | None = None
    """-3 dB frequency of the command's low-pass [Hz]."""
    closed_loop_bandwidth: Annotated[SpecValue, Number(Kind.FREQUENCY, above=0.0)] | None = None
    """-3 dB frequency of q over q*, the drive included [Hz]. A diagnostic: as a command filter it would
    count the PD twice."""
    encoder_bias: Annotated[SpecValue, Number(Kind.POSITION)] | None = None
    """q_measured = q + bias [rad or m]."""
    intervals: dict[str, tuple[float, float]] = Field(default_factory=dict)
    """Field that has a value to both ends of its 95 % interval, in SI; they need not be equally far from the value."""
    bounds_hit: tuple[str, ...] = ()
    """Fields that ended at a bound of the fit; they have no value."""
    unidentifiable: tuple[str, ...] = ()
    """Fields that the data cannot tell; they have no value."""
    left_out: dict[str, str] = Field(default_factory=dict)
    """What another tool found of the joint and these results have not, to the reason."""
    reasons: dict[str, str] = Field(default_factory=dict)
    """Why a field of `bounds_hit` or `unidentifiable` has no value."""
    gains: HeldGains | None = None
    """Gains that the other figures rest on, where they were not fitted."""
    combinations: dict[str, CombinationResult] = Field(default_factory=dict)
    """Sums and ratios of fields that the data tell where single fields do not, by their formula; never compiled."""
    diagnostics: dict[str, DiagnosticResult] = Field(default_factory=dict)
    """Figures of the experiment or the closed loop, by name, such as `torque_scale`; never compiled."""
    correlation: tuple[tuple[str, str, Annotated[float, Field(ge=-1.0, le=1.0)]], ...] = ()
    """Pairs of fields whose errors go together, and their correlation."""


FIELDS = (
    *("kp", "kd", "armature", "delay", "bandwidth", "closed_loop_bandwidth", "encoder_bias"),
    *(f"friction.{part}" for part in FrictionResult.model_fields),
)
"""Figures of a joint, by the names of `randomize`."""


class FitFile(Strict):
    """A file that the fit used."""

    path: str
    """Path as given to the fit."""
    sha256: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
    """Hash of its bytes; of a spec, with those that it includes."""


class Results(Strict):
    """Results of an identification."""

    format: Literal["actspec-results/1"]
    """Format of this file."""
    robot: Name
    """Name of the robot."""
    method: Name
    """Experiment and fit, e.g. `rollout`."""
    commit: str | None = None
    """Version of the tool that found them, where it is not actspec."""
    date: str | None = None
    """Day of the experiment, YYYY-MM-DD."""
    temperature: Literal["cold", "warm"] | None = None
    """Whether the motors were cold or warm."""
    spec: FitFile | None = None
    """Spec that the fit began with."""
    data: tuple[FitFile, ...] = ()
    """Logs."""
    held_out_rmse: Annotated[SpecValue, Number(Kind.POSITION, at_least=0.0)] | None = None
    """Error on data that the fit did not see [rad or m]."""
    condition: float | None = None
    """Condition number of the fit's normal matrix."""
    note: str | None = None
    """Remark."""
    joints: dict[str, JointResult]
    """Joint to what was fitted."""


def value_of(joint: JointResult, field: str) -> SpecValue | None:
    """The figure of a field, as the file states it; None: it does not.

    Args:
        joint: Of the file.
        field: One of `FIELDS`.
    """
    section, _, key = field.rpartition(".")
    found: SpecValue | None = getattr(getattr(joint, section) if section else joint, key, None)
    return found


@dataclass(frozen=True, slots=True)
class ResultsFile:
    """Results with their places.

    Attributes:
        model: What they say.
        document: Where they say it.
    """

    model: Results
    document: Document


@dataclass(frozen=True, slots=True)
class _Place:
    """A joint of a file, for what is wrong with it."""

    document: Document
    joint: str
    out: Collector

    def error(
        self, code: str, message: str, at: tuple[str | int, ...], help: str | None, where: str = ""
    ) -> None:
        span = self.document.spans.value(("joints", self.joint, *at))
        self.out.error(code, message, where=f"joints.{self.joint}{where}", span=span, help=help)

    def knows(self, field: str, key: str, at: str | int) -> bool:
        """Whether results may have the field."""
        if field in FIELDS:
            return True
        message = f"'{shortened(field)}' is no field of a joint's results"
        help = did_you_mean(field, FIELDS, f"fields: {', '.join(FIELDS)}")
        self.error("SPEC174", message, (key, at), help, where=f".{key}")
        return False


def validate_results(document: Document) -> Results:
    """Check a results file.

    Raises:
        SpecError: with every error of the file.
    """
    collector = Collector()
    results = checked(Results, document, collector)
    for name, joint in results.joints.items() if results is not None else ():
        place = _Place(document, name, collector)
        for key in ("bounds_hit", "unidentifiable"):
            for index, field in enumerate(getattr(joint, key)):
                if place.knows(field, key, index) and value_of(joint, field) is not None:
                    message = f"{field} has a value, and stands under `{key}`"
                    help = "remove the value: what the data do not tell has none"
                    place.error("SPEC173", message, (key, index), help)
        for field, (low, high) in joint.intervals.items():
            if not place.knows(field, "intervals", field):
                continue
            stated = value_of(joint, field)
            if stated is None or stated.value is None:
                message = f"{field} has an interval and no value"
                place.error(
                    "SPEC176", message, ("intervals", field), "remove the interval, or state the value"
                )
            elif not low <= stated.value <= high:
                message = f"the interval of {field} is {low:g} to {high:g}, its value {stated.value:g}"
                help = f"low and high end in {stated.unit or 'SI'}, with the value between them"
                place.error("SPEC176", message, ("intervals", field), help)
    collector.raise_if_failed(SpecError)
    assert results is not None
    return results
