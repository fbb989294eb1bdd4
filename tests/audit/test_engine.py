"""The engine: which rules run, and what becomes of what they find."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from actspec.audit.engine import judge
from actspec.audit.finding import Confidence, Skipped
from actspec.audit.outcome import Means
from actspec.audit.selection import guess, selected
from actspec.audit.settings import Settings
from actspec.diagnostics import Severity, Span
from actspec.readings.artifact import FileKind
from tests.audit.making import case_of, finding, rule_of

FIRST = rule_of("LIM901", "first-rule")
SECOND = rule_of("LIM902", "second-rule")
OTHER = rule_of("DMP901", "other-rule")
RULES = (OTHER, FIRST, SECOND)


@pytest.mark.parametrize(
    "select, ignore, codes",
    [
        (("ALL",), (), ["DMP901", "LIM901", "LIM902"]),
        (("LIM",), (), ["LIM901", "LIM902"]),
        (("LIM",), ("LIM902",), ["LIM901"]),
        (("LIM902",), ("LIM",), ["LIM902"]),
        (("second-rule",), ("LIM",), ["LIM902"]),
        (("ALL",), ("ALL",), []),
        (("ALL", "LIM"), ("LIM", "LIM901"), ["DMP901"]),
        (("LIM90",), ("LIM",), ["LIM901", "LIM902"]),
        (("",), (), []),
    ],
    ids=["all", "family", "less one", "one of a family", "name", "tie", "mixed", "longer beginning", "empty"],
)
def test_the_closer_selector_wins(select: tuple[str, ...], ignore: tuple[str, ...], codes: list[str]) -> None:
    """A code goes before its family, a longer beginning before a shorter one, ignore before select in a tie."""
    assert [rule.code for rule in selected(RULES, select, ignore)] == codes


@pytest.mark.parametrize(
    "written, near",
    [
        ("lim901", "LIM901"),
        ("LIN901", "LIM901"),
        ("first_rule", "first-rule"),
        ("lim", "LIM"),
        ("zzzzzzz", None),
    ],
    ids=["case", "letter", "underscore", "family", "nothing near"],
)
def test_the_nearest_selector_is_told(written: str, near: str | None) -> None:
    """A selector that names no rule is answered with the nearest one that does."""
    assert guess(written, RULES) == near


def test_a_file_that_mujoco_refuses_is_told() -> None:
    """What is judged from its text alone is judged in part, and every report says so, once a file."""
    case = case_of({"a.xml": b"<mujoco/>", "b.xml": b"<mujoco/>"})
    # A URDF is no part that others include.
    refused = replace(
        case.files[1].artifacts[0], kind=FileKind.URDF, text_only="line 1: MuJoCo refuses the model"
    )
    case = replace(case, files=(case.files[0], replace(case.files[1], artifacts=(refused, refused))))
    report = judge(case, Settings(), RULES)
    assert [str(item) for item in report.diagnostics()] == [
        "b.xml: AUD013 [warning]: read from its text alone, so what needs its inertia is not judged: "
        "line 1: MuJoCo refuses the model"
    ]
    assert report.complete


@pytest.mark.parametrize("mass", [False, True], ids=["no mass", "mass"])
def test_a_urdf_without_masses_is_no_fault(mass: bool) -> None:
    """It is there for limits and joints: information, not a warning, and without MuJoCo's words."""
    text = (
        b'<robot><link name="a"><inertial><mass value="0"/></inertial></link></robot>'
        if mass
        else b"<robot/>"
    )
    case = case_of({"a.urdf": text})
    refused = replace(case.files[0].artifacts[0], text_only="MuJoCo refuses the model: mass")
    case = replace(case, files=(replace(case.files[0], artifacts=(refused,)),))
    (told,) = judge(case, Settings(), RULES).diagnostics()
    assert (told.code, told.severity, told.message) == (
        (
            "AUD013",
            Severity.WARNING,
            "read from its text alone, so what needs its inertia is not judged: "
            "MuJoCo refuses the model: mass",
        )
        if mass
        else ("AUD013", Severity.INFO, "no link has a mass, so what needs inertia is not judged")
    )


def test_findings_are_in_order_and_have_all_that_reports_need() -> None:
    """Findings come by file, line, code and joint, with the rule's severity and confidence or their own."""
    first = rule_of(
        "LIM901",
        "first-rule",
        finding("LIM901", "b.xml", 1, joint="b"),
        finding("LIM901", "a.xml", 10, joint="b"),
        finding("LIM901", "a.xml", 10, joint="a", severity=Severity.INFO, confidence=Confidence.LOW),
        finding("LIM901", "a.xml", 9),
        severity=Severity.ERROR,
    )
    other = rule_of("DMP901", "other-rule", finding("DMP901", "a.xml", 10, joint="z"))
    found = judge(case_of(), Settings(), (first, other)).findings
    assert [(i.finding.code, i.finding.span.path, i.finding.span.line, i.finding.joint) for i in found] == [
        ("LIM901", "a.xml", 9, ""),
        ("DMP901", "a.xml", 10, "z"),
        ("LIM901", "a.xml", 10, "a"),
        ("LIM901", "a.xml", 10, "b"),
        ("LIM901", "b.xml", 1, "b"),
    ]
    assert [(i.name, i.severity.value, i.confidence.value) for i in found] == [
        ("first-rule", "error", "high"),
        ("other-rule", "warning", "high"),
        ("first-rule", "info", "low"),
        ("first-rule", "error", "high"),
        ("first-rule", "error", "high"),
    ]


def test_the_same_finding_of_two_files_counts_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What g1.xml and a scene that includes it both show is one finding, however the path is written."""
    monkeypatch.chdir(tmp_path)
    rule = rule_of(
        "LIM901",
        "first-rule",
        finding("LIM901", "g1.xml", 4, joint="knee"),
        finding("LIM901", "./g1.xml", 4, joint="knee"),
        finding("LIM901", "g1.xml", 4, joint="hip"),
        finding("LIM901", "g1.xml", 4, joint="knee", message="wrong in another way"),
    )
    found = judge(case_of(), Settings(), (rule,)).findings
    assert [(item.finding.joint, item.finding.message) for item in found] == [
        ("hip", "wrong"),
        ("knee", "wrong"),
        ("knee", "wrong in another way"),
    ]


def test_a_rule_that_breaks_off_is_told_and_the_others_run() -> None:
    """A fault of a rule is one line with its place; what it had found stays, and the report is not complete."""
    bad = rule_of("LIM901", "first-rule", finding("LIM901"), ZeroDivisionError("division by zero"))
    good = rule_of("LIM902", "second-rule", finding("LIM902"))
    report = judge(case_of(), Settings(), (bad, good))
    assert [item.finding.code for item in report.findings] == ["LIM901", "LIM902"]
    (problem,) = report.problems
    assert (problem.code, problem.severity, problem.where) == ("AUD009", Severity.ERROR, "LIM901")
    assert problem.message.startswith(
        "the rule broke off, which is a fault of actspec: ZeroDivisionError: division by zero (making.py, line "
    )
    assert not report.complete
    assert judge(case_of(), Settings(), (good,)).complete


def test_a_rule_speaks_for_itself_only() -> None:
    """A finding under another rule's code is a fault of the rule, not a crash of the report."""
    report = judge(case_of(), Settings(), (rule_of("LIM901", "first-rule", finding("DMP901")),))
    assert not report.findings
    assert "ValueError: speaks for DMP901" in report.problems[0].message


def test_skipped_rules_say_why_once() -> None:
    """Equal reasons of one rule are one."""
    rule = rule_of("LIM901", "first-rule", *[Skipped("LIM901", "no cfg")] * 2, Skipped("LIM901", "no URDF"))
    assert [item.reason for item in judge(case_of(), Settings(), (rule,)).skipped] == ["no cfg", "no URDF"]


def test_severity_of_the_settings_wins() -> None:
    """The closest selector decides, over the rule's and the finding's own severity."""
    first = rule_of("LIM901", "first-rule", finding("LIM901", severity=Severity.INFO))
    second = rule_of("LIM902", "second-rule", finding("LIM902"))
    settings = Settings(
        severity={"LIM": Severity.INFO, "first-rule": Severity.ERROR, "ALL": Severity.WARNING}
    )
    found = judge(case_of(), settings, (first, second)).findings
    assert [item.severity for item in found] == [Severity.ERROR, Severity.INFO]


def test_what_an_old_file_alone_speaks_against() -> None:
    """A finding is a note where nobody runs any of the other files that it leans on."""
    case = case_of(dict.fromkeys(("a.xml", "b.xml", "old.xml"), b"<mujoco/>"))
    case = replace(case, files=(*case.files[:2], replace(case.files[2], in_folder=True, put_aside=True)))
    old, run = Span("old.xml", 1), Span("b.xml", 1)
    leaning = [
        finding("LIM901", line=n, related=related) for n, related in enumerate(((old,), (old, run), ()), 1)
    ]
    found = judge(case, Settings(), (rule_of("LIM901", "first-rule", *leaning),)).findings
    assert [item.severity for item in found] == [Severity.INFO, Severity.WARNING, Severity.WARNING]


@pytest.mark.parametrize(
    "least, codes",
    [
        (Severity.INFO, ["LIM901", "LIM902"]),
        (Severity.WARNING, ["LIM902"]),
        (Severity.ERROR, []),
        (None, []),
    ],
    ids=["info", "warning", "error", "never"],
)
def test_findings_that_fail_the_run(least: Severity | None, codes: list[str]) -> None:
    """`fail-on` counts findings of its severity and worse."""
    first = rule_of("LIM901", "first-rule", finding("LIM901"), severity=Severity.INFO)
    second = rule_of("LIM902", "second-rule", finding("LIM902"), severity=Severity.WARNING)
    report = judge(case_of(), Settings(), (first, second))
    assert [item.finding.code for item in report.at_or_above(least)] == codes


def test_unsure_findings_are_set_aside() -> None:
    """`min-confidence` leaves out what is less sure, and counts it."""
    rule = rule_of(
        "LIM901",
        "first-rule",
        finding("LIM901", line=1, confidence=Confidence.LOW),
        finding("LIM901", line=2, confidence=Confidence.MEDIUM),
    )
    report = judge(case_of(), Settings(min_confidence=Confidence.MEDIUM), (rule,))
    assert [item.finding.span.line for item in report.findings] == [2]
    assert [(item.means, item.reported.finding.span.line) for item in report.suppressed] == [
        (Means.CONFIDENCE, 1)
    ]


@pytest.mark.parametrize(
    "glob, path, there",
    [
        ("*.xml", "vendor/deep/a.xml", False),
        ("vendor/**", "vendor/deep/a.xml", False),
        ("vendor/*", "vendor/deep/a.xml", True),
        ("**/a.xml", "a.xml", False),
        ("vendor/?.xml", "vendor/a.xml", False),
        ("a.xm", "a.xml", True),
        ("vendor/a+b.xml", "vendor/a+b.xml", False),
        ("vendor/a.b", "vendor/axb", True),
        ("a/**/c/*.xml", "a/c/x.xml", False),
        ("a/**/c/*.xml", "a/b/b/c/x.xml", False),
        ("a/**/c/*.xml", "a/bc/x.xml", True),
        ("a?b", "a/b", True),
        ("*a" * 40 + "b", "a" * 200, True),
        ("**/*a" * 20 + "b", "a/" * 100 + "a" * 99, True),
    ],
    ids=[
        *("name", "below", "one folder", "any folder", "one letter", "whole name", "plus", "dot"),
        *("no folder between", "folders between", "a folder's whole name", "no slash for a letter"),
        *("stars that would hang", "folders that would hang"),
    ],
)
def test_per_file_ignores(
    glob: str, path: str, there: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A glob without a slash is held against the name, one with a slash against the path below the settings."""
    monkeypatch.chdir(tmp_path)
    rule = rule_of("LIM901", "first-rule", finding("LIM901", f"work/{path}"))
    settings = Settings(per_file_ignores=((glob, ("LIM",)),), folder="work")
    report = judge(case_of(), settings, (rule,))
    assert bool(report.findings) == there
    assert [item.means for item in report.suppressed] == [] if there else [Means.SETTING]
    other = judge(case_of(), Settings(per_file_ignores=((glob, ("DMP",)),), folder="work"), (rule,))
    assert other.findings
