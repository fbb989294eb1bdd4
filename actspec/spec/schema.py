"""JSON Schemas of the files that people write, for editors; generated from the models.

An editor checks less than `actspec validate`: units, references and patterns are not in a schema.

Descriptions of fields are the strings under them in the models' source. pydantic can read them as each class is made,
which parses the source at every start of the tool; only a schema and the help of a missing key need them.
"""

from __future__ import annotations

import ast
import inspect
import json
import sys
from collections.abc import Iterator
from functools import cache
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel

from actspec.spec.values import HOIST

if TYPE_CHECKING:
    from pydantic import BaseModel


FILES = {
    "spec": "actspec-v1.schema.json",
    "results": "actspec-results-v1.schema.json",
    "network": "actspec-network-v1.schema.json",
    "delta": "actspec-delta-v1.schema.json",
    "log": "actspec-log-v1.schema.json",
}
"""Name to file in `schemas/`."""

DRAFT = "https://json-schema.org/draft/2020-12/schema"

_NAMED = ("properties", "$defs", "patternProperties")
"""Keywords whose keys are names, not keywords."""


def schema(name: str) -> dict[str, Any]:
    """The JSON Schema of one of `FILES`."""
    root = _root(name)
    found = root.model_json_schema(by_alias=True)
    definitions: dict[str, Any] = found.pop("$defs", {})
    by_name = {model.__name__: model for model in (root, *_models(root))}
    _describe(found, root)
    for title, part in definitions.items():
        if title in by_name:
            _describe(part, by_name[title])
    if name == "spec":
        from actspec.spec.models import KINDS, SPEC_VERSION

        found["properties"]["actspec"]["const"] = SPEC_VERSION
        definitions["Target"]["properties"]["target"]["enum"] = list(KINDS)
    hoisted: dict[str, Any] = {}
    found = _tidy(found, hoisted)
    definitions = _tidy({"$defs": definitions}, hoisted)["$defs"]
    return {
        "$schema": DRAFT,
        "$id": FILES[name],
        **found,
        "$defs": {key: {**definitions, **hoisted}[key] for key in sorted({**definitions, **hoisted})},
    }


def schema_text(name: str) -> str:
    """The schema as it stands in `schemas/`."""
    return json.dumps(schema(name), indent=2, ensure_ascii=False) + "\n"


def _root(name: str) -> type[BaseModel]:
    if name == "results":
        from actspec.spec.results import Results

        return Results
    if name == "network":
        from actspec.spec.network import NetworkManifest

        return NetworkManifest
    if name == "delta":
        from actspec.spec.delta import DeltaManifest

        return DeltaManifest
    if name == "log":
        from actspec.spec.sidecar import Sidecar

        return Sidecar
    from actspec.spec.models import SpecModel

    return SpecModel


def _models(root: type[BaseModel]) -> Iterator[type[BaseModel]]:
    """Every model of the language."""
    from actspec.spec.values import Strict

    pending = [Strict]
    while pending:
        model = pending.pop()
        yield model
        pending.extend(model.__subclasses__())


def _describe(part: dict[str, Any], model: type[BaseModel]) -> None:
    """Write the fields' docstrings into a model's schema."""

    texts = descriptions(model)
    for name, field in model.model_fields.items():
        if name in texts:
            part["properties"][field.alias or name]["description"] = " ".join(texts[name].split())


def _tidy(node: Any, hoisted: dict[str, Any], *, names: bool = False) -> Any:
    """Drop what misleads an editor, and write each kind of number once.

    pydantic lets an optional field be null and gives it null as its default; in a spec a field is
    optional by being left out, and an empty value is an error. Its titles repeat the key.
    """
    if isinstance(node, list):
        return [_tidy(item, hoisted) for item in node]
    if not isinstance(node, dict):
        return node
    if names:
        return {key: _tidy(value, hoisted) for key, value in node.items()}
    tidy: dict[str, Any] = {}
    for key, value in node.items():
        if key in ("title", HOIST) or (
            key == "default" and (value is None or isinstance(value, (dict, list)))
        ):
            continue
        if key in ("anyOf", "oneOf"):
            value = [part for part in value if part != {"type": "null"}]
        # Enumerations and constants are data, not schemas.
        tidy[key] = (
            value
            if key in ("enum", "const", "examples", "default")
            else _tidy(value, hoisted, names=key in _NAMED)
        )
    if HOIST in node:
        reference: dict[str, Any] = {"$ref": f"#/$defs/{node[HOIST]}"}
        if "description" in tidy:
            reference["description"] = tidy.pop("description")
        known = hoisted.setdefault(node[HOIST], tidy)
        assert known == tidy
        return reference
    parts = tidy.get("anyOf")
    if parts is not None and len(parts) == 1:
        # An optional field: what it is, with the field's own description.
        del tidy["anyOf"]
        return {**parts[0], **tidy}
    return tidy


def descriptions(model: type[BaseModel]) -> dict[str, str]:
    """Text under each field of a model and of its bases, by the field's name; empty without source."""
    found: dict[str, str] = {}
    for base in reversed(model.__mro__):
        if issubclass(base, BaseModel):
            found.update(_of_module(base.__module__).get(base.__qualname__, {}))
    return found


@cache
def _of_module(name: str) -> dict[str, dict[str, str]]:
    """Class to field to text."""
    module = sys.modules[name]
    try:
        tree = ast.parse(inspect.getsource(module))
    except (OSError, SyntaxError):
        # Installed as bytecode alone.
        return {}
    return {node.name: _of_class(node) for node in tree.body if isinstance(node, ast.ClassDef)}


def _of_class(node: ast.ClassDef) -> dict[str, str]:
    texts = {}
    for field, after in zip(node.body, node.body[1:], strict=False):
        if (
            isinstance(field, ast.AnnAssign)
            and isinstance(field.target, ast.Name)
            and isinstance(after, ast.Expr)
            and isinstance(after.value, ast.Constant)
            and isinstance(after.value.value, str)
        ):
            texts[field.target.id] = inspect.cleandoc(after.value.value)
    return texts
