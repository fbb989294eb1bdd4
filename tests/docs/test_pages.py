"""The pages beside the guide: links, the index, the changelog and the citation agree with the repository."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest
import yaml

import actspec

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).parents[2]
PAGES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md")),
    *(
        page
        for folder in ("docs", "benchmarks", "robots", "actspec")
        for page in sorted((ROOT / folder).rglob("*.md"))
    ),
]


def _slugs(page: Path) -> list[str]:
    titles = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return [re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles]


def _links(page: Path) -> list[str]:
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    links = re.findall(r"\]\(([^)\s]+)\)", text) + re.findall(r'(?:src|href)="([^"]+)"', text)
    return [link for link in links if not re.match(r"[a-z]+:", link)]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    """Every relative link and picture of a page is a file of the repository, every anchor a heading."""
    for link in _links(page):
        path, _, anchor = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        assert target.exists(), link
        assert target.is_relative_to(ROOT), link
        assert not anchor or anchor in _slugs(target), link


def test_the_index_names_every_page() -> None:
    """docs/README.md leads to each page and tutorial, once or more, and to the pages of whoever works on actspec."""
    index = ROOT / "docs" / "README.md"
    named = {(index.parent / link.partition("#")[0]).resolve() for link in _links(index)}
    pages = {page for page in (ROOT / "docs").rglob("*.md") if page != index}
    assert pages <= named, sorted(page.name for page in pages - named)
    elsewhere = ("CONTRIBUTING.md", "CHANGELOG.md", "actspec/audit/rules/README.md", "benchmarks/README.md")
    assert {ROOT / name for name in elsewhere} <= named


def test_citation_and_changelog_have_the_version() -> None:
    """CITATION.cff is the package's own name, version and licence; the changelog has a section of that version."""
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert cited["version"] == actspec.__version__
    assert cited["license"] == project["license"]
    assert [author["name"] for author in cited["authors"]] == [
        author["name"] for author in project["authors"]
    ]
    assert cited["keywords"] == project["keywords"]
    titles = re.findall(r"^## (.*)$", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert titles[0] == "Unreleased"
    assert titles[1] == f"{cited['version']} - {cited['date-released']}"
