"""Numbers as a spec writes them: `33.5 N*m`, `0.2`, `unknown`, `{value, unit, source, std, note}`.

Each field of the spec names its quantity kind; a field's type is an annotated `SpecValue` that
parses, checks and documents itself in the JSON Schema (`Number`). Also the base of all models.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from actspec.diagnostics import did_you_mean, nearest
from actspec.spec.around import UNKNOWN, explained, fits
from actspec.units import Kind, UnitError, format_quantity, parse_quantity, parse_with_unit

T = TypeVar("T")

IDENTIFIED = "identified"
EXAMPLES: Mapping[Kind, str] = {
    Kind.TORQUE: "33.5 N*m",
    Kind.STIFFNESS: "25 N*m/rad",
    Kind.VELOCITY_GAIN: "0.5 N*m*s/rad",
    Kind.INERTIA: "0.01 kg*m^2",
    Kind.SPEED: "21 rad/s",
    Kind.POSITION: "0.9 rad",
    Kind.ANGLE: "0.9 rad",
    Kind.LENGTH: "20 mm",
    Kind.LEAD: "5 mm/rev",
    Kind.TIME: "5 ms",
    Kind.FREQUENCY: "30 Hz",
    Kind.RATIO: "0.25",
    Kind.VOLTAGE: "24 V",
    Kind.CURRENT: "20 A",
    Kind.TORQUE_CONSTANT: "0.1 N*m/A",
    Kind.RESISTANCE: "0.2 Ohm",
}
"""How one writes each kind, for messages and editors."""

VALUE_KEYS = ("value", "unit", "source", "std", "note", "sure")


@dataclass(frozen=True, slots=True)
class SpecValue:
    """One number of a spec, in SI units.

    Attributes:
        value: The number; None when the author wrote `unknown`.
        unit: SI unit, e.g. `N*m/rad`.
        linear: True for a slide joint's unit (N, N/m, ...), False for a hinge's, None when the
            unit does not tell (a bare number, a ratio, a time).
        written: What the author wrote, for messages.
        source: Key of `sources`.
        std: Standard deviation in `unit`.
        note: The author's remark.
        identified: The author wrote `identified`: take the fitted value.
    """

    value: float | None
    unit: str
    linear: bool | None
    written: str
    source: str | None = None
    std: float | None = None
    note: str | None = None
    identified: bool = False


def fault(message: str, help: str | None = None, at: tuple[str | int, ...] = ()) -> PydanticCustomError:
    """An error for a pydantic validator that carries its help and the place below the field."""
    return PydanticCustomError("actspec", "{message}", {"message": message, "help": help, "at": at})


def check_keys(given: Mapping[str, Any], known: tuple[str, ...], what: str) -> None:
    """Raise for a key that `what` does not have, naming the nearest one that it has."""
    for key in given:
        if key not in known:
            raise fault(
                f"unknown key '{key}' in {what}",
                did_you_mean(key, known, f"known keys: {', '.join(known)}"),
                (key,),
            )


def parse_value(
    given: Any,
    kind: Kind,
    *,
    at_least: float | None = None,
    above: float | None = None,
    at_most: float | None = None,
    words: tuple[str, ...] = (UNKNOWN,),
) -> SpecValue:
    """Parse one number of a spec.

    Args:
        given: What the YAML holds.
        kind: Quantity kind of the field.
        at_least: Smallest allowed number [SI].
        above: The number must be greater than this [SI].
        at_most: Largest allowed number [SI].
        words: Words that the field takes in place of a number (`unknown`, `identified`).

    Raises:
        PydanticCustomError: with message, help and the place below the field.
    """
    source = note = std_given = None
    number: Any = given
    unit_text: str | None = None
    at: tuple[str | int, ...] = ()
    if isinstance(given, dict):
        if "value" not in given:
            raise _without_value(given, kind)
        check_keys(given, VALUE_KEYS, "a value")
        number, unit_text, at = given["value"], given.get("unit"), ("value",)
        source, note, std_given = given.get("source"), given.get("note"), given.get("std")
        for key, text in (("unit", unit_text), ("source", source), ("note", note)):
            if text is not None and not isinstance(text, str):
                raise fault(f"must be text, got {short(text)}", _in_quotes(text), (key,))
        if not isinstance(given.get("sure", True), bool):
            raise fault(
                f"must be true or false, got {short(given['sure'])}",
                "write `sure: true`, or leave it out",
                ("sure",),
            )
    if isinstance(number, str) and number.strip() in (UNKNOWN, IDENTIFIED):
        word = number.strip()
        if word not in words:
            raise fault(f"{_a(kind.noun)} is needed here, got `{word}`", _example(kind), at)
        return SpecValue(None, kind.rotary_unit, None, word, source, None, note, word == IDENTIFIED)
    if isinstance(number, bool) or not isinstance(number, (int, float, str)):
        raise fault(
            f"must be {_a(kind.noun)}, got {short(number)}", _one_number(number) or _example(kind), at
        )
    if unit_text is not None and isinstance(number, str):
        if not _PLAIN_NUMBER.fullmatch(number):
            raise fault(
                f"the unit stands twice, in `value: {short(number)}` and in `unit: {short(unit_text)}`",
                "remove `unit`",
                ("unit",),
            )
        number = float(number)
    try:
        parsed = (
            parse_quantity(number, kind) if unit_text is None else parse_with_unit(number, unit_text, kind)
        )
    except UnitError as err:
        remark = explained(number, kind, words, bool(at)) if isinstance(number, str) else None
        if remark is None or (err.help or "").startswith("did you mean"):
            raise fault(err.message, err.help, at) from None
        raise fault(*remark, at) from None
    unit = parsed.unit
    for bad, sense, bound in (
        (at_least is not None and parsed.value < at_least, ">=", at_least),
        (above is not None and parsed.value <= above, ">", above),
        (at_most is not None and parsed.value > at_most, "<=", at_most),
    ):
        if bad and bound is not None:
            # Of fewer per cent the part is as odd.
            percent = sense == "<=" and bound == 1.0 and 10.0 <= parsed.value <= 100.0
            raise fault(
                f"must be {sense} {format_quantity(bound, unit)}, got {format_quantity(parsed.value, unit)}",
                f"did you mean `{parsed.value:g} %`? That is {parsed.value / 100.0:g}" if percent else None,
                at,
            )
    std = None
    if std_given is not None:
        try:
            std_parsed = (
                parse_with_unit(std_given, unit_text, kind)
                if unit_text is not None and not isinstance(std_given, str)
                else parse_quantity(std_given, kind)
            )
        except UnitError as err:
            share = isinstance(std_given, str) and _PERCENT.fullmatch(std_given.strip())
            part = abs(parsed.value) * float(share[1]) / 100.0 if share else 0.0
            meant = f"{std_given} of the value is `{format_quantity(part, unit, 4)}`" if share else err.help
            raise fault(err.message, meant, ("std",)) from None
        std = std_parsed.value
        if std < 0:
            raise fault(
                f"must be >= {format_quantity(0.0, unit)}, got {format_quantity(std, unit)}", None, ("std",)
            )
        if None not in (parsed.linear, std_parsed.linear) and parsed.linear is not std_parsed.linear:
            raise fault(
                f"is in {std_parsed.unit}, but the value is in {unit}", f"write it in {unit}", ("std",)
            )
    written = short(number if unit_text is None else f"{short(number)} {unit_text}")
    return SpecValue(parsed.value, unit, parsed.linear, written, source, std, note)


class FieldParser(ABC):
    """Annotation of a field that parses what the YAML holds, and tells an editor what that may be."""

    __slots__ = ()

    @abstractmethod
    def __call__(self, given: Any) -> Any:
        """Parse what the YAML holds.

        Raises: PydanticCustomError: see `fault`.
        """

    @abstractmethod
    def json_schema(self) -> dict[str, Any]:
        """What the field takes, as a JSON Schema."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return self.json_schema()


@dataclass(frozen=True, slots=True)
class Number(FieldParser):
    """Annotation of a field that holds one number: `Annotated[SpecValue, Number(Kind.TORQUE, above=0)]`.

    Attributes: see `parse_value`; `identified` also takes the word `identified`, and `unknown` tells
    whether the field takes the word `unknown`.
    """

    kind: Kind
    at_least: float | None = None
    above: float | None = None
    at_most: float | None = None
    identified: bool = False
    unknown: bool = True

    @property
    def words(self) -> tuple[str, ...]:
        """Words that the field takes in place of a number."""
        return (UNKNOWN,) * self.unknown + (IDENTIFIED,) * self.identified

    def __call__(self, given: Any) -> SpecValue:
        """Parse what the YAML holds."""
        return parse_value(
            given, self.kind, at_least=self.at_least, above=self.above, at_most=self.at_most, words=self.words
        )

    def json_schema(self) -> dict[str, Any]:
        return value_schema(self)


@dataclass(frozen=True, slots=True)
class Pair(FieldParser):
    """Annotation of a field that holds `[low, high]` of one kind, low <= high."""

    kind: Kind
    at_least: float | None = None
    words: tuple[str, ...] = ()
    """Words that stand in place of the whole pair."""
    ordered: bool = True
    """Whether low <= high is demanded."""
    apart: bool = False
    """Whether low < high is: simulators refuse a joint or a control whose range has one value."""

    def __call__(self, given: Any) -> tuple[SpecValue, SpecValue] | str:
        """Parse what the YAML holds."""
        if isinstance(given, str) and given in self.words:
            return given
        if not isinstance(given, list) or len(given) != 2:
            choices = "".join(f", or `{word}`" for word in self.words)
            raise fault(
                f"must be [low, high], each {_a(self.kind.noun)}{choices}, got {short(given)}",
                # What is drawn is a factor, and 0 none of one.
                f"write for instance `{'[0.9, 1.1]' if self.kind is Kind.RATIO else f'[0, {EXAMPLES[self.kind]}]'}`",
            )
        end = Number(self.kind, at_least=self.at_least, unknown=False)
        low, high = (parse_below(index, item, end) for index, item in enumerate(given))
        if None not in (low.linear, high.linear) and low.linear is not high.linear:
            raise fault(
                f"the ends are in two units, {low.written} and {high.written}", "use one unit for both"
            )
        if self.ordered:
            check_order(low, high, apart=self.apart)
        return low, high

    def json_schema(self) -> dict[str, Any]:
        end = value_schema(Number(self.kind, at_least=self.at_least, unknown=False))
        pair = {"type": "array", "minItems": 2, "maxItems": 2, "items": end}
        return {"anyOf": [{"enum": list(self.words)}, pair]} if self.words else pair


def check_order(low: SpecValue, high: SpecValue, *, apart: bool) -> None:
    """Raise for ends that are the wrong way round or, where they must be apart, the same."""
    if low.value is None or high.value is None or low.value < high.value:
        return
    if low.value > high.value:
        raise fault(
            f"the range is the wrong way round: {low.written} is above {high.written}",
            f"write [{high.written}, {low.written}]",
        )
    if apart:
        size = low.written.lstrip("-+")
        raise fault(
            f"both ends of the range are {low.written}",
            f"is a sign missing? Then write [-{size}, {size}]" if low.value else "write two different ends",
        )


@dataclass(frozen=True, slots=True)
class Fault:
    """Why something written is not what its field needs.

    Attributes:
        message: What is wrong.
        help: The nearest right answer; None when there is none.
        at: Place below the field.
    """

    message: str
    help: str | None
    at: tuple[str | int, ...]


def pair_or_fault(given: Any, pair: Pair) -> tuple[SpecValue, SpecValue] | Fault:
    """Read a [low, high] whose kind another field decides, after the spec's shape was checked."""
    try:
        ends = pair(given)
    except PydanticCustomError as err:
        context = dict(err.context or {})
        return Fault(context["message"], context["help"], tuple(context["at"]))
    assert not isinstance(ends, str)
    return ends


def parse_below(key: str | int, given: Any, parse: Callable[[Any], T]) -> T:
    """Parse the value of `key` inside a mapping or list; an error names the key too."""
    try:
        return parse(given)
    except PydanticCustomError as err:
        context = dict(err.context or {})
        raise fault(context["message"], context["help"], (key, *context["at"])) from None


HOIST = "actspec-definition"
"""Key that marks a part of a JSON Schema as a definition of that name (see `schema`)."""


def value_schema(number: Number) -> dict[str, Any]:
    """JSON Schema of a number, for editors; what it accepts is a little more than `parse_value` does."""
    kind = number.kind
    unit = kind.rotary_unit
    if kind.linear_unit != unit:
        unit += f" or {kind.linear_unit}"
    positive = (number.above is not None and number.above >= 0) or (
        number.at_least is not None and number.at_least >= 0
    )
    text = {
        "type": "string",
        "pattern": r"^\s*\+?\.?[0-9]" if positive else r"^\s*[-+\u2212]?\.?[0-9]",
        "description": f"{_a(kind.noun).capitalize()} with its unit [{unit}], e.g. `{EXAMPLES[kind]}`.",
        "examples": [EXAMPLES[kind]],
    }
    bare: dict[str, Any] = {"type": "number", "description": f"{_a(kind.noun).capitalize()} in SI [{unit}]."}
    for key, bound in (
        ("minimum", number.at_least),
        ("exclusiveMinimum", number.above),
        ("maximum", number.at_most),
    ):
        if bound is not None:
            bare[key] = bound
    scalar = [bare, text]
    if not kind.bare:
        scalar = [text]
        if number.above is None:
            scalar.append({"const": 0, "description": f"0 alone stands without a unit [{unit}]."})
    if number.words:
        scalar.append({"enum": list(number.words), "description": "A word in place of the number."})
    within = {
        "value": {"anyOf": scalar, "description": f"The number [{unit}]."},
        "unit": {"type": "string", "description": "Unit of a bare `value` and `std`."},
        "source": {"type": "string", "description": "Key of `sources`."},
        "std": {
            "anyOf": [{"type": "number", "minimum": 0}, {**text, "pattern": r"^\s*\+?\.?[0-9]"}],
            "description": f"Standard deviation [{unit}].",
        },
        "note": {"type": "string", "description": "Remark."},
        "sure": {"type": "boolean", "description": "The number is right, whatever it implies."},
    }
    if not kind.bare:
        # A bare value is right beside a `unit`.
        within["value"] = {"anyOf": [*scalar, {"type": "number"}], "description": f"The number [{unit}]."}
    full = {
        "type": "object",
        "required": ["value"],
        "additionalProperties": False,
        "properties": within,
    }
    sign = "positive_" if number.above == 0.0 else "nonnegative_" if number.at_least == 0.0 else ""
    words = "".join(f"_or_{word}" for word in number.words)
    most = "" if number.at_most is None else f"_to_{number.at_most:g}"
    return {HOIST: f"{sign}{kind.noun.replace(' ', '_')}{most}{words}", "anyOf": [*scalar, full]}


def short(given: Any) -> str:
    """What was given, as YAML has it, cut to a length fit for a message."""
    if given is None or isinstance(given, bool):
        return "null" if given is None else str(given).lower()
    text = given if isinstance(given, str) else _written(given)
    return text if len(text) <= 60 else text[:57] + "..."


def _written(given: Any) -> str:
    """A value in the notation of YAML in which it needs one line."""
    if isinstance(given, dict):
        return "{" + ", ".join(f"{key}: {_written(value)}" for key, value in given.items()) + "}"
    if isinstance(given, list):
        return "[" + ", ".join(map(_written, given)) + "]"
    return short(given) if given is None or isinstance(given, bool) else repr(given)


def _in_quotes(given: Any) -> str | None:
    if isinstance(given, list) and len(given) == 1:
        return f"write `{short(given[0])}` without [ ]"
    return None if isinstance(given, (list, dict)) else f'write "{short(given)}" in quotes'


def _without_value(given: Mapping[str, Any], kind: Kind) -> PydanticCustomError:
    """The error for a mapping in place of a number that has no key `value`."""
    if kind is Kind.RATIO and list(given) == ["ratio"]:
        # As of a stage.
        return fault(f"must be a ratio, got {short(given)}", f"write `{short(given['ratio'])}`")
    for stage, keys in _STAGES.items() if kind is Kind.RATIO else ():
        if given.keys() & {stage, *keys}:
            whole = _written(given if stage in given else {stage: given})
            help = (
                f"teeth stand in a stage, of the motor's `gearbox: [{whole}]` or the group's `transmission`"
            )
            return fault(f"must be a ratio, got {short(given)}", help)
    for key, item in given.items():
        if nearest(key, VALUE_KEYS) is not None:
            continue
        if fits(f"{item} {key}", kind):
            return fault(
                f"`{short(key)}` is a unit, and no key", f"write `value: {short(item)} {short(key)}`", (key,)
            )
        if isinstance(item, (int, float, str)) and fits(item, kind):
            message = f"`{short(key)}` has a number of its own, and the field holds one for all joints"
            help = f'what differs stands in `overrides: {{"{short(key)}": {{...}}}}` of the group'
            return fault(message, help, (key,))
    check_keys(given, VALUE_KEYS, "a value")
    return fault("a value needs its key 'value'", "write {value: 33.5 N*m, source: ...}")


_STAGES = {"planetary": ("sun", "ring"), "teeth": ("driving", "driven")}
"""Stages that are stated by numbers of teeth, with their keys."""


def _one_number(given: Any) -> str | None:
    """What to write where one number must stand: for `[40]`, `[40, 30]`, `[value: 40, source: x]`, `{value: 40}`, and a
    stage, `[ratio: 9]`."""
    if isinstance(given, dict) and "value" in given:
        return f"write `{short(given['value'])}` without the inner {{ }}"
    if not isinstance(given, list) or not given:
        return None
    if all(isinstance(item, dict) for item in given):
        whole = {key: value for item in given for key, value in item.items()}
        pairs = ", ".join(f"{key}: {short(value)}" for key, value in whole.items())
        if list(whole) == ["ratio"]:
            return f"write `{short(whole['ratio'])}`"
        return f"write `{{{pairs}}}`" if "value" in whole else None
    if len(given) == 1:
        return f"write `{short(given[0])}` without [ ]"
    return "write one number; what differs by joint stands in `overrides` of the group"


def _example(kind: Kind) -> str:
    return f"write for instance `{EXAMPLES[kind]}`"


def _a(noun: str) -> str:
    return f"{'an' if noun[0] in 'aeiou' else 'a'} {noun}"


_PERCENT = re.compile(r"([0-9]*\.?[0-9]+) *%")
_PLAIN_NUMBER = re.compile(r"\s*[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?\s*", re.ASCII)


class Strict(BaseModel):
    """Base of all models: frozen, unknown keys refused, built when the first file is read.

    `use_attribute_docstrings` is off because it parses the source at every start; `descriptions`
    does so when somebody asks.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)


Name = Annotated[str, Field(min_length=1, max_length=200)]
Inertia = Annotated[SpecValue, Number(Kind.INERTIA, at_least=0.0)]
Ratio = Annotated[SpecValue, Number(Kind.RATIO, above=0.0)]
Factor = Annotated[SpecValue, Number(Kind.RATIO, above=0.0, unknown=False)]
Efficiency = Annotated[SpecValue, Number(Kind.RATIO, above=0.0, at_most=1.0)]
