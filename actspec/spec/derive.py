"""Derived gains: `{derive: natural_frequency, frequency: 10 Hz, inertia: reflected}` and its kin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from actspec.diagnostics import nearest
from actspec.spec.values import (
    EXAMPLES,
    FieldParser,
    Number,
    SpecValue,
    check_keys,
    fault,
    parse_below,
    short,
    value_schema,
)
from actspec.units import Kind

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
            guess = nearest(str(method), self.methods)
            known = isinstance(method, str) and method in METHODS
            raise fault(
                f"'{method}' does not derive a {self.number.kind.noun}"
                if known
                else f"no derivation is named {short(method)}",
                f"did you mean '{guess}'?" if guess else f"known here: {', '.join(self.methods)}",
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
