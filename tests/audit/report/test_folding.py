"""What the reports for people leave out: the same said again with other figures, and why rules are silent."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import pytest

from actspec.audit.engine import judge
from actspec.audit.finding import Finding, Skipped
from actspec.audit.outcome import Report
from actspec.audit.rule import Rule
from actspec.audit.settings import Settings
from actspec.diagnostics import Severity, Span
from actspec.report import ReportOptions, render
from actspec.report.findings import MOST_ALIKE, FindingGroup, for_people
from actspec.report.text import MOST_REASONS
from tests.audit.making import case_of, finding, rule_of


def _report(*found: Finding | Skipped) -> Report:
    rules: dict[str, list[Finding | Skipped]] = {}
    for item in found:
        rules.setdefault(item.code, []).append(item)
    made: tuple[type[Rule], ...] = tuple(
        rule_of(code, f"rule-{code.lower()}", *items) for code, items in rules.items()
    )
    return judge(case_of(), Settings(), made)


def _groups(*found: Finding | Skipped) -> tuple[FindingGroup, ...]:
    return for_people(_report(*found).findings)


def _one(line: int, message: str, joint: str = "", **fields: Any) -> Finding:
    return finding("LIM901", line=line, joint=joint, message=message, **fields)


def test_the_worst_stands_for_those_that_differ_in_figures() -> None:
    """Four joints at 3, 9, -12 and 4.5 N*m: the one that is farthest off, by size, is shown where it stands."""
    (group,) = _groups(
        _one(1, "gets 3 N*m", "a", value=3.0),
        _one(2, "gets 9 N*m", "b", value=9.0),
        _one(3, "gets -12 N*m", "c", value=-12.0),
        _one(4, "gets 4.5 N*m", "d", value=4.5),
    )
    assert group.headline() == "c: gets -12 N*m (similar: a, b and 1 more)"
    assert group.first.finding.span.line == 3


def test_the_worst_is_by_ratio_where_it_is_known_what_is_right() -> None:
    """1 instead of 10 is farther off than 300 instead of 200."""
    figures = ((300.0, 200.0), (1.0, 10.0), (11.0, 10.0), (21.0, 20.0))
    (group,) = _groups(
        *(_one(i, f"is {a:g}, not {b:g}", f"j{i}", value=a, expected=b) for i, (a, b) in enumerate(figures))
    )
    assert group.joints == ("j1",)


def test_of_limits_the_least_is_the_worst() -> None:
    """Nobody knows what is right: 2 N*m are fewer than 6. An effort of 1e9 that nobody filled in is worse than both."""
    limits = (6.0, 2.0, 3.0)
    for more, worst in ((), "j1"), ((1e9,), "j3"):
        (group,) = _groups(
            *(
                _one(i, f"gets {limit:g} N*m", f"j{i}", value=limit, fields=("effort_limit",))
                for i, limit in enumerate((*limits, *more))
            )
        )
        assert group.joints == (worst,)


def test_one_figure_that_several_robots_share_is_one_finding() -> None:
    """A base class's limit of 87 N*m for a UR3 and a UR10: 87/12 is worse than 87/56. On another line it is another."""
    told = [
        ("ur3", 12.0, 4, "arm"),
        ("ur10", 56.0, 4, "arm"),
        ("z1", 30.0, 9, "arm"),
        ("ur5", 28.0, 4, "hand"),
    ]
    shown = _groups(
        *(
            _one(
                line,
                f"87 N*m where {robot} has {right:g}",
                joint,
                value=87.0,
                expected=right,
                fields=("effort_limit",),
            )
            for robot, right, line, joint in told
        )
    )
    assert [group.headline() for group in shown] == [
        "arm: 87 N*m where ur3 has 12 (similar: hand)",
        "arm: 87 N*m where z1 has 30",
    ]
    assert _groups(*(_one(4, f"of {name}", "arm", value=9.0, expected=3.0) for name in "ab"))[
        0
    ].headline() == ("arm: of a (similar: 1 more)")


def test_what_several_files_have_is_reported_once() -> None:
    """It stands at the first; each of the files has to be mended, and is named. Notes are one whatever their joints."""
    same = [_one(1, "no mass", joint, path=f"{joint}.xml") for joint in "abcd"]
    (group,) = for_people(_report(*(replace(item, severity=Severity.INFO) for item in same)).findings)
    assert group.headline() == "a: no mass (the same for other joints in b.xml, c.xml and 1 more)"
    assert len(for_people(_report(*same).findings)) == 4
    alike = [_one(1, "no mass", "knee", path=f"{name}.xml", help="add one") for name in "abcd"]
    (group,) = for_people(_report(*alike).findings)
    assert group.headline() == "knee: no mass (the same in b.xml, c.xml and 1 more)"
    full = render(_report(*alike), "full", ReportOptions())
    assert "  = the same in b.xml:1:1, c.xml:1:1, d.xml:1:1\n" in full
    assert full.count("add one") == 1
    assert full.endswith("1 warning affecting 1 joint in 0 files\n")
    # Each file of a pull request gets its own annotation.
    assert render(_report(*alike), "github", ReportOptions()).count("LIM901") == 4


def test_what_has_no_effect_is_reported_once() -> None:
    """A speed limit that several configurations write in vain is one habit; an effort limit is each robot's own."""
    for field, count in (("velocity_limit", 1), ("effort_limit", 3)):
        found = [_one(1, "it is ignored", j, path=f"{j}.py", fields=(field,)) for j in "abc"]
        assert len(_groups(*found)) == count


def test_what_nobody_filled_in_is_reported_once() -> None:
    """Zeros of several robots are one thing that was left out, as placeholders are; other figures are not."""
    zeros = [
        _one(1, "the effort is 0", j, path=f"{j}.urdf", value=0.0, fields=("effort_limit",)) for j in "abc"
    ]
    (group,) = _groups(*zeros)
    assert group.headline() == "a: the effort is 0 (the same for other joints in b.urdf, c.urdf)"
    (group,) = _groups(
        *(replace(item, message=f"1e{n} N*m", value=10.0**n) for n, item in enumerate(zeros, 5))
    )
    assert len(group.copies) == 2
    assert len(_groups(*(replace(item, value=10.0) for item in zeros))) == 3
    assert len(_groups(*(replace(item, value=None) for item in zeros))) == 3


def test_few_about_no_joint_are_shown_one_by_one() -> None:
    """As many as `MOST_ALIKE` say something each; joints are named where one stands for all."""
    found = _groups(*(_one(i, f"gets {i} N*m") for i in range(MOST_ALIKE)))
    assert [group.headline() for group in found] == ["gets 0 N*m", "gets 1 N*m", "gets 2 N*m"]
    (group,) = _groups(*(_one(i, f"gets {i} N*m", f"j{i}", value=float(i)) for i in range(2)))
    assert group.headline() == "j1: gets 1 N*m (similar: j0)"


def test_one_figure_of_a_file_is_one_finding() -> None:
    """What the rest of the sentence says of the same figure is no other fault; another figure is."""
    texts = ("uses 20 N*m, and leaves 2 N*m", "uses 60 N*m, and keeps the joint below 5 rad/s")
    same = [_one(i, text, f"j{i}", fields=("joint_damping",)) for i, text in enumerate(texts)]
    assert len(_groups(*same)) == 1
    assert len(_groups(same[0], replace(same[1], fields=("frictionloss",)))) == 2


@pytest.mark.parametrize(
    "messages, shown",
    [
        (["gets 1 N*m", "gets 1e-3 N*m", "gets +2.5 N*m", "gets inf N*m"], 1),
        (["(x1.43) more", "(x2) more", "(x10.5) more", "(x3) more"], 1),
        (["pattern 'a.*' fits none", "pattern 'b' fits none", "pattern 'c' fits none", "pattern '' fits none"], 1),
        (["see knee_1", "see knee_2", "see knee_3", "see knee_4"], 4),
        (["see g1_23dof.xml", "see g1_29dof.xml", "see g1_12dof.xml", "see 2.xml"], 4),
        (["1 more", "1 less", "1 other", "1 none"], 4),
    ],
    ids=["figures", "ratios", "quoted", "joints", "files", "words"],
)  # fmt: skip
def test_what_counts_as_a_figure(messages: list[str], shown: int) -> None:
    """Digits of names tell joints and files apart; figures and quoted patterns do not."""
    assert len(_groups(*(_one(line, text) for line, text in enumerate(messages, 1)))) == shown


def test_without_joints_the_others_are_counted() -> None:
    """Findings about files have no joints to name."""
    (group,) = _groups(*(_one(i, f"gets {i} N*m") for i in range(5)))
    assert group.headline() == "gets 0 N*m (similar: 4 more)"


def test_formats_for_programs_have_every_finding() -> None:
    """Folding is for people; concise shows 1 of 5, JSON 5."""
    made = _report(*(_one(i, f"gets {i} N*m", f"j{i}", value=float(i)) for i in range(5)))
    assert render(made, "concise", ReportOptions()).count("LIM901") == 1
    assert render(made, "markdown", ReportOptions()).count("(similar: j0, j1, j2, j3)") == 1
    assert render(made, "json", ReportOptions()).count('"LIM901"') == 5
    assert render(made, "sarif", ReportOptions()).count('"ruleId": "LIM901"') == 5


def test_many_silent_rules_are_one_line() -> None:
    """Who asks for many rules reads how many lacked input, who asks for few reads what each lacks."""
    few = [Skipped(f"NET90{i}", f"no {i}") for i in range(MOST_REASONS)]
    assert "NET900 did not apply: no 0\nNET901 did not apply: no 1\n" in render(
        _report(*few), "full", ReportOptions(chosen=True)
    )
    many = [*few, Skipped("NET909", "no 9"), Skipped("NET909", "no 8")]
    assert render(_report(*many), "full", ReportOptions(chosen=True)).startswith("4 rules did not apply;")


def test_what_variants_have_with_other_figures_is_reported_once() -> None:
    """The same said of one joint of several files is one finding, called similar; of another joint it is not."""
    a, b = (_one(1, f"2 N*m is {times} times too much", "l", path=f"{times}.xml") for times in (3, 4))
    (group,) = _groups(a, b)
    assert group.headline() == "l: 2 N*m is 3 times too much (similar in 4.xml)"
    assert len(_groups(a, replace(b, joint="r"))) == len(_groups(a, replace(b, code="LIM902"))) == 2


def test_files_that_depart_from_one_place_are_one_thing() -> None:
    """Two MJCFs from one URDF; each from its own, where the same is said of both."""

    def held(file: str, value: float, to: str) -> Finding:
        text = f"{value:g} here and 35 N*m in {to}"
        related = (Span(to, 3),)
        return _one(1, text, "ankle", path=file, value=value, expected=35.0, related=related)

    (one,) = _groups(held("a.xml", 50.0, "leg.urdf"), held("b.xml", 60.0, "leg.urdf"))
    assert one.headline() == "ankle: 50 here and 35 N*m in leg.urdf (similar in b.xml)"
    (one,) = _groups(held("a.xml", 50.0, "a.urdf"), held("b.xml", 50.0, "b.urdf"))
    assert one.headline() == "ankle: 50 here and 35 N*m in a.urdf (the same in b.xml)"
    assert len(_groups(held("a.xml", 50.0, "a.urdf"), held("b.xml", 60.0, "b.urdf"))) == 2


def test_a_joint_that_is_not_shown_hides_no_other_file() -> None:
    """The elbow of one file stands for its shoulder; another file's shoulder is wrong by itself."""

    def held(file: str, line: int, joint: str, value: float) -> Finding:
        text = f"{value:g} N*m here and 60 N*m in arm.urdf"
        related = (Span("arm.urdf", 4 + line),)
        return _one(line, text, joint, path=file, value=value, expected=60.0, related=related)

    shown = _groups(
        held("a.py", 1, "elbow", 600.0), held("a.py", 2, "lift", 90.0), held("b.py", 2, "lift", 80.0)
    )
    assert [group.headline() for group in shown] == [
        "elbow: 600 N*m here and 60 N*m in arm.urdf (similar: lift)",
        "lift: 80 N*m here and 60 N*m in arm.urdf",
    ]


def test_two_files_that_disagree_are_one_thing() -> None:
    """Two joints with more and less than another file: one group; with two other files, two."""
    other, third = Span("other.urdf", 3), Span("third.urdf", 3)
    texts = ("has 20 N*m, 50 % more", "has 5 N*m, 75 % less")
    held = [
        _one(line, text, joint, value=value, expected=expected, related=(other,))
        for line, text, joint, value, expected in (
            (1, texts[0], "a", 30.0, 20.0),
            (2, texts[1], "b", 5.0, 20.0),
        )
    ]
    (group,) = _groups(*held)
    assert group.headline() == "b: has 5 N*m, 75 % less (similar: a)"
    assert len(_groups(held[0], replace(held[1], related=(third,)))) == 2


def test_whose_figure_it_is_does_not_tell_two_files_apart() -> None:
    """An MJCF with its URDF's damping, which has the speed of that URDF: one fault, and each file has its line."""
    urdf, speed = "m/leg.urdf", Span("m/leg.urdf", 4)
    own = _one(5, "at 7 rad/s the damping of 10 takes all", "knee", path=urdf, value=10.0)
    made = _one(
        9,
        "at 7 rad/s (leg.urdf) the damping of 10 takes all",
        "knee",
        path="m/leg.xml",
        value=10.0,
        related=(speed,),
    )
    (group,) = _groups(own, made)
    assert group.headline() == f"knee: {own.message} (the same in m/leg.xml)"
    # What else stands in brackets is another thing to say.
    other = replace(made, message=made.message.replace("leg.urdf", "of its gear"))
    assert len(_groups(own, other)) == len(_groups(own, replace(made, joint="hip"))) == 2


def test_a_file_is_not_another_one() -> None:
    """Two figures of one file, each held to a file of its own: the file is not named as another one."""
    held = [
        _one(
            line,
            f"57.3 times that in {to}",
            "ankle",
            path="a.xml",
            value=50.0,
            expected=35.0,
            related=(Span(to, 3),),
        )
        for line, to in ((1, "a.urdf"), (2, "b.urdf"))
    ]
    (group,) = _groups(*held)
    assert group.copies and group.headline() == "ankle: 57.3 times that in a.urdf"


def test_of_fewer_joints_a_file_has_the_same_for_some() -> None:
    """b.urdf has the fault at one of a.urdf's two joints: at the other it is sound."""
    three = [
        _one(1, "lower above upper", j, path=f"{f}.urdf") for f, j in (("a", "l"), ("a", "r"), ("b", "l"))
    ]
    (group,) = _groups(*three)
    assert group.headline() == "l, r: lower above upper (the same for some of these joints in b.urdf)"


def test_files_that_depart_otherwise_from_one_place_are_two_findings() -> None:
    """400 N*m at every joint of one file is no figure of a file that has 300 N*m at one; 200 and 300 N*m are alike."""
    at = {"expected": 100.0, "related": (Span("c.urdf", 3),), "fields": ("effort_limit",)}
    said = [("a", 400.0, " on every joint"), ("b", 300.0, ""), ("d", 200.0, "")]
    groups = _groups(
        *(
            _one(1, f"the limit is {value:g} N*m{where}", "hip", path=f"{name}.urdf", value=value, **at)
            for name, value, where in said
        )
    )
    assert [group.headline() for group in groups] == [
        "hip: the limit is 400 N*m on every joint",
        "hip: the limit is 300 N*m (similar in d.urdf)",
    ]


def test_every_format_counts_the_same() -> None:
    """Five joints of a.xml, two of which b.xml has too, and a note of a sixth joint.

    One a joint there are 8, one a message 4 (three figures in a.xml, a copy, the note) less what is folded: people read
    one warning and one note, of 5 + 1 joints.
    """
    figures = (3.0, 9.0, 4.0, 4.0, 4.0)
    alike = [_one(i, f"gets {value:g} N*m", f"j{i}", value=value) for i, value in enumerate(figures)]
    copies = [replace(one, span=Span("b.xml", 1, 1)) for one in alike[:2]]
    made = _report(*alike, *copies, finding("SRC901", joint="toe", severity=Severity.INFO))
    words = "1 warning, 1 note affecting 6 joints"
    assert render(made, "concise", ReportOptions()).endswith(f"\n{words} in 0 files\n")
    assert render(made, "markdown", ReportOptions()).startswith(f"### actspec audit: {words} in 0 files\n")
    page = render(made, "html", ReportOptions())
    assert f"<title>actspec audit: {words}</title>" in page
    assert page.count("<article") == 2 and page.count('<td class="n">1</td>') == 2
    assert "gets 9 N*m (similar: j0, j2, j3, j4) (the same for some of these joints in b.xml)" in page
    shown = json.loads(render(made, "json", ReportOptions()))
    assert len(shown["findings"]) == 8
    assert shown["shown_as"] == {"errors": 0, "warnings": 1, "notes": 1, "joints": 6, "patterns": 0}
    said = render(made, "concise", ReportOptions(statistics=True)).splitlines()
    assert [line.split()[:2] for line in said[:2]] == [["1", "LIM901"], ["1", "SRC901"]]
