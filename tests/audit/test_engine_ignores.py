"""Remarks in audited files: where they are seen, which lines they speak about, and what becomes of them."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.audit.comments import comments
from actspec.audit.engine import judge
from actspec.audit.outcome import Means
from actspec.audit.settings import Settings
from tests.audit.making import case_of, finding, rule_of

XML = """<!-- top -->
<mujoco>
  <a/>  <!-- behind a -->
  <b
    x="1 > 0"
    y="!-- no comment -->"/>  <!-- behind b -->
  <!-- one
       of two lines -->
  <!-- two --> <c
    z="1"/>
  <d><!-- in d -->
    <!-- before an end -->
  </d>
  <e/>
</mujoco>
"""
PYTHON = '''# top
X = "# no comment"
Y = """
# nor this
"""  # behind Y
# alone

# and again
Z = call(
    1,  # inside
    # before two
    2,
)
# last
'''
YAML = """# top
a: "# no comment"
b: 'it''s # none'
c: x#y # behind c
d: |
  # text
  more
e: "over
  # two lines"  # behind e
# alone

f: [1, # in f
  2]
# last
"""


@pytest.mark.parametrize(
    "path, text, seen",
    [
        (
            "a.xml",
            XML,
            [
                # The start tag of <mujoco> is on line 2.
                (" top ", 1, 2, 2),
                (" behind a ", 3, 3, 3),
                (" behind b ", 6, 4, 6),
                (" one\n       of two lines ", 7, 9, 10),
                (" two ", 9, 9, 10),
                (" in d ", 11, 11, 11),
                (" before an end ", 12, 0, 0),
            ],
        ),
        (
            "a.py",
            PYTHON,
            [
                (" top", 1, 2, 2),
                (" behind Y", 5, 5, 5),
                (" alone", 6, 9, 9),
                (" and again", 8, 9, 9),
                (" inside", 10, 10, 10),
                (" before two", 11, 12, 12),
                (" last", 14, 0, 0),
            ],
        ),
        (
            "a.yaml",
            YAML,
            [
                (" top", 1, 2, 2),
                (" behind c", 4, 4, 4),
                (" behind e", 9, 9, 9),
                (" alone", 10, 12, 12),
                (" in f", 12, 12, 12),
                (" last", 14, 0, 0),
            ],
        ),
    ],
    ids=["xml", "python", "yaml"],
)
def test_comments(path: str, text: str, seen: list[tuple[str, int, int, int]]) -> None:
    """A comment behind something speaks about that, one alone about what comes next; strings hold none."""
    found = comments(path, text.encode())
    assert sorted((c.text, c.line, c.first, c.last) for c in found) == sorted(seen)


def test_columns_count_from_one() -> None:
    """The place of a comment is that of its first mark, in characters."""
    assert [(c.line, c.column) for c in comments("a.xml", "<a>ö<!-- x --></a>".encode())] == [(1, 5)]
    assert [(c.line, c.column) for c in comments("a.py", "ö = 1  # x\n".encode())] == [(1, 8)]
    assert [(c.line, c.column) for c in comments("a.yaml", "ö: 1  # x\n".encode())] == [(1, 7)]


@pytest.mark.parametrize(
    "path, data",
    [
        ("a.xml", b"<a><!-- seen --><b></a>"),
        ("a.xml", b"<a><!-- seen --><b x='\xff'/></a>"),
        ("a.py", b"# seen\n'''"),
        ("a.py", b"# seen\nx = (\n"),
        ("a.py", b"# seen\n  x\n y\n"),
        ("a.yaml", b"# seen\na: [\n  }"),
        ("a.yaml", b"# seen\n\x00"),
        ("a.yaml", b"# seen\n\xff"),
    ],
    ids=["tags", "utf-8", "string", "bracket", "indent", "flow", "nul", "yaml utf-8"],
)
def test_broken_files_give_what_stands_before(path: str, data: bytes) -> None:
    """An error of the syntax ends the scan and nothing else."""
    assert [comment.text.strip() for comment in comments(path, data)] == ["seen"]


def test_entities_are_not_read() -> None:
    """A DOCTYPE ends the scan before anything can be defined in it."""
    laughs = b'<!-- seen --><!DOCTYPE a [<!ENTITY b "bbbb"><!ENTITY c "&b;&b;">]><a>&c;<!-- not seen --></a>'
    assert [comment.text for comment in comments("a.xml", laughs)] == [" seen "]
    plain = b"<!-- seen --><!DOCTYPE a><a><!-- this too --></a>"
    assert [comment.text.strip() for comment in comments("a.xml", plain)] == ["seen", "this too"]


def _judged(text: str, *lines: int, select: tuple[str, ...] = ("ALL",)) -> list[tuple[str, int, str]]:
    rule = rule_of("LIM901", "first-rule", *[finding("LIM901", line=line) for line in lines])
    report = judge(case_of({"a.xml": text.encode()}), Settings(select=select), (rule,))
    found = [(item.finding.code, item.finding.span.line, item.finding.message) for item in report.findings]
    found += [(item.code, item.span.line, item.message) for item in report.problems if item.span is not None]
    return found + [
        (item.means.value, item.reported.finding.span.line, item.reason) for item in report.suppressed
    ]


@pytest.mark.parametrize(
    "remark, found",
    [
        ("actspec: ignore[LIM901] it clips", [("inline", 2, "it clips")]),
        ("actspec:ignore[first-rule]: it clips", [("inline", 2, "it clips")]),
        ("actspec: ignore[DMP901,LIM901] - it  clips", [("inline", 2, "it clips")]),
        ("actspec: ignore[LIM901]", ["LIM901", "ACT001"]),
        ("actspec: ignore[LIM9]  a family", ["LIM901", "ACT003"]),
        ("actspec: ignore", ["LIM901", "ACT003"]),
        ("actspec: ignored[LIM901] no", ["LIM901", "ACT003"]),
        ("actspec: noqa[LIM901] no", ["LIM901", "ACT003"]),
        ("actspec: ignroe LIM901 no", ["LIM901", "ACT003"]),
        ("actspec: note that LIM901 is meant", ["LIM901"]),
        ("see actspec: ignore[LIM901] no", ["LIM901"]),
    ],
    ids=[
        "code",
        "name",
        "one of two",
        "no reason",
        "family",
        "no code",
        "a past",
        "bracket",
        "letters",
        "a sentence",
        "not at the start",
    ],
)
def test_remarks_on_the_line(remark: str, found: list[object]) -> None:
    """A remark with a reason and the rule's code or name sets the finding aside; any other does not, and is told."""
    told = _judged(f"<a>\n<b/> <!-- {remark} -->\n</a>", 2)
    told = [entry for entry in told if "DMP901" not in entry[2]]
    assert [
        entry if isinstance(wanted, tuple) else entry[0] for entry, wanted in zip(told, found, strict=True)
    ] == found


def test_remark_of_the_whole_file() -> None:
    """`ignore-file` near the top speaks about every line, further down about none."""
    top = "<!-- actspec: ignore-file[LIM901] generated -->"
    assert _judged(f"<a>{top}\n<b/></a>", 2, 90) == [("inline", 2, "generated"), ("inline", 90, "generated")]
    breaks = "\n" * 9
    assert _judged(f"<a>{breaks}{top}</a>", 2) == [("inline", 2, "generated")]
    below = _judged(f"<a>{breaks}\n{top}</a>", 2)
    assert [entry[0] for entry in below] == ["LIM901", "ACT002"]


def test_unused_remarks_are_told_where_the_rule_has_looked() -> None:
    """A remark for a rule that did not run is nobody's business."""
    text = "<a>\n<b/> <!-- actspec: ignore[LIM901] old -->\n</a>"
    assert _judged(text) == [("ACT002", 2, "this ignore of LIM901 sets nothing aside")]
    assert _judged(text, select=("ACT",)) == []
    assert _judged(text, select=("LIM",)) == []


def test_remarks_of_an_included_file_count_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file that is named and included is scanned once, whatever its path is written like."""
    monkeypatch.chdir(tmp_path)
    data = b"<a>\n<b/> <!-- actspec: ignore[LIM901] -->\n</a>"
    report = judge(case_of({"a.xml": data, "./a.xml": data}), Settings(), ())
    assert [item.code for item in report.problems] == ["ACT001", "ACT003"]


def test_inline_goes_before_the_settings() -> None:
    """A finding that both a remark and a setting set aside counts as the remark's: it is of use."""
    text = b"<a>\n<b/> <!-- actspec: ignore[LIM901] it clips -->\n</a>"
    rule = rule_of("LIM901", "first-rule", finding("LIM901", line=2))
    settings = Settings(per_file_ignores=(("*.xml", ("LIM",)),))
    report = judge(case_of({"a.xml": text}), settings, (rule,))
    assert not report.findings
    assert [item.means for item in report.suppressed] == [Means.INLINE]


def test_a_misspelt_remark_has_the_right_one() -> None:
    """With its place and the word to write."""
    report = judge(
        case_of({"a.yaml": b"a: 1\n# actspec: ignroe-file[LIM901] no motor\nb: 2\n"}), Settings(), ()
    )
    (item,) = report.problems
    assert (str(item.span), item.message, item.help) == (
        "a.yaml:2:1",
        "'ignroe-file' is no word that actspec knows here, and is not followed",
        "did you mean `actspec: ignore-file[CODE] the reason`?",
    )
