"""JSON Schemas of the files that people write, for editors; generated from the models."""

from __future__ import annotations

import json
from typing import Any

FILES = {
    "spec": "actspec-v1.schema.json",
    "results": "actspec-results-v1.schema.json",
    "network": "actspec-network-v1.schema.json",
}
"""Name to file in `schemas/`."""

DRAFT = "https://json-schema.org/draft/2020-12/schema"


def schema(name: str) -> dict[str, Any]:
    """The JSON Schema of `spec`, `results` or `network`."""
    from pydantic import BaseModel

    from actspec.spec.models import SpecModel
    from actspec.spec.network import NetworkManifest
    from actspec.spec.results import Results

    models: dict[str, type[BaseModel]] = {"spec": SpecModel, "results": Results, "network": NetworkManifest}
    found = models[name].model_json_schema(by_alias=True)
    return {"$schema": DRAFT, "$id": FILES[name], **found}


def schema_text(name: str) -> str:
    """The schema as it stands in `schemas/`."""
    return json.dumps(schema(name), indent=2, ensure_ascii=False) + "\n"
