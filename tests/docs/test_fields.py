"""docs/fields.md is made of the JSON Schema and of the specs on the pages; `--regen` writes it anew."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from typing import Any

import pytest
import yaml

from actspec.spec.schema import schema
from tests.docs.test_docs import BLOCKS, ROOT, _spec_data

PAGE = ROOT / "docs" / "fields.md"

SECTIONS = {
    "Spec": ("The spec", "spec-language.md#the-example"),
    "Robot": ("robot", "spec-language.md#robot"),
    "ListedJoint": ("robot.joints", "spec-language.md#robot"),
    "Timing": ("timing", "spec-language.md#timing"),
    "Source": ("sources.NAME", "spec-language.md#sources"),
    "Motor": ("motors.NAME", "spec-language.md#motors"),
    "Curve": ("motors.NAME.curve", "spec-language.md#motors"),
    "Stage": ("gearbox and transmission", "gears.md"),
    "Planetary": ("planetary, of a stage", "gears.md"),
    "Teeth": ("teeth, of a stage", "gears.md"),
    "Linkage": ("linkages.NAME", "gears.md"),
    "LinkagePose": ("linkages.NAME.table", "gears.md"),
    "Actuators": ("actuators.GROUP", "spec-language.md#actuators"),
    "Friction": ("friction", "spec-language.md#armature-and-friction"),
    "CommandFilter": ("command_filter", "spec-language.md#command-path"),
    "NetworkFile": ("network", "spec-language.md#networks"),
    "Randomize": ("randomize.FIELD", "randomization.md"),
    "DeltaAction": ("delta_action", "delta-action.md"),
    "Target": ("targets.NAME", "spec-language.md#targets"),
}
"""Object of the schema to heading and explaining page; `Tunable`, of `overrides`, is part of `Actuators`."""

FILES = {
    ("Spec", "delta_action"): "{manifest: nets/delta.json}",
    ("DeltaAction", "manifest"): "nets/delta.json",
    ("NetworkFile", "file"): "nets/foot.onnx",
    ("Robot", "packages"): "{a1_description: ../a1_description}",
}
"""What names files that no page has: those of training, and of a vendor."""

HEAD = """# Every field of a spec

Made of the JSON Schema (`actspec schema spec`), with values of specs on these pages and in `robots/`. What follows from
a field is in [spec-language.md](spec-language.md); each heading leads to its place. Of a number, any unit of the kind
will do, or a mapping with its source in its place ([Numbers](spec-language.md#numbers)). `unknown` is a value
where it is listed, and never 0. A field that is left out takes the default that is named; without one it is unknown, or
not there.
"""


@cache
def _schema() -> tuple[dict[str, Any], dict[str, Any]]:
    root = schema("spec")
    return {**root["$defs"], "Spec": root}, root


def _walk(node: dict[str, Any], name: str, data: Any, defs: dict[str, Any]) -> Iterator[tuple[str, str, Any]]:
    """Object, field and value of all fields in data."""
    if "$ref" in node:
        name = node["$ref"].rpartition("/")[2]
        # Kinds of numbers have lower-case names.
        if name[0].isupper():
            yield from _walk(defs[name], name, data, defs)
        return
    for branch in (*node.get("anyOf", ()), *node.get("oneOf", ())):
        yield from _walk(branch, "", data, defs)
    if isinstance(data, list) and "items" in node:
        for item in data:
            yield from _walk(node["items"], "", item, defs)
    if isinstance(data, dict):
        for key, value in data.items():
            part = node.get("properties", {}).get(key)
            if part is not None and name:
                yield ("Actuators" if name == "Tunable" else name), key, value
            other = node.get("additionalProperties")
            below = part if part is not None else other if isinstance(other, dict) else {}
            yield from _walk(below, "", value, defs)


@cache
def _examples() -> dict[tuple[str, str], str]:
    """A short value of each field in the specs of the pages and of the robots."""
    defs, root = _schema()
    blocks = [block for block in BLOCKS if block.language == "yaml" and not block.attributes]
    # What is wrong on purpose comes last.
    shown = [_spec_data(block) for block in sorted(blocks, key=lambda block: "# gives" in block.text)]
    robots = sorted((ROOT / "robots").glob("*.yaml"))
    specs = [*shown, *(yaml.safe_load(path.read_text(encoding="utf-8")) for path in robots)]
    found = dict(FILES)
    for spec in specs:
        for name, field, value in _walk(root, "Spec", spec, defs):
            text = yaml.safe_dump(
                value, default_flow_style=True, width=1000, sort_keys=False, allow_unicode=True
            )
            text = text.removesuffix("...\n").strip()
            old = found.get((name, field))
            # The first that is no word in place of a number, and short.
            better = len(text) <= 60 and text != "unknown"
            if old is None or (better and (len(old) > 60 or old == "unknown")):
                found[name, field] = text
    return found


def _row(name: str, field: str, defs: dict[str, Any], example: str | None) -> str:
    part = defs[name]["properties"][field]
    text = part["description"]
    unit = re.search(r"\[([^\]]*)\]", text.replace("[low, high]", ""))
    text = re.sub(r" \[(?!low)[^\]]*\]", "", text)
    branches = [part, *part.get("anyOf", ()), *part.get("oneOf", ())]
    references = [b["$ref"].rpartition("/")[2] for b in branches if "$ref" in b]
    words = [w for b in branches for w in b.get("enum", ())]
    words += [w for r in references for w in ("unknown", "identified") if re.search(rf"_or_{w}(_|$)", r)]
    below = [
        b[key] for b in branches for key in ("items", "additionalProperties") if isinstance(b.get(key), dict)
    ]
    below = [b.get("$ref", "").rpartition("/")[2] for part in below for b in (part, *part.get("anyOf", ()))]
    sections = [SECTIONS[r][0] for r in (*references, *below) if r in SECTIONS]
    kinds = {"string": "text", "integer": "whole number", "array": "list", "object": "mapping"}
    what = []
    if unit:
        what.append({"-": "1"}.get(unit[1], unit[1]))
    elif not words and not references:
        what += [kinds[b["type"]] for b in branches if isinstance(b.get("type"), str) and b["type"] in kinds]
    what += [f"`{word}`" for word in dict.fromkeys(words)]
    what += [
        f"[fields](#{re.sub(r'[^a-z_ -]', '', heading.lower()).replace(' ', '-')})" for heading in sections
    ]
    required = " **Required.**" if field in defs[name].get("required", ()) else ""
    shown = f"`{example}`" if example and len(example) <= 60 else ""
    return f"| `{field}` | {', '.join(what)} | {shown} | {text}{required} |"


def _page() -> str:
    defs, _ = _schema()
    examples = _examples()
    parts = [HEAD]
    for name, (heading, page) in SECTIONS.items():
        rows = [_row(name, field, defs, examples.get((name, field))) for field in defs[name]["properties"]]
        note = f"{defs[name]['description']} [More]({page})." if name != "Spec" else f"[More]({page})."
        parts.append(
            f"## {heading}\n\n{note}\n\n| field | unit, or words | for example | |\n|---|---|---|---|\n"
            + "\n".join(rows)
            + "\n"
        )
    return "\n".join(parts)


@pytest.mark.slow
def test_the_page_is_the_schema(request: pytest.FixtureRequest) -> None:
    """docs/fields.md has every field; `--regen` writes it anew."""
    if request.config.getoption("--regen"):
        PAGE.write_text(_page(), encoding="utf-8")
    assert PAGE.read_text(encoding="utf-8") == _page()


def test_every_object_has_its_section() -> None:
    """A new object of the language is a section of the page."""
    defs, _ = _schema()
    objects = {name for name, part in defs.items() if "properties" in part and name[0].isupper()}
    assert objects - {"Tunable"} == set(SECTIONS)


@pytest.mark.slow
def test_every_field_is_shown() -> None:
    """Each field stands in a spec of the pages, which is compiled, or of the robots."""
    defs, _ = _schema()
    examples = _examples()
    missing = [
        (name, field)
        for name in SECTIONS
        for field, part in defs[name]["properties"].items()
        if (name, field) not in examples and field != "note" and "enum" not in part
    ]
    assert missing == []
