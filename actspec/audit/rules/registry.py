"""All rules of the audit: one module a rule, named by its code, beside its page."""

from __future__ import annotations

import re
from functools import cache
from importlib import import_module
from pathlib import Path

from actspec.audit.rule import Rule


@cache
def all_rules() -> tuple[type[Rule], ...]:
    """Every rule, by code."""
    names = sorted(
        path.stem for path in Path(__file__).parent.iterdir() if re.fullmatch(r"[a-z]{3}\d{3}\.py", path.name)
    )
    return tuple(_rule_in(name) for name in names)


def _rule_in(name: str) -> type[Rule]:
    """The rule of a module: the class that has its name as code."""
    module = import_module(f"{__package__}.{name}")
    (rule,) = (
        found
        for found in vars(module).values()
        if isinstance(found, type)
        and issubclass(found, Rule)
        and getattr(found, "code", None) == name.upper()
    )
    return rule
