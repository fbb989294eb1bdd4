"""Gears in the spec language: stages between a motor and its joint, and linkages that join several joints."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal

from pydantic import Field
from pydantic_core import PydanticCustomError

from actspec.spec.values import (
    Efficiency,
    Factor,
    FieldParser,
    Inertia,
    Name,
    Number,
    SpecValue,
    Strict,
    fault,
    parse_below,
    parse_value,
    short,
    value_schema,
)
from actspec.units import Kind

MOST_STAGES = 16
MOST_JOINTS = 6
"""Of one linkage. Chosen: a hexapod, the largest parallel mechanism there is a name for, has six."""
MOST_POSES = 10_000

Lead = Annotated[SpecValue, Number(Kind.LEAD, above=0.0, unknown=False)]
Length = Annotated[SpecValue, Number(Kind.LENGTH, above=0.0, unknown=False)]


class Planetary(Strict):
    """Planetary stage with a fixed ring: in at the sun, out at the carrier, ratio 1 + ring/sun."""

    sun: Factor
    """Teeth of the sun [-]."""
    ring: Factor
    """Teeth of the ring [-]."""


class Teeth(Strict):
    """Pair of spur gears, or of pulleys with a belt or chain, ratio driven/driving."""

    driving: Factor
    """Teeth of the wheel on the motor's side [-]."""
    driven: Factor
    """Teeth of the wheel on the joint's side [-]."""


class Stage(Strict):
    """One stage on the way from motor to joint: exactly one of ratio, planetary, teeth, lead, radius, lever_arm."""

    ratio: Factor | None = None
    """Turns at its input in one turn at its output [-]."""
    planetary: Planetary | None = None
    """Planetary gears, {sun, ring}."""
    teeth: Teeth | None = None
    """Spur gears, belt or chain, {driving, driven}."""
    lead: Lead | None = None
    """Screw, turns to travel: travel of the nut per angle of the screw, as in `5 mm/rev` [m/rad]."""
    radius: Length | None = None
    """Pinion and rack, or pulley and belt or rope: pitch radius [m]; turns to travel, or travel to turns."""
    lever_arm: Length | None = None
    """Lever, travel to turns: distance from the joint's axis to the line of force, at one pose [m]."""
    efficiency: Efficiency | None = None
    """0 to 1 [-]; scales the torque that passes. Default 1."""
    inertia: Inertia | None = None
    """Of what moves with the stage's output, at that output [kg*m^2 or kg]."""
    note: str | None = None
    """Remark."""


Stages = Annotated[tuple[Stage, ...], Field(min_length=1, max_length=MOST_STAGES)]

KINDS_OF_STAGE = ("ratio", "planetary", "teeth", "lead", "radius", "lever_arm")
"""Keys of a stage of which it has exactly one."""


class MatrixField(FieldParser):
    """Annotation of a Jacobian: rows of numbers, each a ratio, or a length per angle in a linear motor's row."""

    def __call__(self, given: Any) -> tuple[tuple[SpecValue, ...], ...]:
        """Parse what the YAML holds; `linear` tells the entries in m/rad."""
        if not isinstance(given, list) or not all(isinstance(row, list) for row in given):
            help = "a row a motor, a column a joint: `[[1, 0.6], [1, -0.6]]`"
            raise fault(f"must be a list of rows, got {short(given)}", help)
        if not 0 < len(given) <= MOST_JOINTS or any(len(row) > MOST_JOINTS for row in given):
            raise fault(f"must have 1 to {MOST_JOINTS} rows and columns, got {len(given)} rows")
        return tuple(tuple(_entry(item, (i, j)) for j, item in enumerate(row)) for i, row in enumerate(given))

    def json_schema(self) -> dict[str, Any]:
        entry = {"anyOf": [value_schema(Number(kind, unknown=False)) for kind in (Kind.RATIO, Kind.LEAD)]}
        row = {"type": "array", "minItems": 1, "maxItems": MOST_JOINTS, "items": entry}
        return {"type": "array", "minItems": 1, "maxItems": MOST_JOINTS, "items": row}


def _entry(given: Any, at: tuple[int, int]) -> SpecValue:
    """One number of a Jacobian."""
    for kind in (Kind.RATIO, Kind.LEAD):
        try:
            value = parse_value(given, kind, words=())
        except PydanticCustomError:
            continue
        return value if kind is Kind.RATIO else replace(value, linear=True)
    raise fault(
        f"must be a ratio, or a length per angle where the motor is linear, got {short(given)}",
        "write for instance `0.6` (motor turns in one turn of the joint), or `40 mm/rad`",
        at,
    )


@dataclass(frozen=True, slots=True)
class PoseField(FieldParser):
    """Annotation of a pose: one position a joint, or a word in place of it."""

    words: tuple[str, ...] = ()

    def __call__(self, given: Any) -> tuple[SpecValue, ...] | str:
        """Parse what the YAML holds."""
        if isinstance(given, str) and given in self.words:
            return given
        if not isinstance(given, list) or not 0 < len(given) <= MOST_JOINTS:
            words = "".join(f", or `{word}`" for word in self.words)
            help = "write one a joint of the linkage, `[0.1 rad, 0 rad]`"
            raise fault(f"must be a list of 1 to {MOST_JOINTS} positions{words}, got {short(given)}", help)
        return tuple(parse_below(index, item, _POSITION) for index, item in enumerate(given))

    def json_schema(self) -> dict[str, Any]:
        position = value_schema(_POSITION)
        pose = {"type": "array", "minItems": 1, "maxItems": MOST_JOINTS, "items": position}
        return {"anyOf": [{"enum": list(self.words)}, pose]} if self.words else pose


_POSITION = Number(Kind.POSITION, unknown=False)

Jacobian = Annotated[tuple[tuple[SpecValue, ...], ...], MatrixField()]


class LinkagePose(Strict):
    """The Jacobian of a linkage at one pose."""

    at: Annotated[tuple[SpecValue, ...], PoseField()]
    """Positions of the linkage's joints, in its order [rad or m]."""
    jacobian: Jacobian
    """Motor speed per joint speed there, a row a motor, a column a joint."""


class Linkage(Strict):
    """Motors that move joints together: exactly one of jacobian, table and factor."""

    joints: Annotated[tuple[Name, ...], Field(min_length=1, max_length=MOST_JOINTS)]
    """Names of the joints."""
    motors: Annotated[tuple[Name, ...], Field(min_length=1, max_length=MOST_JOINTS)]
    """Keys of `motors`, as many as joints."""
    jacobian: Jacobian | None = None
    """Speed of the motors' outputs per joint speed at one pose, a row a motor, a column a joint
    [-, or m/rad in the row of a linear motor]."""
    at: Annotated[tuple[SpecValue, ...] | Literal["any"], PoseField(("any",))] | None = None
    """Pose that `jacobian` holds at: positions of the joints [rad or m]; or `any`, as in a differential."""
    table: Annotated[tuple[LinkagePose, ...], Field(min_length=1, max_length=MOST_POSES)] | None = None
    """The Jacobian at several poses; the one nearest to the default pose is used."""
    factor: Factor | None = None
    """Plain factor, where nobody has computed the linkage: every joint gets this times all motors [-]."""
    limits: Literal["alone", "together"] = "alone"
    """Limits of each joint while the others need nothing (`alone`, default), or a share of them that all
    joints can use at once (`together`)."""
    source: str | None = None
    """Key of `sources` that the Jacobian or factor is from."""
    note: str | None = None
    """Remark."""
