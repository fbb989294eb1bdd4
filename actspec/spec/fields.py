"""Fields that hold a number or something else: an effort limit, a delay."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pydantic_core import PydanticCustomError

from actspec.diagnostics import nearest
from actspec.spec.values import (
    FieldParser,
    Number,
    Pair,
    SpecValue,
    check_keys,
    fault,
    parse_below,
    short,
    value_schema,
)
from actspec.units import Kind

EFFORT_WORDS = ("continuous", "peak")
SAMPLINGS = ("episode", "step")


class EffortField(FieldParser):
    """Annotation of an effort limit: a torque, `unknown`, `continuous` or `peak`."""

    number = Number(Kind.TORQUE, above=0.0)

    def __call__(self, given: Any) -> SpecValue | str:
        """Parse what the YAML holds."""
        if isinstance(given, str):
            if given in EFFORT_WORDS:
                return given
            if given.isalpha() and given != "unknown":
                guess = nearest(given, (*EFFORT_WORDS, "unknown"))
                raise fault(
                    f"must be a torque, `continuous`, `peak` or `unknown`, got {short(given)}",
                    f"did you mean '{guess}'?" if guess else "write for instance `33.5 N*m`",
                )
        return self.number(given)

    def json_schema(self) -> dict[str, Any]:
        return {"anyOf": [{"enum": list(EFFORT_WORDS)}, value_schema(self.number)]}


@dataclass(frozen=True, slots=True)
class SpecDelay:
    """A delay as the spec has it.

    Attributes:
        nominal: [s].
        range: Low and high [s]; None without a range.
        sampling: `episode` (drawn at reset and held) or `step` (drawn every physics step).
    """

    nominal: SpecValue
    range: tuple[SpecValue, SpecValue] | None
    sampling: str


RANGE_WORDS = ("none", "joint")
RANGE_KINDS = (Kind.POSITION, Kind.SPEED, Kind.TORQUE)


@dataclass(frozen=True, slots=True)
class CommandRange:
    """A clamp of the command.

    Attributes:
        low: Least command.
        high: Largest command.
        kind: What its unit says that the command is; None where both ends are 0.
    """

    low: SpecValue
    high: SpecValue
    kind: Kind | None


class CommandRangeField(FieldParser):
    """Annotation of `command_range`: `none`, `joint`, or [low, high] in the command's own unit."""

    def __call__(self, given: Any) -> CommandRange | str:
        """Parse what the YAML holds: the first end with a unit decides what the command is."""
        fits = []
        for kind in RANGE_KINDS:
            try:
                pair = Pair(kind, words=RANGE_WORDS)(given)
            except PydanticCustomError:
                continue
            if isinstance(pair, str):
                return pair
            fits.append((kind, pair))
        if not fits:
            # As a position it is most often meant, and the message is about that.
            Pair(Kind.POSITION, words=RANGE_WORDS)(given)
        kind, (low, high) = fits[0]
        return CommandRange(low, high, kind if len(fits) == 1 else None)

    def json_schema(self) -> dict[str, Any]:
        numbers = [value_schema(Number(kind, unknown=False)) for kind in RANGE_KINDS]
        pair = {"type": "array", "minItems": 2, "maxItems": 2, "items": {"anyOf": numbers}}
        return {"anyOf": [{"enum": list(RANGE_WORDS)}, pair]}


class DelayField(FieldParser):
    """Annotation of a delay: a time, `identified`, or {nominal, range, sampling}."""

    number = Number(Kind.TIME, at_least=0.0, identified=True)
    pair = Pair(Kind.TIME, at_least=0.0)

    def __call__(self, given: Any) -> SpecDelay:
        """Parse what the YAML holds."""
        if not isinstance(given, dict) or "value" in given:
            return SpecDelay(self.number(given), None, "episode")
        check_keys(given, ("nominal", "range", "sampling"), "a delay")
        if "nominal" not in given:
            raise fault("a delay needs its key 'nominal'", "write `{nominal: 5 ms, range: [0 ms, 10 ms]}`")
        nominal = parse_below("nominal", given["nominal"], self.number)
        limits = parse_below("range", given["range"], self.pair) if "range" in given else None
        sampling = given.get("sampling", "episode")
        if sampling not in SAMPLINGS:
            guess = nearest(str(sampling), SAMPLINGS)
            raise fault(
                f"must be `episode` or `step`, got {short(sampling)}",
                f"did you mean '{guess}'?"
                if guess
                else "`episode` draws at reset and holds, `step` draws anew",
                ("sampling",),
            )
        pair = None if limits is None or isinstance(limits, str) else limits
        if pair is not None and nominal.value is not None:
            low, high = pair
            if not (low.value or 0.0) <= nominal.value <= (high.value or 0.0):
                raise fault(
                    f"the nominal delay {nominal.written} is outside its range [{low.written}, {high.written}]",
                    "widen the range or move the nominal value",
                    ("range",),
                )
        return SpecDelay(nominal, pair, sampling)

    def json_schema(self) -> dict[str, Any]:
        number = value_schema(self.number)
        time = value_schema(Number(Kind.TIME, at_least=0.0, unknown=False))
        full = {
            "type": "object",
            "required": ["nominal"],
            "additionalProperties": False,
            "properties": {
                "nominal": {**number, "description": "Nominal delay [s]."},
                "range": {
                    "type": "array",
                    "minItems": 2,
                    "maxItems": 2,
                    "items": time,
                    "description": "Least and largest delay, [low, high] [s].",
                },
                "sampling": {
                    "enum": list(SAMPLINGS),
                    "description": "`episode` (default): drawn at reset and held; `step`: drawn every step.",
                },
            },
        }
        return {"anyOf": [number, full]}
