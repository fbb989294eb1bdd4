"""Markdown and HTML: what a stranger's file says stays text, and what matters is there."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest

from actspec.audit.engine import judge
from actspec.audit.outcome import Report
from actspec.audit.settings import Settings
from actspec.readings.artifact import Robot
from actspec.report import ReportOptions, render
from actspec.report.ledger import cell, comparisons
from actspec.report.markdown import LONGEST
from actspec.report.tables import escaped
from tests.audit.making import case_of, finding, row, rule_of
from tests.audit.report.reporting import report

VOID = {"meta", "br"}


class Page(HTMLParser):
    """Tags and text of a page; an error when tags do not nest."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.open: list[str] = []
        self.ids: set[str] = set()
        self.links: list[str] = []
        self.text = ""
        self.feed(text)
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        for name, value in attrs:
            assert not name.startswith("on")
            assert name not in ("src", "style")
            if name == "id":
                self.ids.add(value or "")
            if name == "href":
                self.links.append(value or "")
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


@pytest.fixture
def made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Report:
    """The report, made in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return report()


def test_html(made: Report) -> None:
    """One whole page: nothing from elsewhere, no script, links only within, every rule with findings explained."""
    text = render(made, "html", ReportOptions())
    page = Page(text)
    assert not {"script", "link", "img", "iframe", "object", "form"} & set(page.tags)
    assert "<script>alert(1)</script>" in page.text  # as words
    assert "url(" not in text
    assert "@import" not in text
    assert "prefers-color-scheme: dark" in text
    assert "default-src 'none'" in text
    assert 'name="viewport"' in text
    # Counts by rule and severity, then the findings.
    rest = ["#rule-SRC901", "#rule-SRC901"]
    assert page.links == ["#rule-AUD008", "#rule-LIM901", *rest, "#rule-LIM901", "#rule-AUD008", *rest]
    assert page.ids == {"rule-LIM901", "rule-SRC901", "rule-AUD008"}
    for words in (
        "hip, ankle, knee: no limit",
        "Help: add one",
        "1.429",
        "not read: there is no such file",
        "öl😀",
    ):
        assert words in page.text


def test_html_says_first_what_matters(made: Report) -> None:
    """Counts and findings come before tables; a rule's page unfolds when its link is followed."""
    text = render(made, "html", ReportOptions())
    heads = re.findall(r"<h2>([^<]*)</h2>", text)
    assert heads == ["Findings", "Joint by file", "Ledger: what acts on each joint", "Files", "Rules"]
    assert text.index("LIM901</a> first-rule</td>") < text.index("<h2>Findings</h2>")
    # Browsers open a fold for a target inside it, not for the fold itself.
    assert re.search(r'<details><summary>LIM901 first-rule</summary>\s*<pre id="rule-LIM901">', text)


def test_html_names_shared_folders_once() -> None:
    """Of paths that are headings only what tells them apart is repeated."""
    files = {"robots/leg/a.xml": b"<a/>", "robots/leg/urdf/b.urdf": b"<a/>"}
    rows = (
        row("robots/leg/a.xml", "hip", armature=1.0),
        row("robots/leg/urdf/b.urdf", "hip", 1, armature=2.0),
    )
    case = replace(case_of(files, *rows), robots=(Robot("leg", (0, 1)),))
    text = render(judge(case, Settings(), ()), "html", ReportOptions())
    assert '<p class="faint">below robots/leg/</p>' in text
    assert '<th class="file">a.xml</th><th class="file">urdf/b.urdf</th>' in text


@pytest.mark.parametrize("count, shown", [(8, True), (9, False)], ids=["few", "many"])
def test_html_folds_many_files_away(count: int, shown: bool) -> None:
    """Eight files are shown, nine are one line until somebody opens it."""
    case = case_of({f"{number}.xml": b"<a/>" for number in range(count)})
    text = render(judge(case, Settings(), ()), "html", ReportOptions())
    assert f"<details{' open' * shown}><summary>{count} files</summary>" in text


def test_html_of_nothing() -> None:
    """A clean report is a page too."""
    assert "no findings" in Page(render(judge(case_of(), Settings(), ()), "html", ReportOptions())).text


def test_markdown(made: Report) -> None:
    """A heading with the counts, a table of faults, the ledger folded away; every row has its cells."""
    text = render(made, "markdown", ReportOptions())
    lines = text.splitlines()
    assert lines[:7] == [
        "### actspec audit: 2 errors, 1 warning, 1 note affecting 3 joints in 3 files, 1 of which could not be read",
        "",
        "|  | rule | place | joints | finding |",
        "| --- | --- | --- | --- | --- |",
        "| error | LIM901<br>first-rule | a.xml:2:22 | hip, ankle, knee | no limit, got 0 N\\*m<br>*add one* |",
        "| error | AUD008<br>unreadable-file | secret.txt:1:1 |  | the file cannot be read: this is not XML "
        "(ROBOT004) |",
        "| warning | SRC901<br>second-rule | b.urdf:2 | hip | 50 here, 35 there |",
    ]
    assert "| effort limit \\[N\\*m\\] | hip | 50 | 35 | 1.429 |" in lines
    assert lines[-5:] == [
        "<details><summary>1 rule did not apply</summary>",
        "",
        "- no network among the files: NET901",
        "",
        "</details>",
    ]
    assert text.count("<details>") == text.count("</details>") == 3
    width = 0
    for line in lines:
        if line.startswith("|"):
            cells = len(re.findall(r"(?<!\\)\|", line))
            assert width in (0, cells)
            width = cells
        else:
            width = 0
    assert "<script>" not in text


@pytest.mark.parametrize(
    "text, written",
    [
        ("a|b", r"a\|b"),
        ("*b* _i_ `c`", r"\*b\* \_i\_ \`c\`"),
        ("[a](http://b)", r"\[a\](http:&#8203;//b)"),
        ("<img>&amp;", "&lt;img&gt;&amp;amp;"),
        ("@team #12 $x$ ~~s~~", r"@&#8203;team #&#8203;12 \$x\$ \~\~s\~\~"),
        ("a\nb", r"a\\nb"),
        ("www.b", "www&#8203;.b"),
    ],
    ids=["cell", "emphasis", "link", "html", "references", "line break", "bare address"],
)
def test_markdown_escapes(text: str, written: str) -> None:
    """Names are shown as they are, notify nobody and link nowhere."""
    assert escaped(text) == written


def test_markdown_fits_into_a_comment() -> None:
    """What does not fit is counted, and the folds are closed."""
    found = [finding("LIM901", line=line, message=f"wrong n{line} {'x' * 200}") for line in range(1, 1001)]
    text = render(
        judge(case_of(), Settings(), (rule_of("LIM901", "first-rule", *found),)), "markdown", ReportOptions()
    )
    assert LONGEST - 600 < len(text) <= LONGEST
    rows = text.count("| warning |")
    # Two lines of heading, then 1000 rows.
    assert f"{1000 - rows} more lines do not fit here." in text


def test_comparison(made: Report) -> None:
    """50 against 35 is 1.429 apart; 50 against 50.1 is rounding; what one file leaves out is not compared."""
    (found,) = comparisons(made.case)
    assert found.sources == ("a.xml", "b.urdf")
    lines = [
        (line.joints, line.field.name, line.values, cell(line.ratio), line.differs) for line in found.lines
    ]
    assert lines == [
        (("hip",), "effort_limit", (50.0, 35.0), "1.429", True),
        (("knee",), "effort_limit", (50.0, 50.1), "1.002", False),
    ]


@pytest.mark.parametrize(
    "first, second, ratio",
    [
        (0.0, 0.05, "inf"),
        (0.0, 0.0, "1"),
        (-1.0, 1.0, "inf"),
        (-2.0, -1.0, "2"),
        (float("inf"), 50.0, "inf"),
        (float("inf"), float("inf"), "1"),
    ],
    ids=["beside zero", "zeros", "signs", "both negative", "no limit", "no limits"],
)
def test_ratio(first: float, second: float, ratio: str) -> None:
    """How far apart two values are; beside 0, and where signs differ, no number says it."""
    files = {"a.xml": b"<a/>", "b.urdf": b"<a/>"}
    rows = (row("a.xml", "hip", armature=first), row("b.urdf", "hip", 1, armature=second))
    case = replace(case_of(files, *rows), robots=(Robot("leg", (0, 1)),))
    assert cell(next(comparisons(case)).lines[0].ratio) == ratio


@pytest.mark.parametrize(
    "value, shown",
    [
        (35.55, "35.55"),
        (9.84375, "9.84375"),
        (1000.0, "1000"),
        (1e6, "1000000"),
        (2 / 3, "0.6667"),
        (None, "-"),
        (float("inf"), "inf"),
        (-0.0, "0"),
    ],
    ids=["written", "six digits", "thousand", "million", "computed", "unknown", "no limit", "zero"],
)
def test_figures(value: float | None, shown: str) -> None:
    """A figure keeps the digits of the file; what is computed has four."""
    assert cell(value) == shown


def test_a_bare_joint_leaves_its_limit_open() -> None:
    """A joint without actuator and limit does not contradict the configuration that limits it; a motor does."""
    files = {"a.xml": b"<a/>", "b.py": b""}
    for control, count in (("none", 0), ("motor", 1)):
        rows = (
            row("a.xml", "hip", effort_limit=float("inf"), control=control),
            row("b.py", "hip", 1, effort_limit=88.0, control="implicit"),
        )
        case = replace(case_of(files, *rows), robots=(Robot("leg", (0, 1)),))
        assert len(list(comparisons(case))) == count


def test_a_bare_joint_states_what_it_states() -> None:
    """A URDF without `dynamics` does not say that there is no friction; one with damping 0 says that there is none."""
    for stated, values in ((frozenset(), None), (frozenset({"joint_damping"}), (0.0, 0.5))):
        rows = (
            row("a.urdf", "hip", control="none", joint_damping=0.0, stated=stated),
            row("b.xml", "hip", 1, joint_damping=0.5, stated=frozenset({"joint_damping"})),
        )
        case = replace(case_of({"a.urdf": b"", "b.xml": b""}, *rows), robots=(Robot("leg", (0, 1)),))
        assert [line.values for found in comparisons(case) for line in found.lines] == (
            [values] if values else []
        )


def test_a_motor_has_no_gains_to_compare() -> None:
    """What an external controller supplies is not 0 in the model: only the files that state gains are compared."""
    rows = (
        row("a.xml", "hip", control="motor", kp=0.0, kd=0.0, armature=0.01),
        row("b.py", "hip", 1, control="ideal_pd", kp=25.0, kd=0.5, armature=0.02),
        row("c.yaml", "hip", 2, control="ideal_pd", kp=20.0, kd=0.5),
    )
    case = replace(
        case_of({"a.xml": b"", "b.py": b"", "c.yaml": b""}, *rows), robots=(Robot("leg", (0, 1, 2)),)
    )
    lines = {line.field.name: line for line in next(comparisons(case)).lines}
    assert lines["kp"].values == (None, 25.0, 20.0)
    assert lines["kp"].ratio == 1.25
    assert lines["armature"].values == (0.01, 0.02, None)
