"""Text: concise, full, the ledger and the counts, to the letter."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from actspec.audit.engine import audit, judge
from actspec.audit.finding import Confidence
from actspec.audit.outcome import Report, Reported
from actspec.audit.settings import Settings
from actspec.diagnostics import Diagnostic, Severity, Span
from actspec.ir import JointKind
from actspec.readings.artifact import FileKind
from actspec.report import FORMATS, ReportOptions, least_shown, render
from actspec.report.findings import for_people
from actspec.report.ledger import ledger_lines
from actspec.report.sources import WIDEST, Sources
from actspec.report.tables import Style
from actspec.report.text import counted, remarks
from tests.audit.making import case_of, finding, reading, row, rule_of
from tests.audit.report.reporting import report

SUMMARY = (
    "2 errors, 1 warning, 1 note affecting 3 joints in 3 files, 1 of which could not be read; "
    "nothing to audit at 1 path\n"
)
BAD = "<script>alert(1)</script>|\"'&\\x07\\n[a](b)@me #1 %41,:\\ud800"
"""The hostile name as text shows it: on one line, without control characters."""

CONCISE = f"""a.xml:2:22: LIM901 [error] hip, ankle and 1 more: no limit, got 0 N*m
secret.txt:1:1: AUD008 [error] the file cannot be read: this is not XML (ROBOT004)
b.urdf:2: SRC901 [warning] hip: 50 here, 35 there
we ird%.xml: SRC901 [info] bad {BAD}
{SUMMARY}"""

FULL = f"""a.xml:2:22: LIM901 [error] hip, ankle and 1 more: no limit, got 0 N*m
    |
  2 |  <joint name="öl😀"/> <motor joint="hip"/>
    |                       ^
  = joints: hip, ankle, knee
  = also on line 3
  = help: add one
  = fix: Set forcerange (--unsafe-fixes)
  = rule: first-rule, high confidence; `actspec rule LIM901`

secret.txt:1:1: AUD008 [error] the file cannot be read: this is not XML (ROBOT004)
  = rule: unreadable-file, high confidence; `actspec rule AUD008`

b.urdf:2: SRC901 [warning] hip: 50 here, 35 there
    |
  2 | <joint name="hip"/>
  = see a.xml:3:3
    |
  3 |   <motor joint="knee"/>
    |   ^
  = rule: second-rule, medium confidence; `actspec rule SRC901`

we ird%.xml: SRC901 [info] bad {BAD}
  = rule: second-rule, medium confidence; `actspec rule SRC901`

{SUMMARY}"""

LEDGER = f"""a.xml (leg)
  joints     control       kp  effort
                                limit
                      N*m/rad     N*m
  hip, knee  motor         50      50
  ankle      motor         20     inf
  0 for all: armature

a.xml (leg), slide joints
  joints  control     kp
                     N/m
  rail    motor    10000
  0 for all: armature

b.urdf (leg)
  joints{" " * (len(BAD) - 6)}  control  effort  velocity
        {" " * (len(BAD) - 6)}            limit     limit
        {" " * (len(BAD) - 6)}              N*m     rad/s
  hip   {" " * (len(BAD) - 6)}  none         35         -
  knee  {" " * (len(BAD) - 6)}  none       50.1         -
  {BAD}  none          -        21

leg: where the files disagree
  [1] a.xml
  [2] b.urdf
  field               joints  [1]  [2]  ratio
  effort limit [N*m]  hip      50   35  1.429

"""

MARKED = """a.xml (leg)
  joints  control         kd      joint      total
                                damping    damping
                   N*m*s/rad  N*m*s/rad  N*m*s/rad
  a       motor       0.5 ce       2 ui        2.5
  b       motor       0.5 ci       0           2.5
  c       motor       0.5 c    10.25           2.5
  damping: c clamped by the effort limit, u not clamped by the effort limit, i integrated implicitly, \
e integrated explicitly"""

STATISTICS = """1  AUD008  unreadable-file  error
1  LIM901  first-rule       error
1  SRC901  second-rule      warning
1  SRC901  second-rule      info
"""


@pytest.fixture
def made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Report:
    """The report, made in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return report()


def test_concise(made: Report) -> None:
    """One line a fault, whose joints stand together."""
    assert render(made, "concise", ReportOptions()) == CONCISE


@pytest.mark.parametrize(
    ("least", "shown", "line", "count"),
    [
        (Severity.INFO, ["LIM901", "AUD008", "SRC901", "SRC901"], None, "2 errors, 1 warning, 1 note"),
        (
            Severity.WARNING,
            ["LIM901", "AUD008", "SRC901"],
            "1 note (SRC901): --notes shows it",
            "2 errors, 1 warning",
        ),
        (
            Severity.ERROR,
            ["LIM901", "AUD008"],
            "1 warning (SRC901), 1 note (SRC901): --notes shows them",
            "2 errors",
        ),
    ],
    ids=["info", "warning", "error"],
)
def test_what_is_not_shown_is_counted(
    least: Severity, shown: list[str], line: str | None, count: str, made: Report
) -> None:
    """The worst come first; what is below the least severity is one line; the last line counts what is shown."""
    lines = render(made, "concise", ReportOptions(least=least)).splitlines()
    assert [text.split(": ")[1][:6] for text in lines[: len(shown)]] == shown
    assert lines[len(shown) : -1] == ([line] if line else [])
    assert (
        lines[-1]
        == f"{count} affecting 3 joints in 3 files, 1 of which could not be read; nothing to audit at 1 path"
    )


def test_only_notes() -> None:
    """Nothing to mend is not the same as nothing found."""
    rule = rule_of("LIM901", "first-rule", finding("LIM901"), severity=Severity.INFO)
    report = judge(case_of({"a.xml": b""}), Settings(), (rule,))
    assert render(report, "full", ReportOptions(least=Severity.WARNING)) == (
        "1 note (LIM901): --notes shows it\nno errors or warnings in 1 file\n"
    )


@pytest.mark.parametrize(
    ("severity", "least", "expected"),
    [
        (Severity.WARNING, Severity.WARNING, "1 warning in 1 file; 3 warnings about files\n"),
        (
            Severity.INFO,
            Severity.WARNING,
            "1 note (LIM901): --notes shows it\nno errors in 1 file; 3 warnings about files\n",
        ),
        (
            Severity.WARNING,
            Severity.ERROR,
            "4 warnings (STALE, LIM901, MIMIC): --notes shows them\nno errors or warnings in 1 file\n",
        ),
    ],
)
def test_warnings_about_files_are_counted_as_they_are_shown(
    severity: Severity, least: Severity, expected: str
) -> None:
    """Beside findings and alone, the same of two joints once; those that are shown are none of those left out."""
    about = finding("LIM901").span
    same = [Diagnostic("MIMIC", Severity.WARNING, "follows nothing", joint, about) for joint in ("a", "b")]
    others = [Diagnostic("STALE", Severity.WARNING, text, "", Span("x.json")) for text in ("one", "two")]
    rule = rule_of("LIM901", "first-rule", finding("LIM901"), severity=severity)
    made = replace(judge(case_of({"a.xml": b""}), Settings(), (rule,)), problems=(*same, *others))
    text = render(made, "concise", ReportOptions(least=least))
    assert text.endswith(f"\n{expected}") or text == expected
    assert len(list(remarks(made, least))) == (3 if least is Severity.WARNING else 0)


@pytest.mark.parametrize(
    ("output_format", "asked", "fail_on", "least"),
    [
        ("full", None, Severity.ERROR, Severity.WARNING),
        ("concise", None, None, Severity.WARNING),
        ("github", None, Severity.ERROR, Severity.WARNING),
        ("junit", None, Severity.ERROR, Severity.WARNING),
        ("markdown", None, Severity.ERROR, Severity.WARNING),
        ("json", None, Severity.ERROR, Severity.INFO),
        ("sarif", None, Severity.ERROR, Severity.INFO),
        ("html", None, None, Severity.INFO),
        ("full", Severity.INFO, Severity.ERROR, Severity.INFO),
        ("json", Severity.ERROR, Severity.ERROR, Severity.ERROR),
        # Whatever makes the run fail is shown.
        ("full", None, Severity.INFO, Severity.INFO),
        ("full", Severity.ERROR, Severity.WARNING, Severity.WARNING),
        ("full", Severity.ERROR, None, Severity.ERROR),
    ],
)
def test_least_shown(
    output_format: str, asked: Severity | None, fail_on: Severity | None, least: Severity
) -> None:
    """People see warnings, programs all; an option goes before both, and --fail-on before that."""
    assert least_shown(output_format, asked, fail_on) is least


def test_rules_without_input_are_told_to_whom_asked_for_them(made: Report) -> None:
    """Of all rules most have nothing to judge in every run."""
    text = "NET901 did not apply: no network among the files\n"
    assert text not in render(made, "concise", ReportOptions())
    assert text in render(made, "concise", ReportOptions(chosen=True))


@pytest.mark.parametrize(("files", "lines"), [(3, 3), (4, 1)])
def test_remarks_of_many_files_are_summed_up(files: int, lines: int) -> None:
    """The first with its reason, and which others there are; with notes each by itself."""
    case = case_of({f"{number}.xml": b"" for number in range(files)})
    # A URDF is no part that others include.
    refused = [
        replace(item, artifacts=(replace(item.artifacts[0], text_only=f"line {number}", kind=FileKind.URDF),))
        for number, item in enumerate(case.files)
    ]
    made = judge(replace(case, files=tuple(refused)), Settings(), ())
    found = [str(item) for item in remarks(made, Severity.WARNING)]
    assert len(found) == lines
    start = (
        "0.xml: AUD013 [warning]: read from its text alone, so what needs its inertia is not judged: line 0"
    )
    rest = " (3 more of AUD013 in 1.xml, 2.xml, 3.xml: --notes shows them)"
    assert found[0] == start + rest * (lines == 1)
    assert len(list(remarks(made, Severity.INFO))) == files


def test_full(made: Report) -> None:
    """The line with a caret, the other places, help, fix and rule; 😀 is two columns wide."""
    assert render(made, "full", ReportOptions()) == FULL


def test_ledger(made: Report) -> None:
    """Columns with figures, units in the heading, equal joints in one line, slides apart; 50 and 50.1 agree."""
    assert render(made, "concise", ReportOptions(ledger=True)) == LEDGER + CONCISE


def test_ledger_marks_each_part_of_the_damping() -> None:
    """Clamped and implicit, each yes, no or unknown; a part that is 0 and a total have no mark."""
    damped = partial(row, "a.xml", kind=JointKind.HINGE, kd=0.5, kd_clamped=True, total_damping=2.5)
    passive = partial(damped, joint_damping_clamped=False, joint_damping_implicit=True)
    rows = (
        passive("a", kd_implicit=False, joint_damping=2.0),
        passive("b", kd_implicit=True, joint_damping=0.0),
        damped("c", joint_damping=10.25),
    )
    lines = ledger_lines(case_of({"a.xml": b""}, *rows), Style(colour=False))
    assert "\n".join(lines) == MARKED


def test_the_ledger_says_what_bounds_a_servo(tmp_path: Path) -> None:
    """500 N*m/rad x 3 rad are 1500 N*m; not where a range limits it, or two drives share the joint.

    2 + 1 = 3 rad: the command at one end of its range, the joint at the other.
    """
    joint = '<body><joint name="{0}" range="-1 2"/><geom size="0.1"/></body>'
    servo = '<position joint="{0}" kp="500" ctrlrange="-1 2"{1}/>'
    servos = [("a", ""), ("b", ' forcerange="-3 3"'), ("c", ""), ("c", "")]
    path = tmp_path / "arm.xml"
    path.write_text(
        f'<mujoco><compiler angle="radian"/><worldbody>{"".join(map(joint.format, "abc"))}</worldbody>'
        f"<actuator>{''.join(servo.format(*one) for one in servos)}</actuator></mujoco>"
    )
    case = audit([str(path)], Settings()).case
    lines = list(ledger_lines(case, Style(colour=False)))
    shown = [line.split("position")[1].split()[1:3] for line in lines if "position" in line]
    # A limit has no mark: behind it stands the inertia.
    assert [cells[:1] if cells[1] != "b" else cells for cells in shown] == [["1500", "b"], ["3"], ["inf"]]
    assert "  effort limit: b none, bounded by the clamped command (LIM101)" in lines


def test_findings_of_a_whole_file_affect_joints() -> None:
    """Two joints by name, one of them again among the two of a finding of the file, and one beside the other: four."""
    found = [
        Reported(each, "rule", Severity.INFO, Confidence.HIGH)
        for each in (
            *(finding("LIM901", joint=joint) for joint in ("hip", "knee")),
            finding("FRC901", line=2, joints=("knee", "toe")),
            finding("ORD901", line=3, joint="hip", joints=("hip", "ankle")),
        )
    ]
    assert counted(for_people(found)) == "3 notes affecting 4 joints"


def test_a_finding_at_one_joint_for_its_limb_affects_all_of_them(tmp_path: Path) -> None:
    """An arm of three joints under another name in the other file is one finding, at the first."""
    for file, side in (("a", "right"), ("b", "rigth")):
        text = '<robot name="arms"><link name="base"/>'
        for limb in ("left", side):
            for n in (1, 2, 3):
                parent = f"{limb}{n - 1}" if n > 1 else "base"
                text += (
                    f'<link name="{limb}{n}"/><joint name="{limb}_arm_j{n}" type="revolute"><parent link="{parent}"/>'
                    f'<child link="{limb}{n}"/><axis xyz="0 1 0"/>'
                    f'<limit lower="-{n}" upper="{n}" effort="9" velocity="3"/></joint>\n'
                )
        (tmp_path / f"{file}.urdf").write_text(f"{text}</robot>", encoding="utf-8")
    report = audit([str(path) for path in sorted(tmp_path.iterdir())], Settings(select=("ORD106",)))
    assert counted(for_people(report.findings)) == "1 warning affecting 3 joints"


@pytest.mark.parametrize(
    ("names", "text"),
    [
        (("joint[1-6]",), "1 pattern of joints"),
        (("hip", "arm_.*", r"leg\.x"), "1 joint and 2 patterns of joints"),
        (("a/b.c-d:e 1_2",), "1 joint"),
    ],
)
def test_joints_that_nobody_names_are_not_counted(names: tuple[str, ...], text: str) -> None:
    """A configuration's pattern may be six joints."""
    found = [
        Reported(finding("LIM901", joint=name), "rule", Severity.ERROR, Confidence.HIGH) for name in names
    ]
    assert counted(for_people(found)).partition(" affecting ")[2] == text


def test_statistics(made: Report) -> None:
    """Counts in place of findings."""
    assert render(made, "full", ReportOptions(statistics=True)) == STATISTICS + SUMMARY


def test_colour_changes_nothing_but_colour(made: Report) -> None:
    """Without its escapes the coloured text is the plain one."""
    import re

    coloured = render(made, "full", ReportOptions(colour=True, ledger=True))
    assert "\x1b[31mLIM901\x1b[0m" in coloured
    assert re.sub(r"\x1b\[\d+m", "", coloured) == render(made, "full", ReportOptions(ledger=True))


def test_files_that_were_not_read_are_not_shown(made: Report) -> None:
    """No format shows a line of a file that is no model."""
    sources = Sources(made.case.files)
    assert sources.line(Span("secret.txt", 1, 1)) is None
    assert list(sources.excerpt(Span("secret.txt", 1, 1))) == []
    for name in FORMATS:
        assert "password" not in render(made, name, ReportOptions(ledger=name == "full"))


@pytest.mark.parametrize(
    "column, shown, caret",
    [
        (1, "a" * WIDEST + "...", 0),
        # The window begins half its width before the place.
        (201, "..." + "a" * 70 + "b" + "a" * 69 + "...", 73),
        (400, "..." + "a" * WIDEST, 142),
        (9999, "..." + "a" * WIDEST, None),
    ],
    ids=["start", "middle", "end", "behind"],
)
def test_long_lines_are_cut_around_the_place(column: int, shown: str, caret: int | None) -> None:
    """A line of 400 characters is shown where the place is."""
    text = "a" * 200 + "b" + "a" * 199
    lines = list(Sources([reading("a.xml", text.encode())]).excerpt(Span("a.xml", 1, column)))
    assert lines[1] == f"1 | {shown}"
    assert (lines[2] if len(lines) > 2 else None) == (None if caret is None else f"  | {' ' * caret}^")


@pytest.mark.parametrize("line", [0, 3, 99], ids=["whole file", "behind the end", "far"])
def test_places_without_a_line(line: int) -> None:
    """A place that is not in the text has no excerpt."""
    assert list(Sources([reading("a.xml", b"a\r\nb")]).excerpt(Span("a.xml", line, 1))) == []
