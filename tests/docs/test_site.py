"""The site that Zensical makes of the pages: built without a warning, whole, and nothing in it is fetched."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from html import unescape
from pathlib import Path
from urllib.parse import unquote

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
def test_the_site_is_whole(tmp_path: Path) -> None:
    """`docs/build` takes every page, the menu leads to each, and every link and picture is there."""
    pytest.importorskip("zensical", reason="Zensical needs Python 3.11")
    done = subprocess.run(
        [ROOT / "docs" / "build", tmp_path],
        env={**os.environ, "ACTSPEC_VENV": sys.prefix},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr

    site = tmp_path / "build" / "site"
    pages = {
        page: page.read_text(encoding="utf-8") for page in site.rglob("*.html") if page.name != "404.html"
    }
    assert len(pages) > 100
    targets = {page: _targets(text) for page, text in pages.items()}
    anchors = {page: set(re.findall(r'\bid="?([^"\s>]+)', text)) for page, text in pages.items()}
    lost = [
        f"{page.relative_to(site)}: {link}"
        for page, links in targets.items()
        for link in links
        if not re.match(r"[a-z]+:", link) and not _there(page, link, anchors)
    ]
    assert lost == []
    menu = {(site / link.partition("#")[0]).resolve() for link in targets[site / "index.html"]}
    assert [str(page.relative_to(site)) for page in sorted(pages) if page not in menu] == [], (
        "not in mkdocs.yml"
    )
    for page, text in pages.items():
        assert not re.search(r'<(?:script|img|source|iframe)[^>]*src="?(?:[a-z]+:)?//', text), page
        assert not re.search(r'<link[^>]*rel="?(?!canonical)[^>]*href="?(?:[a-z]+:)?//', text), page
        # A fence that Zensical does not understand stays as it is, and takes headings behind it with it.
        assert "```" not in re.sub(r"<(pre|code|title)\b.*?</\1>", "", text, flags=re.DOTALL), page


def _targets(text: str) -> list[str]:
    found = re.findall(r'\s(?:href|src)=(?:"([^"]*)"|([^\s>]+))', text)
    return [unescape(quoted or bare) for quoted, bare in found]


def _there(page: Path, link: str, anchors: dict[Path, set[str]]) -> bool:
    path, _, anchor = unquote(link).partition("#")
    target = (page.parent / path).resolve() if path else page
    if target.is_dir():
        target /= "index.html"
    return target.is_file() and (not anchor or target not in anchors or anchor in anchors[target])
