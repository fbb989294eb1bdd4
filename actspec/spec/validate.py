"""Validation: a YAML document becomes a typed spec, or all of its errors at once.

Needs no robot: what a spec says about itself. Whether its patterns match the robot's joints is
`resolve`'s matter. `load_spec` also reads the results files that a spec names.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, TypeVar

from pydantic import BaseModel, ValidationError

from actspec.diagnostics import Collector, Path, Span, SpecError, listed, nearest
from actspec.spec.document import INCLUDED_KEYS, Breaches, Document, load_document, path_inside
from actspec.spec.faults import report, together
from actspec.spec.models import (
    GAPPED,
    SPEC_VERSION,
    SpecModel,
    Target,
)
from actspec.spec.plausible.numbers import check_numbers
from actspec.spec.rules import check_spec
from actspec.spec.shape import misplaced, misspelt, model_at
from actspec.spec.values import short
from actspec.spec.yaml_lines import EQUALS

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
            f"install a newer actspec, which reads version {version}",
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
        told_together = together(root, [path for item, path in items if item["type"] == "extra_forbidden"])
        told = {path for _, paths in told_together.values() for path in paths}
        swapped = _exchanged(root, data, items)
        strange = [path for item, path in items if item["type"] == "extra_forbidden"]
        no_names = {path for item, path in items if item["loc"][-1:] == ("[key]",)}
        for item, path in items:
            if faults is not None:
                faults.append(path)
            below = (*path, *item.get("ctx", {}).get("at", ()))
            if any(path[: len(name)] == name and path != name for name in no_names):
                # What it should hold depends on what it is.
                continue
            if item["type"] == "extra_forbidden":
                # Under an unknown key it does not matter that nothing is written.
                empty.pop(path, None)
                if path in told_together:
                    place, paths = told_together[path]
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
        held = model_at(root, path)
        help = "write a value, `unknown`, or remove the line"
        if held is not None:
            help = (
                f"write `{short(str(path[-1]))}: {{}}`"
                if held is Target
                else "indent what belongs to it below it"
            )
            help += ", or remove the line"
        equals, message = EQUALS.fullmatch(str(path[-1])), "is empty"
        if equals is not None:
            message, help = "has `=` in place of `:`", f"write `{equals[1]}: {short(equals[2])}`"
        elif str(path[-1]).endswith(")") and "(" not in str(path[-1]):
            message, help = "stands behind a comma in ( ), which is no list", "write the list in [ ]"
        breaches.error("SPEC103", message, path, help, key=True)
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
    pairs = [(parent, paths) for parent, paths in wrong.items() if len(paths) == 2 and paths[0] != paths[1]]
    for parent, (one, *others) in pairs[:MOST_EXCHANGED]:
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
"""Pairs of one spec that are tried: for each all of it is validated again."""


def _made_short(item: Any) -> bool:
    """Whether a list is short only because pydantic leaves out the entries that have errors of their own."""
    given = item.get("input")
    return (
        item["type"] == "too_short" and isinstance(given, list) and len(given) != item["ctx"]["actual_length"]
    )


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
