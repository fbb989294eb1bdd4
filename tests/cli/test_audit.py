"""`actspec audit` and `actspec rule` as a user meets them: options, exit codes, files written."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from actspec.cli.main import main
from actspec.owned import is_own
from actspec.report.terminal import Progress
from tests.schemas import fits

ROOT = Path(__file__).resolve().parents[2]
LEG = """<mujoco model="leg">
  <worldbody>
    <body>
      <joint name="hip"/>
      <geom size="0.1"/>
      <body><joint name="knee"/><geom size="0.1"/><joint name="toe" axis="0 1 0"/></body>
    </body>
  </worldbody>
  <actuator>
    <motor joint="hip"/>
    <motor joint="knee"/><motor joint="toe" forcerange="-1 1" forcelimited="true"/>
  </actuator>
</mujoco>
"""
HEADLINE = (
    "leg.xml:10:5: LIM101 [warning] hip, knee: no force range, joint limit or control range limits this actuator: "
    "its torque is unlimited\n"
)
SKIPPED = "LIM107 did not apply: no drive with both a torque-speed line and an effort limit among the files\n"
COUNT = "1 warning affecting 2 joints in 1 file\n"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working folder, with a model whose motors have no limit, and settings of this folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "leg.xml").write_text(LEG)
    # The rules that this file speaks about; others are added in their time.
    (tmp_path / "actspec.toml").write_text('[audit]\nselect = ["LIM101", "LIM107", "ACT"]\n')
    return tmp_path


def run(*arguments: str) -> int:
    """The exit code, also where argparse ends the process."""
    try:
        return main(list(arguments))
    except SystemExit as stop:
        return int(str(stop.code))


def test_concise(capsys: pytest.CaptureFixture[str]) -> None:
    """Findings and summary go to stdout; warnings do not fail the run."""
    assert run("audit", "leg.xml", "--output-format", "concise") == 0
    assert capsys.readouterr() == (HEADLINE + SKIPPED + COUNT, "")


@pytest.mark.parametrize(
    "options, code",
    [
        ([], 0),
        (["--fail-on", "warning"], 1),
        (["--fail-on", "info"], 1),
        (["--fail-on", "error"], 0),
        (["--fail-on", "never"], 0),
        (["--fail-on", "warning", "--exit-zero"], 0),
        (["--fail-on", "warning", "--select", "LIM107"], 0),
        (["--fail-on", "warning", "--ignore", "LIM101"], 0),
        (["--fail-on", "warning", "--output-format", "sarif"], 0),
        (["--fail-on", "warning", "--output-format", "json"], 1),
        (["gone.xml"], 2),
        (["gone.xml", "--exit-zero"], 2),
        (["gone.xml", "--output-format", "sarif"], 2),
        (["gone.xml", "--fail-on", "never"], 2),
        (["empty"], 2),
        (["broken.xml"], 1),
        (["broken.xml", "--select", "LIM107"], 1),
        (["broken.xml", "--exit-zero"], 0),
        (["broken.xml", "--ignore", "AUD008"], 0),
        (["broken.xml", "--output-format", "sarif"], 0),
        (["folder"], 0),
        (["folder", "--fail-on", "warning", "--select", "LIM107"], 0),
        (["folder", "--fail-on", "info", "--select", "LIM107"], 1),
        (["folder", "--as-named", "--select", "LIM107"], 1),
        (["folder", "--fail-on", "info", "--select", "LIM107", "--ignore", "unreadable-file"], 0),
        (["--fail-on", "bad"], 2),
        (["--select", "LIN101"], 2),
        (["--select", ","], 2),
        (["--target", "isaaclab"], 2),
        (["--target", "isaaclab==2.3", "--target", "isaaclab==3.0"], 2),
        (["--target", "isaac_sim==5.1", "-t", "backend==newton"], 0),
        (["--jobs", "0"], 2),
        (["--config", "gone.toml"], 2),
        (["--baseline", "gone.json"], 2),
        (["--baseline", "gone.json", "--no-baseline"], 2),
        (["--statistics", "--output-format", "json"], 2),
        (["--ledger", "--output-format", "sarif"], 2),
        (["--write-baseline", "b.json", "--diff"], 2),
        (["--write-baseline", "b.json", "-o", "r.txt"], 2),
        (["--output", "gone/report.txt"], 2),
        (["--spec", "leg.xml"], 2),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_exit_codes(options: list[str], code: int, capsys: pytest.CaptureFixture[str]) -> None:
    """0 nothing at or above --fail-on, 1 findings, 2 could not run or a wrong name; never a traceback."""
    Path("empty").mkdir()
    Path("folder").mkdir()
    for path in ("broken.xml", "folder/broken.xml"):
        Path(path).write_text("<mujoco>")
    assert run("audit", "leg.xml", *options) == code
    assert "Traceback" not in capsys.readouterr().err


def test_a_report_is_not_written_over_what_it_is_about(capsys: pytest.CaptureFixture[str]) -> None:
    """`-o` with a file's name behind it that was meant to be audited would end that file."""
    for option in ("-o", "--write-baseline"):
        assert run("audit", "leg.xml", option, "./leg.xml") == 2
        assert "leg.xml: OUT003: is read by this command" in capsys.readouterr().err
    assert Path("leg.xml").read_text() == LEG


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX")
def test_a_report_into_a_pipe() -> None:
    """`-o /dev/stdout` writes where it leads, and does not put a file in place of what everybody shares."""
    os.mkfifo("pipe")
    reader = os.open("pipe", os.O_RDONLY | os.O_NONBLOCK)
    try:
        run("audit", "leg.xml", "--output-format", "concise", "-o", "pipe")
        assert os.read(reader, 10_000).decode() == HEADLINE + SKIPPED + COUNT
    finally:
        os.close(reader)
    assert Path("pipe").is_fifo()


def test_fixes_that_undo_each_other_end(capsys: pytest.CaptureFixture[str]) -> None:
    """Two models with steps of 5 and 10 ms share a delay of 20 ms, 4 or 2 samples: neither is written."""
    text = LEG.replace('<motor joint="hip"/>', '<motor joint="hip" delay="0.02" nsample="2"/>')
    Path("part.xml").write_text(text)
    for name, step in (("fast.xml", "0.005"), ("slow.xml", "0.01")):
        Path(name).write_text(f'<mujoco><option timestep="{step}"/><include file="part.xml"/></mujoco>')
    said = "part.xml: AUD011 [warning]: its fixes undo each other: none is applied, and the file is as it was"
    for option in ((), ("--diff",)):
        run("audit", "fast.xml", "slow.xml", "--select", "DLY102", "--unsafe-fixes", *option)
        told = capsys.readouterr()
        assert (told.err.splitlines(), "+++" in told.out) == ([said], False)
    assert Path("part.xml").read_text() == text


def test_what_a_fix_brings_to_light_is_not_fixed_unseen(capsys: pytest.CaptureFixture[str]) -> None:
    """With its biastype the wrist is a servo, of which 69 is degrees of 1.2 rad: reported afterwards, not written.

    Both fixes are made where the second is shown: by another run.
    """
    drive = '<general joint="wrist" gainprm="20" biasprm="0 -20 -0.5" ctrlrange="-69 69" forcerange="-5 5"/>'
    served = drive.replace("biasprm", 'biastype="affine" biasprm')
    text = (
        '<mujoco><compiler angle="radian"/><worldbody><body>\n'
        '<joint name="wrist" range="-1.2 1.2" damping="0.1" armature="0.01"/><geom size=".1"/>\n'
        f"</body></worldbody><actuator>\n{drive}\n</actuator></mujoco>\n"
    )
    Path("arm.xml").write_text(text)
    options = ("--select", "SGN102,UNT101", "--as-named", "--unsafe-fixes", "--output-format", "concise")
    assert run("audit", "arm.xml", *options, "--diff") == 1
    shown = [line for line in capsys.readouterr().out.splitlines()[2:] if line[0] in "+-"]
    assert shown == [f"-{drive}", f"+{served}"]
    run("audit", "arm.xml", *options)
    assert Path("arm.xml").read_text() == text.replace(drive, served)
    told = capsys.readouterr()
    assert told.err.splitlines()[-1] == 'arm.xml: Add biastype="affine"'
    assert "UNT101 [warning] wrist: the control range is -69 rad ... 69 rad" in told.out
    run("audit", "arm.xml", *options)
    assert Path("arm.xml").read_text() == text.replace(drive, served.replace("-69 69", "-1.2 1.2"))


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["gone.xml"], "nothing is fixed: a name stands for no file, or a rule broke off"),
        (["-o", "mine.txt"], "mine.txt: OUT003: exists already, and would be lost"),
        (["-o", "leg.xml"], "leg.xml: OUT003: is read by this command"),
    ],
)
def test_exit_code_2_has_fixed_nothing(
    more: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Neither a file is changed, nor does it say so; the report is that of the files as they are."""
    text = LEG.replace('<motor joint="hip"/>', '<motor joint="hip" delay="0.02" nsample="2"/>')
    text = text.replace("<worldbody>", '<option timestep="0.005"/><worldbody>', 1)
    Path("leg.xml").write_text(text)
    Path("mine.txt").write_text("mine")
    fix = ["--select", "DLY102", "--unsafe-fixes", "--output-format", "concise"]
    assert run("audit", "leg.xml", *more, *fix) == 2
    told = capsys.readouterr()
    assert said in told.err and "Set nsample" not in told.err
    assert (Path("leg.xml").read_text(), Path("mine.txt").read_text()) == (text, "mine")
    assert ("DLY102" in told.out) == (more == ["gone.xml"])
    assert run("audit", "leg.xml", *fix, "-o", "mine.txt", "--force") == 0
    assert 'leg.xml: Set nsample="4"' in capsys.readouterr().err
    assert 'nsample="4"' in Path("leg.xml").read_text() and "no findings" in Path("mine.txt").read_text()


def test_the_same_of_many_joints_is_said_once(capsys: pytest.CaptureFixture[str]) -> None:
    """Three joints with a negative effort and one with a negative speed are two remarks of the reader, not four."""
    links = "".join(f'<link name="{name}"/>' for name in "abcde")
    joints = "".join(
        f'<joint name="j{child}" type="revolute"><parent link="a"/><child link="{child}"/>'
        f'<limit lower="-1" upper="1" effort="{effort}" velocity="{speed}"/></joint>\n'
        for child, effort, speed in (("b", -2, 1), ("c", -2, 1), ("d", 5, -2), ("e", -2, 1))
    )
    Path("r.urdf").write_text(f'<robot name="r">{links}{joints}</robot>')
    run("audit", ".")
    told = [line for line in capsys.readouterr().err.splitlines() if "ROBOT123" in line]
    assert [line.partition(": ROBOT123 [warning] ")[2].partition(":")[0] for line in told] == [
        "jb, jc, je",
        "jd",
    ]


def test_what_is_unknown_is_said(capsys: pytest.CaptureFixture[str]) -> None:
    """A gain from a loop and a list without names cost the comparison, so both are told with place and reason."""
    Path("dog_cfg.py").write_text(
        "from isaaclab.actuators import ImplicitActuatorCfg\n"
        "from isaaclab.assets import ArticulationCfg\n"
        "GAINS = {}\n"
        'for name in ("hip", "knee"):\n'
        "    GAINS[name] = 4.0\n"
        "DOG_CFG = ArticulationCfg(\n"
        '    actuators={"legs": ImplicitActuatorCfg(joint_names_expr=[".*"], stiffness=GAINS, damping=1.0)}\n'
        ")\n"
        "SLOW_CFG = DOG_CFG.copy()\n"
    )
    Path("dog.yaml").write_text("kps: [4, 5]\n")
    told = [
        "dog_cfg.py:3:9: CFG001 [info] legs.stiffness: not known without running it: built in a loop",
        "dog.yaml:1:6: DEPLOY002 [info] kps: it is a list without joint names: which joint a value belongs to is not "
        "guessed",
    ]
    assert run("audit", "dog_cfg.py", "dog.yaml") == 0
    out, err = capsys.readouterr()
    assert ("2 notes (CFG001, DEPLOY002): --notes shows them\n" in out, err) == (True, "")
    assert run("audit", "dog_cfg.py", "dog.yaml", "--notes") == 0
    assert [line for line in capsys.readouterr().err.splitlines() if "help:" not in line] == told
    run("audit", "dog_cfg.py", "dog.yaml", "--output-format", "json")
    found = json.loads(capsys.readouterr().out)["diagnostics"]
    assert [item["code"] for item in found] == ["CFG001", "DEPLOY002"]


def test_a_limit_of_zero_is_told_once(capsys: pytest.CaptureFixture[str]) -> None:
    """By the rule, which can be set aside, and not by the reader too."""
    Path("r.urdf").write_text(
        '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="revolute"><parent link="a"/>'
        '<child link="b"/><limit lower="-1" upper="1" effort="0" velocity="1"/></joint></robot>'
    )
    run("audit", "r.urdf", "--select", "LIM103", "--notes", "--output-format", "concise")
    out, err = capsys.readouterr()
    assert [line.split()[1] for line in out.splitlines() if "effort is 0" in line] == ["LIM101"]
    assert err == ""


def test_option_errors_come_together(capsys: pytest.CaptureFixture[str]) -> None:
    """Everything that is wrong with the command line is told at once, with the nearest right word."""
    arguments = [
        "--select",
        "LIN101,lim",
        "--ignore",
        "no-limit-of-any-kin",
        "-t",
        "isaclab==2.3",
        "-t",
        "mujoco==x",
    ]
    assert run("audit", "leg.xml", *arguments) == 2
    assert capsys.readouterr().err.splitlines() == [
        "AUD003 --select: no rule has the code, the beginning of a code or the name 'LIN101'",
        "  help: did you mean 'LIM101'?",
        "AUD003 --select: no rule has the code, the beginning of a code or the name 'lim'",
        "  help: did you mean 'LIM'?",
        "AUD003 --ignore: no rule has the code, the beginning of a code or the name 'no-limit-of-any-kin'",
        "  help: did you mean 'no-limit-of-any-kind'?",
        "AUD010 --target: 'isaclab' is not a simulator or backend that files can be for",
        "  help: did you mean 'isaaclab'?",
        "AUD010 --target: must be a version such as 2.3, got 'x'",
        "5 errors",
    ]


def test_failure_in_json(capsys: pytest.CaptureFixture[str]) -> None:
    """An audit that cannot start says so in JSON, in the form of the schema."""
    assert run("audit", "leg.xml", "--select", "LIN101", "--output-format", "json") == 2
    out = capsys.readouterr()
    record = json.loads(out.out)
    fits("report", record)
    assert (record["format"], [item["code"] for item in record["diagnostics"]]) == (
        "actspec-report/1",
        ["AUD003"],
    )
    assert out.err == ""


def test_an_unread_file_does_not_hide_the_others(capsys: pytest.CaptureFixture[str]) -> None:
    """What is there is judged; a name that stands for nothing is told on stderr."""
    assert run("audit", "gone.xml", "leg.xml", "--output-format", "concise") == 2
    out = capsys.readouterr()
    assert out.out.startswith(HEADLINE)
    assert " in 1 file; nothing to audit at 1 path" in out.out
    assert out.err == "gone.xml: AUD016: there is no such file or folder\n"


@pytest.mark.parametrize(
    "output_format", ["full", "concise", "json", "sarif", "github", "junit", "markdown", "html"]
)
def test_output_file(output_format: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """-o writes what would have been printed, below a line by which actspec knows it again, and prints nothing."""
    assert run("audit", "leg.xml", "--output-format", output_format) == 0
    printed = capsys.readouterr().out
    assert run("audit", "leg.xml", "--output-format", output_format, "-o", "report") == 0
    assert capsys.readouterr() == ("", "")
    head = "# Written by `actspec audit`.\n" if output_format in ("full", "concise", "github") else ""
    assert (folder / "report").read_text(encoding="utf-8") == head + printed
    assert is_own("report")
    assert "LIM101" in printed


def test_json_validates(capsys: pytest.CaptureFixture[str]) -> None:
    """Of a real file too, every figure has its form."""
    assert run("audit", "leg.xml", "--output-format", "json") == 0
    record = json.loads(capsys.readouterr().out)
    fits("report", record)
    assert [(row["joint"], row["effort_limit"]) for row in record["ledger"]] == [
        ("hip", "Infinity"),
        ("knee", "Infinity"),
        ("toe", 1.0),
    ]


def test_settings_and_options_together(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """--select replaces the file's choice, --ignore adds to it; other options win over the file."""
    (folder / "actspec.toml").write_text(
        '[audit]\nselect = ["LIM107"]\nignore = ["ACT"]\nfail-on = "never"\nseverity = {LIM101 = "error"}\n'
    )
    assert run("audit", "leg.xml", "--output-format", "concise") == 0
    assert "LIM101" not in capsys.readouterr().out
    assert run("audit", "leg.xml", "--output-format", "concise", "--select", "LIM") == 0
    assert "LIM101 [error]" in capsys.readouterr().out
    assert (
        run("audit", "leg.xml", "--output-format", "concise", "--select", "LIM101", "--fail-on", "error") == 1
    )


def test_inline_ignore(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A remark with a reason takes its finding away, and is counted."""
    remark = "<!-- actspec: ignore[LIM101] the driver clips -->"
    (folder / "leg.xml").write_text(LEG.replace('"hip"/>\n    <', f'"hip"/> {remark}\n    {remark}\n    <'))
    assert run("audit", "leg.xml", "--output-format", "concise", "--fail-on", "info") == 0
    assert capsys.readouterr().out == SKIPPED + "no findings in 1 file; 2 ignored in the files\n"


def test_a_baseline_is_written_again_over_part_of_a_folder(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What other runs have found stays: of another file, and by another rule; what is mended and lost does not."""
    (folder / "actspec.toml").write_text('[audit]\nselect = ["LIM101", "SGN101"]\n')
    for name in ("arm", "old", "shut"):
        (folder / f"{name}.xml").write_text(LEG)
    half = LEG.replace('name="knee"', 'name="knee" damping="-1"')
    (folder / "leg.xml").write_text(half.replace('name="hip"', 'name="hip" damping="-1"'))
    assert run("audit", ".", "--as-named", "--write-baseline", "known.json") == 0
    # Of each of four files the limits of hip and knee, of leg.xml both signs.
    assert capsys.readouterr().err.startswith("known.json: 10 findings written")
    before = json.loads(Path("known.json").read_text())["findings"]
    (folder / "old.xml").unlink()
    (folder / "leg.xml").write_text(half)
    (folder / "shut.xml").write_text(LEG[:90])
    assert run("audit", "leg.xml", "--select", "SGN101", "--write-baseline", "known.json") == 0
    assert capsys.readouterr().err.splitlines() == [
        "known.json: 1 finding written",
        "known.json: kept: 4 findings of 2 files outside of this run",
        "known.json: kept: 2 findings of 1 file, by rules that did not run or that compare with files outside of "
        "this run",
        "known.json: left out: 1 finding of 1 file, no longer found",
        "known.json: left out: 2 findings of 1 file, no longer there",
    ]
    after = json.loads(Path("known.json").read_text())["findings"]
    mended = ("SGN101", "leg.xml", "hip")
    assert after == [
        entry
        for entry in before
        if entry["file"] != "old.xml" and (entry["code"], entry["file"], entry["joint"]) != mended
    ]
    # A file that cannot be read has its entries still, beside that it cannot.
    assert run("audit", "shut.xml", "--write-baseline", "known.json") == 0
    capsys.readouterr()
    entries = json.loads(Path("known.json").read_text())["findings"]
    assert [entry["code"] for entry in entries if entry["file"] == "shut.xml"] == [
        "AUD008",
        "LIM101",
        "LIM101",
    ]


def test_a_lost_file_of_the_baseline_fails(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Where a warning does: it is there, in the words of --fail-on, until the baseline is written again."""
    (folder / "arm.xml").write_text(LEG)
    assert run("audit", ".", "--as-named", "--write-baseline", "known.json") == 0
    (folder / "arm.xml").unlink()
    lost = ("audit", ".", "--as-named", "--baseline", "known.json")
    assert [run(*lost, "--fail-on", severity) for severity in ("info", "warning", "error", "never")] == [
        1,
        1,
        0,
        0,
    ]
    assert (
        "AUD021 [warning]: the baseline has findings of arm.xml, which is not there: LIM101"
        in capsys.readouterr().err
    )
    assert run("audit", ".", "--as-named", "--write-baseline", "known.json") == 0
    assert run(*lost, "--fail-on", "warning") == 0


def test_a_part_of_the_files_tells_of_nothing_that_needs_the_others(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Two files of a walker have another limit at the knee: of one of them alone nobody knows that it has gone, though
    the rule has two files of a crawler to look at. The baseline names both, for each has a sign that is wrong.
    """
    (folder / "actspec.toml").write_text('[audit]\nselect = ["SRC101", "SGN101"]\nbaseline = "known.json"\n')
    limit = '<motor joint="{}" forcerange="-{} {}" forcelimited="true"/>'
    for name, foot, knee in (
        ("walker", "toe", 9),
        ("walker_two", "toe", 18),
        ("crawler", "heel", 9),
        ("crawler_two", "heel", 9),
    ):
        drives = "".join(limit.format(*each) for each in (("hip", 9, 9), ("knee", knee, knee), (foot, 9, 9)))
        (folder / f"{name}.xml").write_text(
            f'<mujoco model="{name.partition("_")[0]}"><worldbody><body><joint name="hip" damping="-1"/>'
            '<geom size="0.1"/><body><joint name="knee"/><geom size="0.1"/>'
            f'<body><joint name="{foot}"/><geom size="0.1"/></body></body>'
            f"</body></worldbody><actuator>{drives}</actuator></mujoco>"
        )
    crawlers = ("crawler.xml", "crawler_two.xml")
    assert run("audit", "walker.xml", "walker_two.xml", *crawlers, "--write-baseline", "known.json") == 0
    before = json.loads(Path("known.json").read_text())["findings"]
    assert {entry["code"] for entry in before} == {"SRC101", "SGN101"}
    capsys.readouterr()
    for name in ("walker.xml", "walker_two.xml"):
        assert run("audit", name, *crawlers) == 0
        found = capsys.readouterr()
        assert "AUD007" not in found.err and "did not apply" not in found.out
        assert run("audit", name, *crawlers, "--write-baseline", "known.json") == 0
        assert json.loads(Path("known.json").read_text())["findings"] == before
        capsys.readouterr()


@pytest.mark.parametrize(
    "text", ["garbage", "joints: [", "\x00\x01", "actspec: 1\nrobot: {model: none.xml}\n"]
)
def test_a_spec_that_cannot_be_read_is_no_spec_to_hold_files_to(
    text: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The rest is reported, and the exit code says that not all was done that was asked for."""
    (folder / "bin.yaml").write_text(text)
    for more in ((), ("--exit-zero",), ("--fail-on", "never")):
        assert run("audit", "leg.xml", "--spec", "bin.yaml", "--output-format", "concise", *more) == 2
        assert "AUD008" in capsys.readouterr().out


def test_baseline(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What is written is hidden afterwards, also when lines move; what has gone is told."""
    assert run("audit", "leg.xml", "--write-baseline", "known.json", "--fail-on", "info") == 0
    assert capsys.readouterr() == (
        "",
        "known.json: 2 findings written: shown as 1 warning affecting 2 joints\n",
    )
    (folder / "leg.xml").write_text("\n\n" + LEG)
    assert (
        run("audit", "leg.xml", "--baseline", "known.json", "--fail-on", "info", "--output-format", "concise")
        == 0
    )
    assert capsys.readouterr().out == SKIPPED + "no findings in 1 file; 2 in the baseline\n"
    (folder / "actspec.toml").write_text('[audit]\nselect = ["LIM"]\nbaseline = "known.json"\n')
    (folder / "leg.xml").write_text(LEG.replace('<motor joint="hip"/>', ""))
    assert run("audit", "leg.xml", "--fail-on", "warning") == 1
    err = capsys.readouterr().err
    assert "AUD023 [warning]: no actuator drives hip any more" in err and "AUD007" not in err
    (folder / "leg.xml").write_text(
        LEG.replace('<motor joint="hip"/>', '<motor joint="hip" forcerange="-9 9"/>')
    )
    assert run("audit", "leg.xml") == 0
    assert capsys.readouterr().err == (
        "known.json: AUD007 [warning]: LIM101 is in the baseline and is no longer found in leg.xml (hip)\n"
        "  help: write the baseline again with --write-baseline known.json\n"
    )
    assert run("audit", "leg.xml", "--no-baseline", "--fail-on", "warning") == 1
    assert "LIM101" in capsys.readouterr().out
    # Written anew it does not hide itself first.
    assert run("audit", "leg.xml", "--write-baseline", "known.json") == 0
    assert len(json.loads((folder / "known.json").read_text())["findings"]) == 1


def test_fix_and_diff_without_fixes(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Where nothing can be fixed nothing is written, --diff is clean, and both say so."""
    assert run("audit", "leg.xml", "--diff") == 0
    assert capsys.readouterr() == ("", "nothing to fix\n")
    assert run("audit", "leg.xml", "--fix", "--unsafe-fixes", "--fail-on", "warning") == 1
    assert capsys.readouterr().err == "nothing to fix\n"
    text = LEG.replace('<motor joint="hip"/>', '<motor joint="hip" delay="0.02" nsample="2"/>')
    Path("delay.xml").write_text(text)
    for option in ("--fix", "--diff"):
        assert run("audit", "delay.xml", "--select", "DLY102", option) == (1 if option == "--fix" else 0)
        assert (
            capsys.readouterr().err.splitlines()[-1]
            == "nothing to fix without --unsafe-fixes, 1 finding with it"
        )
    assert Path("delay.xml").read_text() == text
    assert (folder / "leg.xml").read_text() == LEG


def test_ledger_and_statistics(capsys: pytest.CaptureFixture[str]) -> None:
    """--ledger stands before the findings, --statistics in their place."""
    assert run("audit", "leg.xml", "--ledger", "--statistics") == 0
    out = capsys.readouterr().out
    assert out.startswith("leg.xml (leg)\n  joints  control  effort  inertia")
    assert out.endswith(f"\n1  LIM101  no-effective-limit  warning\n{SKIPPED}{COUNT}")


@pytest.mark.slow
def test_as_a_process(folder: Path) -> None:
    """A pipe gets plain text, and what its encoding has no character for is escaped."""
    paths = os.pathsep.join([str(ROOT), *sys.path])
    (folder / "bén.xml").write_text(LEG)
    done = subprocess.run(
        [sys.executable, "-m", "actspec", "audit", "bén.xml", "--output-format", "concise"],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": paths, "PYTHONIOENCODING": "ascii"},
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == HEADLINE.replace("leg", "b\\xe9n") + SKIPPED + COUNT


class Terminal:
    """A stream that says it is a terminal."""

    def __init__(self) -> None:
        self.text = ""

    def isatty(self) -> bool:
        return True

    def write(self, text: str) -> int:
        self.text += text
        return len(text)

    def flush(self) -> None:
        """Nothing waits."""


@pytest.mark.parametrize("no_color, coloured", [("", True), ("1", False)], ids=["terminal", "NO_COLOR"])
def test_colour(no_color: str, coloured: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """A terminal gets colour, unless NO_COLOR is set."""
    terminal: Any = Terminal()
    terminal.encoding = "utf-8"
    monkeypatch.setattr(sys, "stdout", terminal)
    monkeypatch.setenv("NO_COLOR", no_color)
    assert run("audit", "leg.xml") == 0
    assert ("\x1b[33mLIM101\x1b[0m" in terminal.text) == coloured


def test_progress(monkeypatch: pytest.MonkeyPatch) -> None:
    """A bar after two seconds, taken away at the end; before that, and without a terminal, nothing."""
    terminal: Any = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    now = 0.0
    with Progress("reading", lambda: now) as progress:
        for now, done in ((1.9, 1), (2.0, 5), (2.05, 6), (2.2, 10)):  # noqa: B007
            progress.step(done, 10)
    assert terminal.text == (
        "\rreading [###############...............] 5/10\rreading [##############################] 10/10\r\x1b[K"
    )
    monkeypatch.setattr(terminal, "isatty", lambda: False)
    terminal.text, now = "", 0.0
    with Progress("reading", lambda: now) as progress:
        now = 9.0
        progress.step(1, 10)
    assert terminal.text == ""


def test_progress_of_a_long_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """A bar appears while a step of the work takes long, too, and tells how far the work was before."""
    terminal: Any = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr("actspec.report.terminal._TICK", 0.01)
    now = 0.0
    with Progress("verifying", lambda: now) as progress, progress.ticking():
        progress.step(1, 3)
        assert terminal.text == ""
        now = 2.5
        while not terminal.text:
            pass
    assert terminal.text.startswith("\rverifying [##########....................] 1/3")


# --- actspec rule --------------------------------------------------------------------------------


def test_rule(capsys: pytest.CaptureFixture[str]) -> None:
    """A code, a name or a family prints pages, in the order of the codes."""
    assert run("rule", "no-effective-limit") == 0
    first = capsys.readouterr().out
    assert first.startswith("# LIM101 no-effective-limit\n\nA joint has no limit")
    assert run("rule", "LIM107", "LIM101") == 0
    both = capsys.readouterr().out
    assert both.startswith(first)
    assert "# LIM107 saturation-below-limit" in both


@pytest.mark.parametrize("selector", ["ACT002", "unused-ignore"])
def test_rule_that_is_none_any_more(selector: str, capsys: pytest.CaptureFixture[str]) -> None:
    """A code of what is reported about remarks is explained in a line, whatever it is called by."""
    assert run("rule", selector) == 0
    said = capsys.readouterr().out
    assert said.startswith("ACT002 unused-ignore\n") and "no rule" in said


def test_rule_of_any_case(capsys: pytest.CaptureFixture[str]) -> None:
    """`lim101` is LIM101, and a code of a table in the docs says in which; one that cannot be is refused."""
    assert run("rule", "LIM101") == 0
    page = capsys.readouterr().out
    assert run("rule", "lim101") == 0
    assert capsys.readouterr().out == page
    for code in ("sys031", "LOG004"):
        assert run("rule", code) == 0
        said = capsys.readouterr().out
        assert said.startswith(f"{code.upper()}\n") and "docs/sysid.md" in said
        assert f"| {code.upper()} |" in (ROOT / "docs" / "sysid.md").read_text("utf-8")
    assert run("rule", "sys31") == 2


@pytest.mark.parametrize(
    ("code", "page"),
    [
        ("SPEC110", "checks"),
        ("NET008", "checks"),
        ("DMP002", "checks"),
        ("DRF002", "import"),
        ("VFY112", "verify"),
    ],
)
def test_rule_of_a_code_of_another_command(code: str, page: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Whoever met it in `compile` or `import` learns where it is explained; of a rule that there is not nothing is."""
    assert run("rule", code) == 0
    said = capsys.readouterr().out
    assert said.startswith(f"{code}\n\nThis is no rule: ") and f"docs/{page}.md" in said
    assert code in (ROOT / "docs" / f"{page}.md").read_text("utf-8")
    assert run("rule", "DEPLOY001") == 0
    assert capsys.readouterr().out.startswith("DEPLOY001 list-length\n\nThis is no rule: ")
    assert run("rule", "SYSID101") == 2
    help = "SYS and a number: `sysid` reports it. docs/sysid.md says when, and what helps."
    assert capsys.readouterr().err.splitlines()[1:2] == [f"  help: {help}"]
    for wrong in ("DMP199", "NET999"):
        assert run("rule", wrong) == 2


def test_rules_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    """All rules for programs, in the form of the schema; an error too."""
    assert run("rule", "--all", "--output-format", "json") == 0
    record = json.loads(capsys.readouterr().out)
    fits("rules", record)
    found = {rule["code"]: rule for rule in record["rules"]}
    assert found["LIM101"]["options"] == {"least": 1e5}
    assert list(found["LIM101"]["sections"])[:3] == ["What it does", "Why it matters", "Example"]
    assert run("rule", "LIN101", "--output-format", "json") == 2
    fits("rules", json.loads(capsys.readouterr().out))


def test_rule_errors(capsys: pytest.CaptureFixture[str]) -> None:
    """A code that is not there is answered with the nearest; no code with how to ask."""
    assert run("rule", "LIN101") == 2
    assert "did you mean 'LIM101'?" in capsys.readouterr().err
    assert run("rule") == 2
    assert "names no rule" in capsys.readouterr().err


def test_rule_docs(folder: Path) -> None:
    """--docs writes every page and the index."""
    assert run("rule", "--docs", "pages") == 0
    names = {path.name for path in (folder / "pages").iterdir()}
    assert {"README.md", "lim101.md", "dmp101.md"} <= names
    (folder / "file").write_text("")
    assert run("rule", "--docs", "file") == 2
