"""What pydantic finds wrong with a document, in the words of the language: message, place and what to write."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from pydantic import BaseModel, ValidationError

from actspec.diagnostics import Collector, Path, did_you_mean, listed
from actspec.patterns import apart
from actspec.spec.document import Breaches
from actspec.spec.gears import KINDS_OF_STAGE, Stage
from actspec.spec.models import (
    Actuators,
    Friction,
    Motor,
    Randomize,
    Robot,
    SpecModel,
    Target,
    Timing,
    Tunable,
)
from actspec.spec.rules.groups import RANDOMIZED_KINDS, check_randomize
from actspec.spec.shape import fields_of, model_at
from actspec.spec.values import short
from actspec.units import Kind, UnitError, parse_quantity
from actspec.units.kinds import in_units

_OTHER_WORDS = {
    **dict.fromkeys(("output", "gearbox", "load"), "joint"),
    "input": "motor",
    **dict.fromkeys(("torque", "force"), "effort"),
    "stiffness": "kp",
    "damping": "kd",
    "frictionloss": "friction.coulomb",
}
"""Words for the sides of a gearbox and for commands, and those of the language."""
_FACTORS = ("gains", "strength")
"""What is drawn as a factor alone."""


def report(breaches: Breaches, item: Any, path: Path, root: type[BaseModel]) -> None:
    """Add one pydantic error as a diagnostic in actspec's words."""
    kind = item["type"]
    context = item.get("ctx", {})
    given = item.get("input")
    if kind == "actspec":
        help = context["help"]
        if help == in_units(Kind.RATIO) and path[-1] == "scale":
            values = _range(str(path[-2]), given, breaches)
            help += "" if values is None else f"; of values write `{values}`"
        if help == in_units(Kind.RATIO) and path[-1] == "action_scale":
            help += "; write the number alone, in rad, rad/s or N*m"
        path = (*path, *context["at"])
        breaches.error("SPEC110", context["message"], path, help)
    elif kind == "missing":
        key = str(item["loc"][-1])
        parent = path if path and path[-1] != key else path[:-1]
        breaches.error("SPEC104", f"the key '{key}' is missing", parent, _description(root, (*parent, key)))
    elif kind == "extra_forbidden":
        key = str(item["loc"][-1])
        breaches.error(
            "SPEC101",
            f"unknown key '{short(key)}'",
            path,
            _help_for_key(key, model_at(root, path[:-1]), given),
            key=True,
        )
    elif kind == "literal_error":
        expected = str(context.get("expected", ""))
        options = [option.strip("' ") for option in expected.replace(" or ", ", ").split(",")]
        on_key = bool(item["loc"]) and item["loc"][-1] == "[key]"
        word = given.get("value") if isinstance(given, Mapping) else given
        help = _nearest_word(str(word).lower(), options)
        if word is not given and word in options:
            more = "; `sure: true` stands at a number that was judged with it" if "sure" in given else ""
            help = f"write `{path[-1]}: {word}`{more}"
        commented = _COMMENTED.match(word) if isinstance(word, str) else None
        if commented is not None and commented[1] in options:
            help = f"a comment begins with a space and `#`: write `{commented[1]} # {short(commented[2])}`"
        breaches.error(
            "SPEC105",
            f"must be {'one of ' * (len(options) > 1)}{', '.join(options)}, got {_got(given)}",
            path,
            help,
            key=on_key,
        )
    else:
        of = (*path, 0) if kind in ("tuple_type", "list_type") else path
        model = model_at(root, of)
        message, help = _in_yaml_words(kind, str(item["msg"]), context, given, model)
        if model is Randomize and isinstance(given, list):
            meant = _range(str(of[-1]), given, breaches)
            help = help if meant is None else f"write `{{{meant}}}`"
        if kind == "dict_type" and isinstance(given, list) and not message.endswith("a list"):
            help = _as_mapping(path, given)
            if path[-1] == "default_pose":
                message = message.replace("a mapping", "a mapping of joints to positions", 1)
        if kind == "string_type" and path[-1:] == ("motor",) and isinstance(given, Mapping):
            help = "write it below `motors:` under a name, and that name here"
        breaches.error("SPEC106", message, path, help)


def _nearest_word(word: str, options: Sequence[str]) -> str | None:
    """The help for a word that is none of these: the nearest, one that begins or ends so, or all that it begins."""
    parts = [option for option in options if option.startswith(f"{word}.")]
    if parts:
        return f"write {listed([f'`{part}`' for part in parts])} as one key"
    part = [
        option for option in options if len(word) > 1 and (option.startswith(word) or option.endswith(word))
    ]
    return did_you_mean(part[0] if len(part) == 1 else _OTHER_WORDS.get(word, word), options)


def _are_factors(ends: Sequence[Any]) -> bool:
    """Whether the ends of a range are in %, or numbers with 1, which changes nothing, between them."""
    if ends and all(str(end).endswith("%") for end in ends):
        return True
    numbers = [end for end in ends if isinstance(end, (int, float))]
    return len(numbers) == len(ends) > 0 and min(numbers) <= 1.0 <= max(numbers)


def _range(field: str, ends: list[Any], breaches: Breaches) -> str | None:
    """A range as it is written below its field; None: no operation takes such ends."""
    if field not in RANDOMIZED_KINDS or short(ends).endswith("..."):
        return None
    percent = [str(end).endswith("%") for end in ends]
    if any(percent) and not all(percent):
        return None
    # A bias has no nominal value that a factor could change.
    scaled = field != "encoder_bias" and (field in _FACTORS or _are_factors(ends))
    for operation in ("scale", "abs", "add") if scaled else ("abs", "add"):
        found = replace(breaches, collector=Collector())
        try:
            check_randomize((), field, Randomize.model_validate({operation: ends}), found)
        except ValidationError:
            continue
        if not list(found.collector):
            return f"{operation}: {short(ends)}"
    return None


def _items(texts: Iterable[str]) -> str:
    """Texts as the items of a list."""
    return ", ".join(f'"{bare}"' for text in texts if (bare := text.strip("\"'")))


def _in_yaml_words(
    kind: str,
    message: str,
    context: Mapping[str, Any],
    given: Any,
    model: type[BaseModel] | None,
) -> tuple[str, str | None]:
    """Message and help of a pydantic error about the shape of a value, or of a list of which `model` is an item."""
    got = f", got {_got(given)}"
    if kind in ("tuple_type", "list_type"):
        if isinstance(given, bool) or not isinstance(given, (str, int, float)):
            if model is Stage and isinstance(given, Mapping) and len(given.keys() & {*KINDS_OF_STAGE}) > 1:
                return f"must be a list{got}", _stages(given)
            whole = short(given)
            fits = isinstance(given, Mapping) and given and model is not None and not whole.endswith("...")
            return f"must be a list{got}", f"write `[{whole}]`" if fits else None
        if model is Stage:
            return f"must be a list{got}", f"write `[{_stage(given)}]`"
        dashed = _DASHED.match(str(given))
        if dashed is not None:
            return f"must be a list, and `-{short(dashed[1])}` lacks a space", f"write `- {short(dashed[1])}`"
        text = str(given)
        if text.count("]") > text.count("["):
            text = text.removesuffix("]")
        if text[:1] + text[-1:] == "()" and (len(apart(text[1:-1])) > 1 or text[1:2] in ("'", '"')):
            text = text[1:-1]
        parts, words = apart(text), text.split()
        if len(parts) == 1 < len(words) and not any(word[0].isdigit() for word in words):
            return (
                f"must be a list{got}",
                f"write `[{_items(words)}]`, or if it is one name `[{_items(parts)}]`",
            )
        return f"must be a list{got}", f"write `[{_items(parts)}]`"
    if kind in ("dict_type", "model_type", "model_attributes_type"):
        keys = sorted(fields_of(model))
        if model is Target and not isinstance(given, bool) and str(given)[:1].isdigit():
            return f"must be a mapping{got}", f'write `{{version: "{short(given)}"}}`'
        key = _ALONE.get(model) if model is not None else None
        if key is not None and isinstance(given, (str, int, float)):
            if model is Stage:
                return f"must be a mapping{got}", f"write `{_stage(given)}`"
            return f"must be a mapping{got}", f"write `{{{key}: {short(given)}}}`"
        listed_keys = isinstance(given, list) and given and all(isinstance(item, Mapping) for item in given)
        if listed_keys and model is not Randomize:
            first = next(iter(given[0]), "name")
            if first == "name" and isinstance(given[0]["name"], str):
                # Of what is held by its name.
                first = given[0]["name"]
            return "must be a mapping, and `- ` makes it a list", f"write `{short(first)}: ...` without `- `"
        return f"must be a mapping{got}", f"its keys: {listed(keys, 40)}" if keys else "write `{name: ...}`"
    if kind == "string_type":
        if isinstance(given, (bool, int, float)):
            return f"must be text{got}", f'write "{short(given)}" in quotes'
        alone = isinstance(given, list) and len(given) == 1 and isinstance(given[0], str)
        return f"must be text{got}", f"write `{short(given[0])}` without [ ]" if alone else None
    if kind.startswith("int_"):
        digits = re.fullmatch(r"(\d+)(?:\.0*)?", str(given).strip())
        return f"must be a whole number{got}", f"write `{digits[1]}`" if digits is not None else None
    if kind == "float_type":
        return f"must be a number{got}", None
    for prefix, sign, key in (("greater_than", ">", "g"), ("less_than", "<", "l")):
        if kind.startswith(prefix):
            equal = kind.endswith("_equal")
            return f"must be {sign}{'=' * equal} {context[key + ('e' if equal else 't')]}{got}", None
    if kind in ("too_short", "too_long"):
        least = kind == "too_short"
        bound = context["min_length" if least else "max_length"]
        have = context["actual_length"]
        return (
            f"must have at {'least' if least else 'most'} {bound} entr{'y' if bound == 1 else 'ies'}, got {have}",
            None,
        )
    if kind == "string_too_short":
        return "is an empty text", None
    if kind == "string_too_long":
        return f"must have at most {context['max_length']} characters, got {len(str(given))}", None
    if kind == "string_pattern_mismatch":
        return f"does not fit the form {context['pattern']}{got}", None
    return message[:1].lower() + message[1:] + got, None


_ALONE: dict[type[BaseModel], str] = {Friction: "coulomb", Stage: "ratio"}
"""Key that is meant by a value which stands alone."""

_TO_ONE = re.compile(r"\s*(\d+(?:\.\d+)?)\s*(?::\s*1\s*)?")
"""A gear ratio: `9`, `9:1`."""


def _stages(given: Mapping[str, Any]) -> str:
    """How the stages are written that one mapping holds."""
    stages = ", ".join(f"{{{key}: {short(item)}}}" for key, item in given.items() if key in KINDS_OF_STAGE)
    rest = listed(f"`{short(key)}`" for key in given if key not in KINDS_OF_STAGE)
    return f"write `[{stages}]`" + (f", {rest} in its own stage" if rest else "")


def _stage(given: Any) -> str:
    """How a stage is written of which a number stands alone."""
    ratio = _TO_ONE.fullmatch(str(given))
    return f"{{ratio: {'...' if ratio is None else ratio[1]}}}"


_VALUES = {"default_pose": "30 deg", "accept": "why it is taken", "packages": "its folder"}
"""What a name stands for in mappings that are no sections, as an example."""


def _as_mapping(path: Path, given: list[Any]) -> str | None:
    """How a list of names, or of the values without their names, is written as a mapping."""
    value = _VALUES.get(str(path[-1]), "{}" if path == ("targets",) else "{...}")
    if path[-1] == "default_pose":
        return f"name the joint of each position: write `{{JOINT: {value}, ...}}`; joints that are not named are at 0"
    names = [item for item in given if isinstance(item, str)]
    return f"write `{{{', '.join(f'{short(name)}: {value}' for name in names)}}}`" if names == given else None


_DASHED = re.compile(r"-[^\S ]?([^\s\d-]\S*)")
"""A list's item without the space behind its hyphen."""

_COMMENTED = re.compile(r"(\w+)\s*(?://|#|;|--)\s*(\S.*)")
"""A word with a comment of another language behind it."""

_MISNOMERS = {
    "kv": "a motor's speed constant is stated as its inverse, `torque_constant`: 100 rpm/V is 0.0955 N*m/A",
    "kt": "a motor's torque per ampere is `torque_constant`",
    **dict.fromkeys(
        (
            *("backlash", "pole_pairs", "poles", "resistance", "phase_resistance", "terminal_resistance"),
            *("inductance", "phase_inductance", "terminal_inductance"),
        ),
        "nothing is made of it: keep it in `note`, or leave it out",
    ),
    **dict.fromkeys(
        ("control_period", "control_frequency"),
        "the control period is `timing: {control_dt: ...}`, or `decimation` steps of `physics_dt`",
    ),
    "damping": "`kd` is the drive's velocity gain; passive joint damping is `friction: {viscous: ...}`",
    "stiffness": "the drive's stiffness is `kp`",
    "frictionloss": "dry friction is `friction: {coulomb: ...}`",
    "torque_limit": "the clamp of the drive's torque is `effort_limit`",
    "forcerange": "the clamp of the drive's torque is `effort_limit`",
    "saturation_effort": "the torque at zero speed is the motor's `stall_torque`",
    "rated_torque": "the thermal limit is `continuous_torque`",
    "nominal_torque": "the thermal limit is `continuous_torque`",
    **dict.fromkeys(
        ("rated_speed", "nominal_speed"),
        "the speed under load is no key: `no_load_speed` is that without load, which is higher",
    ),
    "stall_current": "the stall current, volts over ohms, is no `peak_current`, which is what the drive gives: "
    "leave it out; times `torque_constant` it is the motor's `stall_torque`",
    "current": "a motor's largest current is `peak_current`, the continuous one `nominal_current`",
    "rated_current": "the continuous current is `nominal_current`",
    "gains": "`kp` and `kd` stand in the group itself, each on a line of its own",
    "gear": "gears are the motor's `gear_ratio`, and `reduction` from its output to the joint",
    **dict.fromkeys(
        ("planetary", "sun", "ring"),
        "a planetary gear is a stage: `gearbox: [{planetary: {sun: 18, ring: 90}}]` of the motor",
    ),
    **dict.fromkeys(
        ("belt", "pulleys", "teeth", "driving", "driven"),
        "wheels and belts are stages, `{teeth: {driving: 20, driven: 32}}`, of the motor's `gearbox` or, behind its "
        "output, of the group's `transmission`",
    ),
    "saturation": "the torque at zero speed is the motor's `stall_torque`",
    "latency": "the delay of the command is `delay`",
    "timestep": "the simulation's step is `timing: {physics_dt: ...}`",
    "dt": "the simulation's step is `timing: {physics_dt: ...}`",
}
"""Words of simulators and configs to the language's own."""

_SECTIONS: tuple[tuple[type[BaseModel], str], ...] = (
    (SpecModel, "the top of the spec"),
    (Actuators, "a group, actuators.NAME"),
    (Motor, "a motor, motors.NAME"),
    (Friction, "`friction`"),
    (Timing, "`timing`"),
    (Robot, "`robot`"),
)


def _help_for_key(key: str, model: type[BaseModel] | None, given: Any) -> str | None:
    """The nearest known key for one that holds `given`, or where this one belongs."""
    known = sorted(fields_of(model))
    if model is Tunable and key in Actuators.model_fields:
        return f"`{key}` holds for a whole group: give these joints a group of their own"
    if key == "kv" and model is not Motor:
        return "the drive's velocity gain is `kd`"
    if key == "kv" and isinstance(given, str):
        try:
            parse_quantity(given, Kind.TORQUE_CONSTANT)
        except UnitError as err:
            if (err.help or "").startswith("a speed constant"):
                return f"write it as `torque_constant`: {err.help}"
    if key in _MISNOMERS:
        return _MISNOMERS[key]
    place = _place_of(key, model)
    if place is not None:
        return f"`{key}` belongs to {place}"
    return did_you_mean(key, known, f"known keys: {listed(known, 40)}" if known else None)


def _place_of(key: str, model: type[BaseModel] | None) -> str | None:
    """Where a key belongs that is not the model's; None: nowhere, or another remark says more."""
    if (model is Tunable and key in Actuators.model_fields) or key in _MISNOMERS:
        return None
    found = (place for section, place in _SECTIONS if key in section.model_fields)
    return None if key in ("name", "note", "joints") else next(found, None)


def together(root: type[BaseModel], strange: Iterable[Path]) -> dict[Path, tuple[str, tuple[Path, ...]]]:
    """Unknown keys of one mapping that belong to one place: the first of them to the place and all."""
    groups: dict[tuple[Path, str], list[Path]] = {}
    for path in strange:
        place = _place_of(str(path[-1]), model_at(root, path[:-1]))
        if place is not None:
            groups.setdefault((path[:-1], place), []).append(path)
    return {paths[0]: (place, tuple(paths)) for (_, place), paths in groups.items() if len(paths) > 1}


def _got(given: Any) -> str:
    """What was given; text in quotes, so that "1" is not taken for 1."""
    return f"'{short(given)}'" if isinstance(given, str) else short(given)


def _description(root: type[BaseModel], path: Path) -> str | None:
    from actspec.spec.models import SPEC_VERSION
    from actspec.spec.schema import descriptions

    model = model_at(root, path[:-1])
    if model is None:
        return None
    texts = descriptions(model)
    for name, info in model.model_fields.items():
        if (info.alias or name) == path[-1] and name in texts:
            text = " ".join(texts[name].split())
            # `MJCF` begins a text, too.
            text = text if text[1:2].isupper() else text[:1].lower() + text[1:]
            value = SPEC_VERSION if path == ("actspec",) else "..."
            return f"add `{path[-1]}: {value}`, {text.removesuffix(f': {value}.')}"
    return None
