"""Fields that hold a number or something else: a derived gain, an effort limit, a delay, a range of the command."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from pydantic_core import PydanticCustomError

from actspec.diagnostics import did_you_mean
from actspec.spec.values import (
    EXAMPLES,
    FieldParser,
    Number,
    Pair,
    SpecValue,
    check_keys,
    check_order,
    fault,
    parse_below,
    short,
    value_schema,
)
from actspec.units import Kind, format_quantity

EFFORT_WORDS = ("continuous", "peak")
_EFFORTS = {"nominal": "continuous", "rated": "continuous", "max": "peak", "maximum": "peak", "stall": "peak"}
"""Words of datasheets to those of the language."""
SAMPLINGS = ("episode", "step")
STEP = (20e-6, 40e-3)
"""Simulation step [s]. Published: 0.1 to 20 ms of nearly all MJCF and Isaac Lab tasks, 30 ms (dm_control's lqr), 33.3
ms (rovers in Isaac Lab), 40 ms (a cart and a pole). 50 ms is that of a few pendulums, and several times a slip: Isaac
Lab tasks have `dt = 0.05  # 5 ms: 200 Hz`."""
CONTROL_PERIOD = (20e-6, 0.5)
"""[s]. Published: 5 to 50 ms of joints, 0.2 s of rovers and of navigation above a walking policy, to 0.5 s of that."""
USUAL_DELAY = (1e-3, 0.25)
"""Of commands to a joint [s]; published: 2 to 20 ms. Of a delay and its range it tells which may be wrong."""


class EffortField(FieldParser):
    """Annotation of an effort limit: a torque, `unknown`, `continuous` or `peak`."""

    number = Number(Kind.TORQUE, above=0.0)

    def __call__(self, given: Any) -> SpecValue | str:
        """Parse what the YAML holds."""
        if isinstance(given, str):
            if given in EFFORT_WORDS:
                return given
            # A motor's key is what is meant: peak_torque.
            word = given.lower().removesuffix("_torque")
            if word.isalpha() and given != "unknown":
                raise fault(
                    f"must be a torque, `continuous`, `peak` or `unknown`, got {short(given)}",
                    did_you_mean(
                        _EFFORTS.get(word, word),
                        (*EFFORT_WORDS, "unknown"),
                        "write for instance `33.5 N*m`",
                    ),
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
        kind: What its unit says that the command is.
    """

    low: SpecValue
    high: SpecValue
    kind: Kind


class CommandRangeField(FieldParser):
    """Annotation of `command_range`: `none`, `joint`, or [low, high] in the command's own unit."""

    def __call__(self, given: Any) -> CommandRange | str:
        """Parse what the YAML holds: the first end with a unit decides what the command is."""
        for kind in RANGE_KINDS:
            try:
                pair = Pair(kind, words=RANGE_WORDS, ordered=False)(given)
            except PydanticCustomError:
                continue
            break
        else:
            # As a position it is most often meant, and the message is about that.
            kind, pair = Kind.POSITION, Pair(Kind.POSITION, words=RANGE_WORDS)(given)
        if isinstance(pair, str):
            return pair
        check_order(*pair, apart=True)
        return CommandRange(*pair, kind)

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
            raise fault(
                f"must be `episode` or `step`, got {short(sampling)}",
                did_you_mean(
                    str(sampling), SAMPLINGS, "`episode` draws at reset and holds, `step` draws anew"
                ),
                ("sampling",),
            )
        pair = None if limits is None or isinstance(limits, str) else limits
        if pair is not None and nominal.value is not None:
            low, high = pair
            if not (low.value or 0.0) <= nominal.value <= (high.value or 0.0):
                raise _outside(nominal, low, high)
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


REFLECTED = "reflected"
JOINT = "joint"

METHODS: dict[str, tuple[str, ...]] = {
    "torque_at_error": ("fraction", "error"),
    "natural_frequency": ("frequency", "inertia"),
    "damping_ratio": ("ratio", "inertia"),
}
"""Keys of each method beside `derive`; all are required."""

_KINDS = {
    "fraction": Kind.RATIO,
    "error": Kind.POSITION,
    "frequency": Kind.FREQUENCY,
    "ratio": Kind.RATIO,
    "inertia": Kind.INERTIA,
}
_LAWS = {
    "torque_at_error": "kp = fraction effort_limit / error [N*m/rad or N/m].",
    "natural_frequency": "kp = I (2 pi frequency)^2 [N*m/rad or N/m].",
    "damping_ratio": "kd = 2 ratio sqrt(kp I) [N*m*s/rad or N*s/m].",
}
_MEANINGS = {
    "fraction": "Part of effort_limit that the drive applies at `error` [-].",
    "error": "Position error [rad or m].",
    "frequency": "Natural frequency, in cycles [Hz].",
    "ratio": "Damping ratio [-].",
    "inertia": "`reflected` (the rotor's, seen at the joint), `joint` (M_jj, armature included) or a number "
    "[kg*m^2 or kg].",
}


@dataclass(frozen=True, slots=True)
class DerivedGain:
    """A gain that is computed from other numbers.

    Attributes:
        method: `torque_at_error` (kp = fraction * effort_limit / error),
            `natural_frequency` (kp = I (2 pi f)^2) or `damping_ratio` (kd = 2 ratio sqrt(kp I)).
        numbers: The method's numbers by key.
        inertia: `reflected` (rotor inertia seen at the joint), `joint` (inertia held, M_jj)
            or a number [kg*m^2 or kg]; None where the method needs none.
    """

    method: str
    numbers: dict[str, SpecValue]
    inertia: SpecValue | Literal["reflected", "joint"] | None


Gain = SpecValue | DerivedGain
"""What a gain's field holds."""


@dataclass(frozen=True, slots=True)
class GainField(FieldParser):
    """Annotation of a gain's field: a number, `identified`, `unknown` or a derivation."""

    number: Number
    methods: tuple[str, ...]

    def __call__(self, given: Any) -> Gain:
        """Parse what the YAML holds."""
        if not isinstance(given, dict) or "derive" not in given:
            return self.number(given)
        method = given["derive"]
        if method not in self.methods:
            known = isinstance(method, str) and method in METHODS
            raise fault(
                f"'{method}' does not derive a {self.number.kind.noun}"
                if known
                else f"no derivation is named {short(method)}",
                did_you_mean(str(method), self.methods, f"known here: {', '.join(self.methods)}"),
                ("derive",),
            )
        keys = METHODS[method]
        check_keys(given, ("derive", *keys), f"the derivation '{method}'")
        missing = [key for key in keys if key not in given]
        if missing:
            raise fault(
                f"the derivation '{method}' needs {' and '.join(missing)}",
                f"write for instance `{_example(method)}`",
            )
        numbers = {}
        for key in keys:
            if key != "inertia":
                numbers[key] = parse_below(key, given[key], _number(key))
        inertia: SpecValue | Literal["reflected", "joint"] | None = None
        if "inertia" in keys:
            word = given["inertia"]
            if word in (REFLECTED, JOINT):
                inertia = word
            elif isinstance(word, str) and not any(c.isdigit() for c in word):
                raise fault(
                    f"must be `reflected`, `joint` or an inertia, got {short(word)}",
                    "`reflected` is the rotor's inertia seen at the joint, `joint` the robot's M_jj",
                    ("inertia",),
                )
            else:
                inertia = parse_below("inertia", word, _number("inertia"))
        return DerivedGain(method, numbers, inertia)

    def json_schema(self) -> dict[str, Any]:
        derivations = []
        for method in self.methods:
            properties: dict[str, Any] = {"derive": {"const": method, "description": _LAWS[method]}}
            for key in METHODS[method]:
                number = value_schema(_number(key))
                if key == "inertia":
                    number = {"anyOf": [{"enum": [REFLECTED, JOINT]}, number]}
                properties[key] = {**number, "description": _MEANINGS[key]}
            derivations.append(
                {
                    "type": "object",
                    "required": list(properties),
                    "additionalProperties": False,
                    "properties": properties,
                }
            )
        return {"anyOf": [value_schema(self.number), *derivations]}


def _number(key: str) -> Number:
    return Number(_KINDS[key], above=0.0, unknown=False)


def _example(method: str) -> str:
    written = [
        f"{key}: {REFLECTED if key == 'inertia' else EXAMPLES[_KINDS[key]]}" for key in METHODS[method]
    ]
    return f"{{derive: {', '.join([method, *written])}}}"


def _outside(nominal: SpecValue, low: SpecValue, high: SpecValue) -> PydanticCustomError:
    """What is wrong where a nominal delay is outside of its range: the point of the one, or that of the other."""
    delay, ends = nominal.value or 0.0, (low.value or 0.0, high.value or 0.0)
    message = f"the nominal delay {nominal.written} is outside its range [{low.written}, {high.written}]"
    help = "widen the range or move the nominal value"
    factor = next((by for by in (0.1, 10.0, 1e-3, 0.01, 100.0) if ends[0] <= delay * by <= ends[1]), None)
    if factor is None or not delay:
        return fault(message, help, ("range",))
    readings = {
        "nominal": (delay * factor, _in_ms(delay * factor)),
        "range": (delay, f"[{', '.join(_in_ms(end / factor) for end in ends)}]"),
    }
    usual = {key: text for key, (size, text) in readings.items() if USUAL_DELAY[0] <= size <= USUAL_DELAY[1]}
    usual = usual or {"nominal": readings["nominal"][1]}
    words = " ".join(f"{key}: did you mean {text}? Or" for key, text in usual.items())
    return fault(message, f"{words} {help}", (next(iter(usual)),))


def _in_ms(delay: float) -> str:
    return format_quantity(delay * 1e3, "ms", 4)
