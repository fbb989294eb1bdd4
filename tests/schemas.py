"""Records for programs held against the committed schemas; tests/cli/test_machine_output.py holds these to theirs."""

from __future__ import annotations

import json
from functools import cache
from typing import Any

from jsonschema import Draft202012Validator

from actspec.resources import data_path


@cache
def validator(name: str) -> Draft202012Validator:
    """That of `schemas/actspec-NAME-v1.schema.json`."""
    return Draft202012Validator(
        json.loads(data_path("schemas", f"actspec-{name}-v1.schema.json").read_text("utf-8"))
    )


def fits(name: str, record: Any) -> None:
    """Fail where a record has not the form of its schema."""
    validator(name).validate(record)
