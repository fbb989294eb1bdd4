"""Validation: a YAML document becomes a typed spec, or all of its errors at once.

Needs no robot: what a spec says about itself. Whether its patterns match the robot's joints is
`resolve`'s matter.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, get_args, get_origin

from pydantic import BaseModel, ValidationError

from actspec.diagnostics import Collector, Span, SpecError, listed, nearest
from actspec.spec.models import SPEC_VERSION, SpecModel
from actspec.spec.rules import check_spec
from actspec.spec.values import short

if TYPE_CHECKING:
    from actspec.spec.document import Document
    from actspec.spec.results import Results

Path = tuple[str | int, ...]


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
    results: Mapping[str, Results] = field(default_factory=dict)
    diagnostics: tuple[Any, ...] = ()

    def span(self, *path: str | int) -> Span:
        """Where a value is written (or its nearest parent)."""
        return self.document.spans.value(path)


def validate(document: Document) -> Spec:
    """Check a document against the spec language.

    Raises:
        SpecError: with every error of the document.
    """
    collector = Collector()
    data = document.data
    version = data.get("actspec")
    if isinstance(version, int) and not isinstance(version, bool) and version > SPEC_VERSION:
        collector.error(
            "SPEC102",
            f"the spec is written for version {version} of the language, this actspec reads version {SPEC_VERSION}",
            where="actspec",
            span=document.spans.value(("actspec",)),
            help=f"install an actspec that reads version {version}: `pip install --upgrade actspec`",
        )
        raise SpecError(collector.sorted())
    empty = set()
    for path in _nulls(data):
        empty.add(path)
        collector.error(
            "SPEC103",
            "is empty",
            where=dotted(path),
            span=document.spans.key(path),
            help="write a value, `unknown`, or remove the line",
        )
    model: SpecModel | None = None
    try:
        model = SpecModel.model_validate(data)
    except ValidationError as err:
        for item in err.errors(include_url=False):
            path = written_path(tuple(item["loc"]), data)
            if path not in empty:
                report(collector, document, item, path, SpecModel)
    if model is not None and version is not None and version < SPEC_VERSION:
        collector.error(
            "SPEC102",
            f"there is no version {version} of the language",
            where="actspec",
            span=document.spans.value(("actspec",)),
            help=f"write `actspec: {SPEC_VERSION}`",
        )
    if model is not None:
        check_spec(model, document, collector)
    collector.raise_if_failed(SpecError)
    assert model is not None
    return Spec(model, document, diagnostics=collector.sorted())


def report(collector: Collector, document: Document, item: Any, path: Path, root: type[BaseModel]) -> None:
    """Add one pydantic error as a diagnostic in actspec's words."""
    kind = item["type"]
    context = item.get("ctx", {})
    given = item.get("input")
    span = document.spans.value(path)
    if kind == "actspec":
        path = (*path, *context["at"])
        collector.error(
            "SPEC110",
            context["message"],
            where=dotted(path),
            span=document.spans.value(path),
            help=context["help"],
        )
    elif kind == "missing":
        key = str(item["loc"][-1])
        parent = path if path and path[-1] != key else path[:-1]
        collector.error(
            "SPEC104",
            f"the key '{key}' is missing",
            where=dotted(parent),
            span=document.spans.value(parent),
            help=_description(root, (*parent, key)),
        )
    elif kind == "extra_forbidden":
        key = str(item["loc"][-1])
        known = sorted(_known_keys(root, path[:-1]))
        guess = nearest(key, known)
        help = f"did you mean '{guess}'?" if guess else f"known keys: {listed(known, 40)}" if known else None
        collector.error(
            "SPEC101", f"unknown key '{key}'", where=dotted(path), span=document.spans.key(path), help=help
        )
    elif kind == "literal_error":
        expected = str(context.get("expected", ""))
        options = [option.strip("' ") for option in expected.replace(" or ", ", ").split(",")]
        on_key = bool(item["loc"]) and item["loc"][-1] == "[key]"
        guess = nearest(str(given), options)
        collector.error(
            "SPEC105",
            f"must be one of {', '.join(options)}, got {short(given)}",
            where=dotted(path),
            span=document.spans.key(path) if on_key else span,
            help=f"did you mean '{guess}'?" if guess else None,
        )
    else:
        message = str(item["msg"])
        message = message[:1].lower() + message[1:]
        collector.error("SPEC106", f"{message}, got {short(given)}", where=dotted(path), span=span)


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


def dotted(path: Path) -> str:
    """`('actuators', 'legs', 'joints', 0)` as `actuators.legs.joints[0]`."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            text += f".{part}" if text else part
    return text


def _nulls(node: Any, path: Path = ()) -> Iterator[Path]:
    if node is None:
        yield path
    elif isinstance(node, Mapping):
        for key, value in node.items():
            yield from _nulls(value, (*path, key))
    elif isinstance(node, list):
        for index, value in enumerate(node):
            yield from _nulls(value, (*path, index))


def _model_at(root: type[BaseModel], path: Path) -> type[BaseModel] | None:
    """The model that describes the mapping at `path`."""
    node: Any = root
    for part in path:
        node = _unwrapped(node)
        if isinstance(node, type) and issubclass(node, BaseModel):
            by_alias = {info.alias or name: info for name, info in node.model_fields.items()}
            if part not in by_alias:
                return None
            node = by_alias[str(part)].annotation
        elif get_origin(node) in (dict, list, tuple):
            arguments = get_args(node)
            node = arguments[1] if get_origin(node) is dict else arguments[0]
        else:
            return None
    node = _unwrapped(node)
    return node if isinstance(node, type) and issubclass(node, BaseModel) else None


def _unwrapped(node: Any) -> Any:
    """The annotation without Annotated and Optional; of a union, its first model."""
    while hasattr(node, "__metadata__"):
        node = node.__origin__
    if get_origin(node) is None or get_origin(node) in (dict, list, tuple):
        return node
    arguments = [_unwrapped(part) for part in get_args(node) if part is not type(None)]
    models = [part for part in arguments if isinstance(part, type) and issubclass(part, BaseModel)]
    nested = [part for part in arguments if get_origin(part) is not None]
    return (models or nested or arguments or [node])[0]


def _known_keys(root: type[BaseModel], path: Path) -> list[str]:
    model = _model_at(root, path)
    if model is None:
        return []
    return [info.alias or name for name, info in model.model_fields.items()]


def _description(root: type[BaseModel], path: Path) -> str | None:
    model = _model_at(root, path[:-1])
    if model is None:
        return None
    for name, info in model.model_fields.items():
        if (info.alias or name) == path[-1] and info.description:
            return f"{path[-1]}: {' '.join(info.description.split())}"
    return None
