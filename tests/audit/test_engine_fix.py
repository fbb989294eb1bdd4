"""Fixes: all edits or none, no two on the same bytes, and no change of the model that was not announced."""

from __future__ import annotations

import faulthandler
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from actspec.audit import build
from actspec.audit.case import Case
from actspec.audit.engine import judge
from actspec.audit.finding import Finding, Fix, Safety, Skipped, TextEdit
from actspec.audit.fix import Fixes, apply_fixes, write_fixes
from actspec.audit.read import read_files
from actspec.audit.rule import Rule
from actspec.audit.settings import Settings
from actspec.diagnostics import AuditError
from actspec.readings.artifact import FileKind, FileReading
from actspec.readings.versions import Versions
from actspec.robot.view import ModelFile, ModelFormat
from tests.audit.making import case_of, finding, reading, rule_of

Files = tuple[ModelFile, ...]

LEG = b"""<mujoco>
  <worldbody>
    <body><joint name="hip" damping="2"/><geom size=".1"/>
      <body><joint name="knee" damping="2"/><geom size=".1"/></body>
    </body>
  </worldbody>
  <actuator><motor joint="hip"/></actuator>
</mujoco>
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def edit(data: bytes, old: bytes, new: bytes, path: str = "leg.xml", nth: int = 0) -> TextEdit:
    """Replace a text, the nth from 0."""
    at = -1
    for _ in range(nth + 1):
        at = data.index(old, at + 1)
    return TextEdit(path, at, at + len(old), new)


def fixed(data: bytes, *fixes: Fix, unsafe: bool = True, files: dict[str, bytes] | None = None) -> Fixes:
    """Fixes of findings in leg.xml."""
    found = [finding("LIM901", "leg.xml", line, fix=fix) for line, fix in enumerate(fixes, 1)]
    report = judge(
        case_of(files or {"leg.xml": data}), Settings(), (rule_of("LIM901", "first-rule", *found),)
    )
    return apply_fixes(report.findings, report.case.files, unsafe)


def unsafe(*edits: TextEdit, fields: tuple[str, ...] = ("dof_damping",)) -> Fix:
    """A fix that needs consent."""
    return Fix("Take the damping out", Safety.UNSAFE, edits, fields)


def test_a_fix_changes_its_bytes_and_no_others() -> None:
    """The rest of the text stays, to the byte."""
    found = fixed(LEG, unsafe(edit(LEG, b' damping="2"', b"")))
    assert not found.refused
    (file,) = found.files
    assert (file.path, file.titles) == ("leg.xml", ("Take the damping out",))
    assert file.new == LEG.replace(b' damping="2"', b"", 1)


def crashes(path: str, form: ModelFormat, old: Files, new: Files, fields: set[str]) -> str | None:
    """A check of which the engine dies as soon as a damping of 1 is in the text."""
    faulthandler.disable()  # pytest's would tell of every death that is meant
    if any(b'damping="1"' in file.data for file in new):
        os.kill(os.getpid(), signal.SIGSEGV)
    return None


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="elsewhere processes are not forked")
@pytest.mark.usefixtures("processes")
def test_a_crash_of_the_engine_loses_only_its_fix(monkeypatch: pytest.MonkeyPatch) -> None:
    """The run goes on, the fix that it died of is told and not made, the other one is."""
    monkeypatch.setattr("actspec.audit.fix._model_fault", crashes)
    fatal = unsafe(edit(LEG, b'damping="2"', b'damping="1"'))
    good = unsafe(edit(LEG, b'damping="2"', b'damping="3"', nth=1))
    found = fixed(LEG, fatal, good)
    assert found.files[0].new == LEG[: LEG.rindex(b'"2"')] + b'"3"' + LEG[LEG.rindex(b'"2"') + 3 :]
    assert [item.message for item in found.refused] == [
        "the fix of LIM901 is not applied (Take the damping out): "
        "leg.xml could not be compiled to check it: MuJoCo crashed on it (signal 11)"
    ]


@pytest.mark.slow
def test_no_model_is_compiled_in_this_process() -> None:
    """A check that holds in another process does not even load MuJoCo in this one."""
    code = (
        "import sys; from tests.audit.test_engine_fix import LEG, edit, fixed, unsafe\n"
        "found = fixed(LEG, unsafe(edit(LEG, b'damping=\"2\"', b'damping=\"1\"')))\n"
        "print(len(found.files), 'mujoco' in sys.modules)"
    )
    root = str(Path(__file__).parents[2])
    environment = {**os.environ, "PYTHONPATH": root}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=True
    )
    assert done.stdout == "1 False\n"


def test_consent() -> None:
    """Without `--unsafe-fixes` a fix that changes the robot's behaviour is left."""
    assert not fixed(LEG, unsafe(edit(LEG, b' damping="2"', b"")), unsafe=False).files
    comment = Fix("Say so", Safety.SAFE, (edit(LEG, b"<actuator>", b"<actuator><!-- x -->"),))
    assert fixed(LEG, comment, unsafe=False).files


def offered(*found: Finding) -> list[bool]:
    """Whether each finding has a fix to offer."""
    rules = [
        rule_of(code, code.lower(), *(f for f in found if f.code == code)) for code in {f.code for f in found}
    ]
    report = judge(case_of({"leg.xml": LEG, "b.xml": LEG}), Settings(), rules)
    by_finding = {(f.finding.code, f.finding.joint): f.finding.fix is not None for f in report.findings}
    return [by_finding[f.code, f.joint] for f in found]


def test_fixes_that_contradict_are_not_offered() -> None:
    """Two findings that put different text in one place: neither knows the other. Equal ones and other places stay."""
    one = unsafe(edit(LEG, b'damping="2"', b'damping="1"'))
    other = unsafe(edit(LEG, b'damping="2"', b'damping="3"'))
    apart = unsafe(edit(LEG, b'"2"', b'"3"', nth=1))
    assert offered(
        finding("LIM901", "leg.xml", joint="hip", fix=one),
        finding("DMP901", "leg.xml", joint="hip", fix=other),
    ) == [False, False]
    assert offered(
        finding("LIM901", "leg.xml", joint="hip", fix=one),
        finding("DMP901", "leg.xml", joint="knee", fix=one),
    ) == [True, True]
    assert offered(
        finding("LIM901", "leg.xml", joint="hip", fix=one),
        finding("DMP901", "leg.xml", joint="hip", fix=apart),
    ) == [True, True]


@pytest.mark.parametrize(
    ("code", "path", "joint", "stays"),
    [
        pytest.param("UNT901", "leg.xml", "", False, id="the file's unit is in doubt"),
        pytest.param("SGN901", "leg.xml", "", False, id="the file's signs"),
        pytest.param("UNT901", "leg.xml", "knee", True, id="the unit at another joint"),
        pytest.param("UNT901", "b.xml", "", True, id="of another file"),
        pytest.param("LIM902", "leg.xml", "", True, id="not its figures"),
    ],
)
def test_nothing_is_fixed_where_the_rest_of_the_file_is_in_doubt(
    code: str, path: str, joint: str, stays: bool
) -> None:
    """A fix takes joint ranges for right that another finding calls radians read as degrees."""
    fix = unsafe(edit(LEG, b'damping="2"', b'damping="1"'))
    found = offered(
        finding("LIM901", "leg.xml", joint="hip", fix=fix),
        finding(code, path, joint=joint, message="radians"),
    )
    assert found == [stays, False]


def test_nothing_is_fixed_where_the_units_of_joints_are_in_doubt() -> None:
    """One joint may be a slip; two are how the file was written. A fix of their own says what is right there."""
    fix = unsafe(edit(LEG, b'damping="2"', b'damping="1"'))
    hip = finding("LIM901", "leg.xml", joint="hip", fix=fix)
    own = unsafe(edit(LEG, b'damping="2"', b'damping="3"', nth=1))
    for code, joints, theirs, stays in (
        ("UNT901", ("knee", "toe"), None, False),
        ("UNT901", ("knee",), None, True),
        ("UNT901", ("knee", "toe"), own, True),
        ("SGN901", ("knee", "toe"), None, True),
    ):
        others = [finding(code, "leg.xml", joint=joint, fix=theirs) for joint in joints]
        assert offered(hip, *others)[0] is stays
    # A field that is called otherwise has the figure that it had.
    safe = finding("LIM901", "leg.xml", joint="hip", fix=replace(fix, safety=Safety.SAFE))
    assert offered(safe, *(finding("UNT901", "leg.xml", joint=joint) for joint in ("knee", "toe")))[0]


def test_joints_share_the_fix_of_a_class() -> None:
    """Equal edits of several findings are one."""
    fix = unsafe(edit(LEG, b' damping="2"', b""))
    assert fixed(LEG, fix, fix).files[0].new == LEG.replace(b' damping="2"', b"", 1)


def test_of_overlapping_fixes_the_first_is_made_whole() -> None:
    """A fix of which one edit overlaps is not made at all; it may fit on the next pass."""
    first = unsafe(edit(LEG, b'damping="2"', b'damping="1"'))
    second = unsafe(edit(LEG, b"2", b"3"), edit(LEG, b"2", b"3", nth=1))
    assert LEG.index(b"2") == LEG.index(b'damping="2"') + 9
    assert fixed(LEG, first, second).files[0].new == LEG.replace(b'"2"', b'"1"', 1)
    assert fixed(LEG, second, first).files[0].new == LEG.replace(b'"2"', b'"3"')


def test_insertions_at_one_place_overlap() -> None:
    """Nobody knows in which order two insertions at one byte are meant."""
    at = LEG.index(b"<actuator>")
    first, second = (
        Fix("a", Safety.SAFE, (TextEdit("leg.xml", at, at, text),)) for text in (b"<!--a-->", b"<!--b-->")
    )
    assert fixed(LEG, first, second).files[0].new == LEG.replace(b"<actuator>", b"<!--a--><actuator>")


@pytest.mark.parametrize(
    "fix, reason",
    [
        (unsafe(edit(LEG, b'damping="2"', b'armature="2"')), "it would change dof_armature: "),
        (
            unsafe(edit(LEG, b'damping="2"', b'damping="x"')),
            "MuJoCo refuses leg.xml afterwards: ",
        ),
        (unsafe(edit(LEG, b'damping="2"/>', b'damping="1">')), "MuJoCo refuses leg.xml afterwards: "),
    ],
    ids=["another field", "no number", "no XML"],
)
def test_a_fix_that_does_more_than_it_says_is_not_made(fix: Fix, reason: str) -> None:
    """The compiled model decides; the other fixes are made all the same."""
    good = unsafe(edit(LEG, b'damping="2"', b'damping="1"', nth=1))
    found = fixed(LEG, fix, good)
    (refused,) = found.refused
    assert refused.message.startswith(f"the fix of LIM901 is not applied (Take the damping out): {reason}")
    assert (refused.code, str(refused.span)) == ("AUD011", "leg.xml:1:1")
    assert found.files[0].new == b'damping="1"'.join(LEG.rsplit(b'damping="2"', 1))


def test_a_model_that_mujoco_refuses_is_not_fixed() -> None:
    """What cannot be checked is not changed."""
    bad = LEG.replace(b"<motor", b"<nonsense")
    found = fixed(bad, unsafe(edit(bad, b'damping="2"', b'damping="1"')))
    assert not found.files
    assert "MuJoCo does not take leg.xml as it is, so the fix cannot be checked" in found.refused[0].message


def test_an_included_file_is_checked_in_its_model() -> None:
    """An edit of an include is judged by the model that includes it, in every file that was named."""
    body = b'<worldbody><body><joint name="a"/><geom size=".1"/></body></worldbody>'
    main = b'<mujoco><include file="part.xml"/>' + body + b"</mujoco>"
    part = b'<mujoco><option timestep="0.002"/></mujoco>'
    files = (ModelFile("scene.xml", "", main), ModelFile("part.xml", "part.xml", part))
    scene = FileReading("scene.xml", FileKind.MJCF, None, (), files)
    fix = Fix("Set the step", Safety.UNSAFE, (edit(part, b"0.002", b"0.001", "part.xml"),), ("opt.timestep",))
    wrong = Fix("Set the step", Safety.UNSAFE, fix.edits, ("opt.density",))
    for given, count in ((fix, 1), (wrong, 0)):
        rule = rule_of("LIM901", "first-rule", finding("LIM901", "part.xml", fix=given))
        report = judge(Case((scene,), (), (), ()), Settings(), (rule,))
        assert len(apply_fixes(report.findings, report.case.files, unsafe=True).files) == count


@pytest.mark.parametrize(
    "path, data, new, good",
    [
        ("cfg.py", b"x = 1\n", b"x = 2", True),
        ("cfg.py", b"x = 1\n", b"x = = 2", False),
        ("deploy.yaml", b"x: 1\n", b"x: 2", True),
        ("deploy.yaml", b"x: 1\n", b"x: [2", False),
    ],
    ids=["py", "broken py", "yaml", "broken yaml"],
)
def test_text_that_could_not_be_read_afterwards(path: str, data: bytes, new: bytes, good: bool) -> None:
    """A fix of a configuration leaves Python that parses and YAML that parses."""
    fix = Fix("Two", Safety.SAFE, (TextEdit(path, 0, 3 + (b"=" in data) + 1, new),))
    case = Case((reading(path, data, FileKind.CFG),), (), (), ())
    report = judge(case, Settings(), (rule_of("LIM901", "first-rule", finding("LIM901", path, fix=fix)),))
    found = apply_fixes(report.findings, report.case.files, unsafe=False)
    assert (len(found.files), len(found.refused)) == ((1, 0) if good else (0, 1))


def test_writing(folder: Path) -> None:
    """A file that somebody has changed meanwhile is left; a link stays a link."""
    (folder / "real.xml").write_bytes(LEG)
    (folder / "leg.xml").symlink_to("real.xml")
    files = fixed(LEG, unsafe(edit(LEG, b' damping="2"', b""))).files
    write_fixes(files)
    assert (folder / "leg.xml").is_symlink()
    assert (folder / "real.xml").read_bytes() == files[0].new
    with pytest.raises(AuditError) as caught:
        write_fixes(files)
    assert caught.value.diagnostics[0].message == "the file has changed since it was read; not fixed"


@pytest.mark.skipif(os.name == "nt", reason="no modes there")
def test_a_file_keeps_its_mode(folder: Path) -> None:
    """Who may read, write and run it stays; a file that nobody may write is left, though its folder would allow it."""
    leg = folder / "leg.xml"
    leg.write_bytes(LEG)
    files = fixed(LEG, unsafe(edit(LEG, b' damping="2"', b""))).files
    leg.chmod(0o444)
    with pytest.raises(AuditError) as caught:
        write_fixes(files)
    assert caught.value.diagnostics[0].message == "the file cannot be written: it is read-only"
    assert leg.read_bytes() == LEG
    leg.chmod(0o750)
    write_fixes(files)
    assert (leg.stat().st_mode & 0o777, leg.read_bytes()) == (0o750, files[0].new)


class DampedJoint(Rule):
    """Reports damping, one joint at a time, as a rule with fixes would."""

    code = "LIM901"
    name = "first-rule"
    severity = rule_of("LIM901", "first-rule").severity
    confidence = rule_of("LIM901", "first-rule").confidence

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find and fix."""
        for file in case.files[0].files:
            for nth in range(file.data.count(b'"2"')):
                fix = unsafe(edit(file.data, b'"2"', b'"1"', file.path, nth))
                yield finding("LIM901", file.path, nth + 1, fix=fix)


def test_fixing_is_idempotent(folder: Path) -> None:
    """After the fixes are written nothing is found, and a second run changes nothing."""
    (folder / "leg.xml").write_bytes(LEG)

    def fixes() -> Fixes:
        case = build.case_of(read_files(("leg.xml",), jobs=1), Versions(), {})
        return apply_fixes(judge(case, Settings(), (DampedJoint,)).findings, case.files, unsafe=True)

    write_fixes(fixes().files)
    assert (folder / "leg.xml").read_bytes() == LEG.replace(b'"2"', b'"1"')
    assert not fixes().files
