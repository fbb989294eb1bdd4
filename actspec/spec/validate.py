"""Validation: a YAML document becomes a typed spec, or all of its errors at once.

Needs no robot: what a spec says about itself. Whether its patterns match the robot's joints is
`resolve`'s matter. `load_spec` also reads the results files that a spec names.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, TypeVar

from pydantic import BaseModel, ValidationError

from actspec.diagnostics import Collector, Path, Span, SpecError, did_you_mean, listed, nearest
from actspec.patterns import apart
from actspec.spec.document import INCLUDED_KEYS, Breaches, Document, load_document, path_inside
from actspec.spec.models import (
    GAPPED,
    SPEC_VERSION,
    Actuators,
    Friction,
    Motor,
    Robot,
    SpecModel,
    Timing,
    Tunable,
)
from actspec.spec.plausible import check_numbers
from actspec.spec.rules import check_spec
from actspec.spec.shape import fields_of, misplaced, misspelt, model_at
from actspec.spec.values import short

if TYPE_CHECKING:
    from actspec.spec.results import ResultsFile


M = TypeVar("M", bound=BaseModel)


@dataclass(frozen=True, slots=True)
class Spec:
    """A valid spec.

    Attributes:
        model: What it says.
        document: Where it says it.
        results: Identification results that it names, by the path as written.
        diagnostics: Warnings of validation.
    """

    model: SpecModel
    document: Document
    results: Mapping[str, ResultsFile] = field(default_factory=dict)
    diagnostics: tuple[Any, ...] = ()

    def with_packages(self, packages: Mapping[str, str]) -> Spec:
        """The spec with these folders of ROS packages beside and before its own."""
        if not packages:
            return self
        robot = self.model.robot
        robot = robot.model_copy(update={"packages": {**robot.packages, **packages}})
        return replace(self, model=self.model.model_copy(update={"robot": robot}))

    def span(self, *path: str | int) -> Span:
        """Where a value is written (or its nearest parent)."""
        return self.document.spans.value(path)


def validate(document: Document) -> Spec:
    """Check a document against the spec language.

    Raises:
        SpecError: with every error of the document.
    """
    collector = Collector()
    document = _with_sections(document, collector)
    breaches = Breaches(document.spans, collector)
    data = document.data
    version = data.get("actspec")
    if isinstance(version, int) and not isinstance(version, bool) and version > SPEC_VERSION:
        breaches.error(
            "SPEC102",
            f"the spec is written for version {version} of the language, this actspec reads version {SPEC_VERSION}",
            ("actspec",),
            f"install an actspec that reads version {version}: `pip install --upgrade actspec`",
        )
        raise SpecError(collector.sorted())
    layout = misplaced(document, INCLUDED_KEYS if document.includes else ())
    for item in layout:
        breaches.error(item.code, item.message, item.path, item.help, key=item.key)
    if layout:
        raise SpecError(collector.sorted())
    faults: list[Path] = []
    model = checked(SpecModel, document, collector, faults)
    if model is not None and version is not None and version < SPEC_VERSION:
        breaches.error(
            "SPEC102",
            f"there is no version {version} of the language",
            ("actspec",),
            f"write `actspec: {SPEC_VERSION}`",
        )
    if model is not None:
        check_spec(model, document, breaches)
        check_numbers(model, document, collector)
    else:
        rest = salvaged(data, faults)
        if rest is not None:
            check_spec(rest[0], document, replace(breaches, left_out=rest[1]))
    collector.raise_if_failed(SpecError)
    assert model is not None
    return Spec(model, document, diagnostics=collector.sorted())


def _with_sections(document: Document, collector: Collector) -> Document:
    """The document with a misspelt section under its own name, which is reported, so that nothing else misses it.

    Raises:
        SpecError: it is no spec but a part of one.
    """
    breaches = Breaches(document.spans, collector)
    if document.data and not document.data.keys() - {*INCLUDED_KEYS}:
        name = short(os.path.basename(document.path))
        held = " and ".join(f"`{key}`" for key in document.data)
        breaches.error(
            "SPEC104",
            f"this is a part that specs include, with {held} alone",
            (),
            f"check a spec that names it under `include`, such as `include: [{name}]`",
        )
        raise SpecError(collector.sorted())
    for key, meant in misspelt(document.data, INCLUDED_KEYS if document.includes else ()):
        breaches.error("SPEC101", f"unknown key '{short(key)}'", (key,), f"did you mean '{meant}'?", key=True)
        document = document.with_key(key, meant)
    return document


def checked(
    root: type[M], document: Document, collector: Collector, faults: list[Path] | None = None
) -> M | None:
    """The document as a model; None when it is none, with every reason reported.

    Args:
        root: The model.
        document: What was read.
        collector: Takes the reasons.
        faults: Takes their places.
    """
    data = document.data
    breaches = Breaches(document.spans, collector)
    empty = dict.fromkeys(_nulls(data))
    model: M | None = None
    try:
        model = root.model_validate(data)
    except ValidationError as err:
        items = [(item, written_path(tuple(item["loc"]), data)) for item in err.errors(include_url=False)]
        together = _together(root, [path for item, path in items if item["type"] == "extra_forbidden"])
        told = {path for _, paths in together.values() for path in paths}
        swapped = _exchanged(root, data, items)
        strange = [path for item, path in items if item["type"] == "extra_forbidden"]
        for item, path in items:
            if faults is not None:
                faults.append(path)
            below = (*path, *item.get("ctx", {}).get("at", ()))
            if item["type"] == "extra_forbidden":
                # Under an unknown key it does not matter that nothing is written.
                empty.pop(path, None)
                if path in together:
                    place, paths = together[path]
                    keys = [short(str(one[-1])) for one in paths]
                    quoted, marked = ([f"{q}{key}{q}" for key in keys] for q in ("'", "`"))
                    help = f"{listed(marked, 40)} belong to {place}"
                    message = f"unknown keys {listed(quoted, 40)}"
                    breaches.error("SPEC101", message, path, help, key=True)
                if path in told:
                    continue
            elif (
                below in empty
                or _made_short(item)
                or path in swapped.values()
                or _is_misspelt(item, path, strange)
            ):
                continue
            if path in swapped:
                one, two = path[-1], swapped[path][-1]
                message = f"{one} and {two} are exchanged: {item['ctx']['message']}"
                breaches.error("SPEC110", message, path, "exchange the two values")
                continue
            report(breaches, item, path, root)
    for path in empty:
        breaches.error("SPEC103", "is empty", path, "write a value, `unknown`, or remove the line", key=True)
        if faults is not None:
            faults.append(path)
    return None if empty else model


def _is_misspelt(item: Any, parent: Path, strange: Iterable[Path]) -> bool:
    """Whether a key that is missing stands there as an unknown one, such as `Level`, whose help names it."""
    if item["type"] != "missing":
        return False
    key = str(item["loc"][-1])
    return any(path[:-1] == parent and nearest(str(path[-1]), [key]) is not None for path in strange)


def _exchanged(root: type[BaseModel], data: Any, items: Sequence[tuple[Any, Path]]) -> dict[Path, Path]:
    """Two fields of one mapping that are both wrong, and right with the value of the other: the first to the second."""
    wrong: dict[Path, list[Path]] = {}
    for item, path in items:
        if item["type"] == "actspec" and path and isinstance(path[-1], str):
            wrong.setdefault(path[:-1], []).append(path)
    found: dict[Path, Path] = {}
    for parent, (one, *others) in wrong.items():
        if len(others) != 1 or one == others[0] or len(found) == MOST_EXCHANGED:
            continue
        changed = deepcopy(data)
        node = changed
        for part in parent:
            node = node[part]
        node[one[-1]], node[others[0][-1]] = node[others[0][-1]], node[one[-1]]
        still: set[Path] = set()
        try:
            root.model_validate(changed)
        except ValidationError as err:
            still = {written_path(tuple(item["loc"]), changed) for item in err.errors(include_url=False)}
        if not {one, *others} & still:
            found[one] = others[0]
    return found


MOST_EXCHANGED = 10
"""Exchanges of one spec; each is proved by validation."""


def _made_short(item: Any) -> bool:
    """Whether a list is short only because pydantic leaves out the entries that have errors of their own."""
    given = item.get("input")
    return (
        item["type"] == "too_short" and isinstance(given, list) and len(given) != item["ctx"]["actual_length"]
    )


_OTHER_WORDS = {"output": "joint", "gearbox": "joint", "load": "joint", "input": "motor"}
"""Words for the sides of a gearbox, and the one of the language."""


def report(breaches: Breaches, item: Any, path: Path, root: type[BaseModel]) -> None:
    """Add one pydantic error as a diagnostic in actspec's words."""
    kind = item["type"]
    context = item.get("ctx", {})
    given = item.get("input")
    if kind == "actspec":
        path = (*path, *context["at"])
        breaches.error("SPEC110", context["message"], path, context["help"])
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
            _help_for_key(key, model_at(root, path[:-1])),
            key=True,
        )
    elif kind == "literal_error":
        expected = str(context.get("expected", ""))
        options = [option.strip("' ") for option in expected.replace(" or ", ", ").split(",")]
        on_key = bool(item["loc"]) and item["loc"][-1] == "[key]"
        word = given.get("value") if isinstance(given, Mapping) else given
        help = did_you_mean(_OTHER_WORDS.get(str(word), str(word)), options)
        if word is not given and word in options:
            more = "; `sure: true` stands at a number that was judged with it" if "sure" in given else ""
            help = f"write `{path[-1]}: {word}`{more}"
        breaches.error(
            "SPEC105",
            f"must be {'one of ' * (len(options) > 1)}{', '.join(options)}, got {_got(given)}",
            path,
            help,
            key=on_key,
        )
    else:
        of = (*path, 0) if kind in ("tuple_type", "list_type") else path
        message, help = _in_yaml_words(kind, str(item["msg"]), context, given, model_at(root, of))
        if kind == "dict_type" and isinstance(given, list) and not message.endswith("a list"):
            help = _as_mapping(path, given)
            if path[-1] == "default_pose":
                message = message.replace("a mapping", "a mapping of joints to positions", 1)
        if kind == "string_type" and path[-1:] == ("motor",) and isinstance(given, Mapping):
            help = "write it below `motors:` under a name, and that name here"
        breaches.error("SPEC106", message, path, help)


def _in_yaml_words(
    kind: str, message: str, context: Mapping[str, Any], given: Any, model: type[BaseModel] | None
) -> tuple[str, str | None]:
    """Message and help of a pydantic error about the shape of a value, or of a list of which `model` is an item."""
    got = f", got {_got(given)}"
    if kind in ("tuple_type", "list_type"):
        if isinstance(given, bool) or not isinstance(given, (str, int, float)):
            whole = short(given)
            fits = isinstance(given, Mapping) and model is not None and not whole.endswith("...")
            return f"must be a list{got}", f"write `[{whole}]`" if fits else None
        dashed = _DASHED.match(str(given))
        if dashed is not None:
            return f"must be a list, and `-{short(dashed[1])}` lacks a space", f"write `- {short(dashed[1])}`"
        text = str(given)
        if text.count("]") > text.count("["):
            text = text.removesuffix("]")
        if text[:1] + text[-1:] == "()" and len(apart(text[1:-1])) > 1:
            text = text[1:-1]
        items = ", ".join(f'"{bare}"' for item in apart(text) if (bare := item.strip("\"'")))
        return f"must be a list{got}", f"write `[{items}]`"
    if kind in ("dict_type", "model_type", "model_attributes_type"):
        keys = sorted(fields_of(model))
        if isinstance(given, list) and given and all(isinstance(item, Mapping) for item in given):
            first = next(iter(given[0]), "name")
            return "must be a mapping, and `- ` makes it a list", f"write `{short(first)}: ...` without `- `"
        return f"must be a mapping{got}", f"its keys: {listed(keys, 40)}" if keys else "write `{name: ...}`"
    if kind == "string_type":
        if isinstance(given, (bool, int, float)):
            return f"must be text{got}", f'write "{short(given)}" in quotes'
        alone = isinstance(given, list) and len(given) == 1 and isinstance(given[0], str)
        return f"must be text{got}", f"write `{short(given[0])}` without [ ]" if alone else None
    if kind.startswith("int_"):
        return f"must be a whole number{got}", None
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

_MISNOMERS = {
    "damping": "`kd` is the drive's velocity gain; passive joint damping is `friction: {viscous: ...}`",
    "stiffness": "the drive's stiffness is `kp`",
    "frictionloss": "dry friction is `friction: {coulomb: ...}`",
    "torque_limit": "the clamp of the drive's torque is `effort_limit`",
    "forcerange": "the clamp of the drive's torque is `effort_limit`",
    "saturation_effort": "the torque at zero speed is the motor's `stall_torque`",
    "rated_torque": "the thermal limit is `continuous_torque`",
    "nominal_torque": "the thermal limit is `continuous_torque`",
    "rated_current": "the continuous current is `nominal_current`",
    "gains": "`kp` and `kd` stand in the group itself, each on a line of its own",
    "gear": "gears are the motor's `gear_ratio`, and `reduction` from its output to the joint",
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


def _help_for_key(key: str, model: type[BaseModel] | None) -> str | None:
    """The nearest known key, or where this one belongs."""
    known = sorted(fields_of(model))
    if model is Tunable and key in Actuators.model_fields:
        return f"`{key}` holds for a whole group: give these joints a group of their own"
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


def _together(root: type[BaseModel], strange: Iterable[Path]) -> dict[Path, tuple[str, tuple[Path, ...]]]:
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


def written_path(loc: Path, data: Any) -> Path:
    """The part of a pydantic location that exists in the YAML, union tags left out."""
    path: list[str | int] = []
    node = data
    for part in loc:
        try:
            node = node[part]
        except (KeyError, IndexError, TypeError):
            # A tag of a union that pydantic puts between the keys.
            continue
        path.append(part)
    return tuple(path)


def _nulls(node: Any, path: Path = ()) -> Iterator[Path]:
    """Places of values that are not written, but where a gap is one."""
    if node is None:
        yield path
    elif isinstance(node, Mapping):
        for key, value in node.items():
            yield from _nulls(value, (*path, key))
    elif isinstance(node, list):
        for index, value in enumerate(node):
            if value is not None or path[-1:] != (GAPPED,):
                yield from _nulls(value, (*path, index))


def _description(root: type[BaseModel], path: Path) -> str | None:
    from actspec.spec.schema import descriptions

    model = model_at(root, path[:-1])
    if model is None:
        return None
    texts = descriptions(model)
    for name, info in model.model_fields.items():
        if (info.alias or name) == path[-1] and name in texts:
            return f"{path[-1]}: {' '.join(texts[name].split())}"
    return None


_BY_NAME = ("actuators", "motors", "linkages", "sources", "targets", "accept")
"""Sections of named parts: a fault concerns its part."""
_ROBOT = {"name": "robot", "model": "robot"}
_GROUP = {"joints": ["joint"], "level": "ideal_pd"}


def salvaged(data: dict[str, Any], faults: Iterable[Path]) -> tuple[SpecModel, frozenset[Path]] | None:
    """The spec without the parts that have faults.

    Args:
        data: The document.
        faults: Place of every fault.

    Returns:
        The rest, and the places of which it tells nothing: what is left out, and what refers to it.
        None where nothing is left.
    """
    # A fault at () is a missing section.
    left_out = {path[: 2 if path[0] in _BY_NAME else 1] for path in faults if path}
    rest = {key: dict(value) if isinstance(value, dict) else value for key, value in data.items()}
    for path in left_out:
        if len(path) == 2 and isinstance(rest.get(str(path[0])), dict):
            rest[str(path[0])].pop(path[1], None)
        else:
            rest.pop(str(path[0]), None)
    rest["actspec"] = SPEC_VERSION
    rest.setdefault("robot", _ROBOT)
    if not rest.get("actuators"):
        rest["actuators"] = {"": _GROUP}
        left_out.add(("actuators", ""))
    try:
        model = SpecModel.model_validate(rest)
    except ValidationError:
        return None
    for name, linkage in model.linkages.items():
        if any(("motors", motor) in left_out for motor in linkage.motors) or ("motors",) in left_out:
            left_out.add(("linkages", name))
    unlinked = any(path[:1] == ("linkages",) for path in left_out)
    for name, group in model.actuators.items():
        motors = [group.motor, *(override.motor for override in group.overrides.values())]
        if group.motor is None and unlinked:
            # Its motors may be those of a linkage that is left out.
            left_out.add(("actuators", name))
        if any(("motors", motor) in left_out for motor in motors) or ("motors",) in left_out:
            left_out.add(("actuators", name))
    if any(path[:1] == ("targets",) for path in left_out):
        left_out.add(("accept",))
    return model, frozenset(left_out)


_RESULTS = "results are a relative path inside the folder of the spec, such as results/legs.yaml"


def load_spec(path: str) -> Spec:
    """Read and validate a spec and the results files that it names; its networks lie below its folder.

    Args:
        path: The file, or `FILE#VARIANT`.

    Raises:
        SpecError: with every error of the spec, or of all of its results files.

    Results of another robot are a warning in `Spec.diagnostics`.
    """
    spec = validate(load_document(path, is_spec=True))
    path = spec.document.path
    folder = os.path.dirname(os.path.abspath(path))
    collector = Collector()
    results: dict[str, ResultsFile] = {}
    for name, group in spec.model.actuators.items():
        named = group.identified
        if named is None or named in results:
            continue
        where = f"actuators.{name}.identified"
        place = collector.at(where, spec.span("actuators", name, "identified"))
        if path_inside(named, folder, place, _RESULTS) is None:
            continue
        # Most specs name no results, and the models take time to build.
        from actspec.spec.results import ResultsFile, validate_results

        try:
            document = load_document(os.path.join(os.path.dirname(path), named))
            found = validate_results(document)
        except SpecError as err:
            for item in err.diagnostics:
                if item.span is None or not item.span.line:
                    # About the file as a whole: the place to change is the line that names it.
                    item = replace(item, where=where, span=place.span)
                collector.add(item)
            continue
        results[named] = ResultsFile(found, document)
        if found.robot != spec.model.robot.name:
            collector.warning(
                "RES012",
                f"'{named}' has the results of the robot '{found.robot}', the spec is for '{spec.model.robot.name}'",
                where=where,
                span=spec.span("actuators", name, "identified"),
                help="name this robot's results, or correct `robot` in one of the two files",
            )
    if spec.model.delta_action is not None or any(g.network for g in spec.model.actuators.values()):
        from actspec.spec.network import check_named

        check_named(spec, collector)
    collector.raise_if_failed(SpecError)
    return replace(spec, results=results, diagnostics=(*spec.diagnostics, *collector.sorted()))
