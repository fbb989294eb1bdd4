"""Read layers with the real USD, and say what is in them.

A script for the frameworks' environment: it knows nothing of actspec or of the tests.

    python usda_probe.py in.json in.npz out.json out.npz
"""

from __future__ import annotations

import json
import sys
from typing import Any

import numpy as np
from pxr import Sdf


def main(job_in: str, job_out: str, arrays_out: str) -> None:
    """Read every layer of the input."""
    with open(job_in, encoding="utf-8") as file:
        texts = json.load(file)
    with open(job_out, "w", encoding="utf-8") as file:
        json.dump({name: layer(text) for name, text in texts.items()}, file)
    np.savez(arrays_out)


def layer(text: str) -> dict[str, Any] | None:
    """Prims by their paths; None where USD refuses the text."""
    made = Sdf.Layer.CreateAnonymous(".usda")
    try:
        if not made.ImportFromString(text):
            return None
    except Exception:
        return None
    found: dict[str, Any] = {}
    for prim in made.rootPrims:
        visit(prim, found)
    return found


def visit(prim: Any, found: dict[str, Any]) -> None:
    """One prim and those below it, in the layer's order."""
    apis = prim.GetInfo("apiSchemas").ApplyOperations([]) if prim.HasInfo("apiSchemas") else []
    values = {a.name: [str(a.typeName), plain(a.default)] for a in prim.attributes}
    for relationship in prim.relationships:
        edits = relationship.targetPathList
        # Explicit ones, or what the edits add where there is none.
        paths = list(edits.explicitItems) if edits.isExplicit else []
        paths += [p for p in edits.addedItems if p not in paths]
        paths = [*edits.prependedItems, *(p for p in paths if p not in edits.prependedItems)]
        paths = [*(p for p in paths if p not in edits.appendedItems), *edits.appendedItems]
        values[relationship.name] = ["rel", [str(path) for path in paths]]
    found[str(prim.path)] = {
        "specifier": {Sdf.SpecifierDef: "def", Sdf.SpecifierOver: "over"}.get(prim.specifier, "class"),
        "type": prim.typeName,
        "active": prim.active,
        "apis": list(apis),
        "values": values,
    }
    for child in prim.nameChildren:
        visit(child, found)


def plain(value: Any) -> Any:
    """A value as JSON has it."""
    if isinstance(value, Sdf.AssetPath):
        return {"asset": value.path}
    if value is None or isinstance(value, Sdf.ValueBlock):
        return None
    if isinstance(value, bool | int | float | str):
        return value
    return [plain(item) for item in value]


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[3], sys.argv[4])
