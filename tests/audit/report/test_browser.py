"""The HTML report in a real browser: Debian's Chromium, where it is installed."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from html import unescape
from pathlib import Path
from typing import Any

import pytest

from actspec.report import ReportOptions, render
from tests.audit.report.reporting import report

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium")]

PHONE = 390
"""CSS pixels across, of a common telephone."""

# The report runs no script, so the page around it looks at it.
LOOK = """<!DOCTYPE html><meta charset="utf-8"><body><iframe src="report.html#{target}" width="{width}" height="800"
style="border: 0"></iframe><pre id="said"></pre><script>
addEventListener("load", () => {{
  const frame = document.querySelector("iframe"), page = frame.contentDocument, root = page.documentElement;
  const open = [...page.querySelectorAll("details[open] > summary")].map(one => one.textContent);
  const wide = [...page.querySelectorAll("body > *, article > *, details > *")]
    .filter(one => one.getBoundingClientRect().right > root.clientWidth + 1).map(one => one.outerHTML.slice(0, 80));
  const links = [...page.querySelectorAll("a")].map(one => [one.hash, !!page.querySelector(one.hash)]);
  const letters = [...page.querySelectorAll("svg.plot")].flatMap(one => [...one.querySelectorAll("text")].map(text =>
    parseFloat(getComputedStyle(text).fontSize) * one.getBoundingClientRect().width / one.viewBox.baseVal.width));
  const scrolled = [...page.querySelectorAll("body *")].filter(one => one.scrollWidth > one.clientWidth + 1 &&
    getComputedStyle(one).overflowX !== "visible" && !one.closest("svg")).map(one => one.outerHTML.slice(0, 80));
  document.getElementById("said").textContent = JSON.stringify({{
    least: Math.min(99, ...letters), scrolled,
    open, wide, links, over: root.scrollWidth - root.clientWidth, hit: frame.contentWindow.hit === undefined,
    title: page.title, ground: getComputedStyle(page.body).backgroundColor,
    sticky: getComputedStyle(page.querySelector(".wide td")).position,
  }});
}});
</script>"""


def looked(folder: Path, *options: str, target: str = "", width: int = PHONE) -> dict[str, Any]:
    """What a browser makes of the report in a folder."""
    (folder / "look.html").write_text(LOOK.format(target=target, width=width), encoding="utf-8")
    assert CHROMIUM is not None
    done = subprocess.run(
        [
            CHROMIUM,
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--no-first-run",
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
            "--allow-file-access-from-files",
            f"--user-data-dir={folder / 'profile'}",
            "--virtual-time-budget=2000",
            *options,
            "--dump-dom",
            (folder / "look.html").as_uri(),
        ],
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    said = re.search(r'<pre id="said">(.*?)</pre>', done.stdout, re.DOTALL)
    assert said is not None, done.stdout[-500:] + done.stderr[-500:]
    found: dict[str, Any] = json.loads(unescape(said[1]))
    return found


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a report about files whose names and texts are hostile."""
    monkeypatch.chdir(tmp_path)
    text = render(report(), "html", ReportOptions())
    assert "alert(1)" in text
    (tmp_path / "report.html").write_text(text.replace("alert(1)", "window.hit=1"), encoding="utf-8")
    return tmp_path


def test_a_phone_shows_all_of_it(folder: Path) -> None:
    """Nothing sticks out of the screen, tables scroll by themselves, and no script of a stranger has run."""
    found = looked(folder)
    assert found["title"].startswith("actspec audit: 2 errors, 1 warning, 1 note")
    assert found["wide"] == []
    assert found["over"] == 0
    assert found["sticky"] == "sticky"
    assert found["hit"]
    # Each rule's page is there, folded.
    assert found["links"] and all(there for _, there in found["links"])
    assert "LIM901 first-rule" not in found["open"]


def test_links_lead_to_what_they_name(folder: Path) -> None:
    """Following a link unfolds a rule's page."""
    assert "LIM901 first-rule" in looked(folder, target="rule-LIM901")["open"]


def test_dark_where_the_reader_wants_it(folder: Path) -> None:
    """White on the ground of a light system, near black on a dark one."""
    assert looked(folder, width=1200)["ground"] == "rgb(255, 255, 255)"
    # Blink's number for dark is 0.
    dark = looked(folder, "--blink-settings=preferredColorScheme=0", width=1200)
    assert dark["ground"] == "rgb(13, 17, 23)"
