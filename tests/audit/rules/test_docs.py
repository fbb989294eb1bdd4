"""Pages say of their rules what the attributes say; `actspec rule --docs actspec/audit/rules` makes them."""

from __future__ import annotations

from pathlib import Path

from actspec.audit.pages import INDEX, index, page
from actspec.audit.rules import all_rules

PAGES = Path(__file__).resolve().parents[3] / "actspec" / "audit" / "rules"


def test_pages_are_those_of_the_rules() -> None:
    """Every rule has its page beside it, none is left over, and the index has all."""
    wanted = {f"{rule.code.lower()}.md": page(rule) for rule in all_rules()} | {INDEX: index(all_rules())}
    assert {path.name: path.read_text(encoding="utf-8") for path in PAGES.glob("*.md")} == wanted
