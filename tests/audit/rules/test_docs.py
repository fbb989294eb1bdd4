"""The committed pages of docs/rules are those that the rules give; `actspec rule --docs docs/rules` writes them."""

from __future__ import annotations

from pathlib import Path

from actspec.audit.pages import INDEX, index, page
from actspec.audit.rules.registry import all_rules

PAGES = Path(__file__).resolve().parents[3] / "docs" / "rules"


def test_pages_are_those_of_the_rules() -> None:
    """Every rule has its page, none is left over, and each says what the docstring says."""
    wanted = {f"{rule.code}.md": page(rule) for rule in all_rules()} | {INDEX: index(all_rules())}
    assert {path.name: path.read_text(encoding="utf-8") for path in PAGES.iterdir()} == wanted
