"""Derived gains: `{derive: natural_frequency, frequency: 10 Hz, inertia: reflected}` and its kin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, core_schema

from actspec.diagnostics import nearest
from actspec.spec.values import Number, SpecValue, check_keys, fault, parse_below, short, value_schema
from actspec.units import Kind

REFLECTED = "reflected"
JOINT = "joint"

METHODS: dict[str, tuple[str, ...]] = {
    "torque_at_error": ("fraction", "error"),
    "natural_frequency": ("frequency", "inertia"),
    "damping_ratio": ("ratio", "inertia"),
}
"""Keys of each method beside `derive`; all are required."""

_KINDS = {"fraction": Kind.RATIO, "error": Kind.POSITION, "frequency": Kind.FREQUENCY, "ratio": Kind.RATIO}


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
class GainField:
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
            raise fault(
                f"no derivation is named {short(method)}",
                f"did you mean '{guess}'?" if guess else f"known here: {', '.join(self.methods)}",
                ("derive",),
            )
        keys = METHODS[method]
        check_keys(given, ("derive", *keys), f"the derivation '{method}'")
        missing = [key for key in keys if key not in given]
        if missing:
            raise fault(
                f"the derivation '{method}' needs {', '.join(missing)}", f"its keys: {', '.join(keys)}"
            )
        numbers = {}
        for key in keys:
            if key != "inertia":
                numbers[key] = parse_below(key, given[key], Number(_KINDS[key], above=0.0))
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
                inertia = parse_below("inertia", word, Number(Kind.INERTIA, above=0.0))
        return DerivedGain(method, numbers, inertia)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        base = value_schema(self.number.kind, self.number.words)
        derivations = []
        for method in self.methods:
            properties: dict[str, Any] = {"derive": {"const": method}}
            for key in METHODS[method]:
                if key == "inertia":
                    properties[key] = {
                        "anyOf": [{"enum": [REFLECTED, JOINT]}, value_schema(Kind.INERTIA, ())]
                    }
                else:
                    properties[key] = value_schema(_KINDS[key], ())
            derivations.append(
                {
                    "type": "object",
                    "required": list(properties),
                    "additionalProperties": False,
                    "properties": properties,
                }
            )
        return {"anyOf": [*base["anyOf"], *derivations]}
