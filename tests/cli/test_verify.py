"""`actspec verify`: exit codes, formats, and what it says when it cannot run."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from actspec import api
from actspec.cli.main import main
from actspec.ir import Approximation
from actspec.report.verify import text as report
from actspec.verify.agreement import Agreement, Row, Skip
from actspec.verify.response import SOFT
from tests.schemas import fits
from tests.verify.making import MODEL, SPEC

ROOT = Path(__file__).resolve().parents[2]
TARGETS = 'targets: {mujoco: {version: "3.12"}, isaaclab: {version: "2.3"}, deploy: {}}\n'


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working folder with a spec of three targets, and no engines prepared."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ACTSPEC_ENGINES", str(tmp_path / "engines"))
    (tmp_path / "rich.xml").write_text(MODEL, "utf-8")
    (tmp_path / "rich.yaml").write_text(SPEC[: SPEC.index("targets:")] + TARGETS, "utf-8")
    return tmp_path


def run(*arguments: str) -> int:
    """Run the command on the spec."""
    return main(["verify", "rich.yaml", *arguments])


def record(capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    """The JSON that was printed, which its schema describes."""
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    fits("verify", found)
    return found


@pytest.mark.slow
def test_agreement(capsys: pytest.CaptureFixture[str], folder: Path) -> None:
    """MuJoCo is asked, what is not here is said with what would bring it, nothing is left, and the exit code is 0."""
    assert run() == 0
    out = capsys.readouterr().out
    assert "  mujoco 3.12   hips                    2  mujoco " in out
    (missed,) = [line.split("  ") for line in out.splitlines() if "not prepared" in line]
    assert [part.strip() for part in missed if part] == [
        "isaaclab",
        "Isaac Lab 2.3.2.post1 is not prepared",
        "actspec verify --setup SPEC",
    ]
    assert out.splitlines()[-1] == (
        "1 target agrees within known approximations (up to 7.872 N*m, as `compile` has it), "
        "1 was read back and not run (deploy), 1 was read back and not run (isaaclab) within known approximations "
        "(up to 67.5 N*m, as `compile` has it); "
        "the torque of 1 of 3 was computed by the simulator's own code"
    )
    assert sorted(path.name for path in folder.iterdir()) == ["rich.xml", "rich.yaml"]


@pytest.mark.slow
@pytest.mark.usefixtures("processes")
def test_without_usd_core(
    capsys: pytest.CaptureFixture[str], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An overlay that nobody can read is a gap beside other targets, and an error where there is nothing else."""
    monkeypatch.setattr("actspec.robot.usda.find_spec", lambda name: None)
    (folder / "rich.yaml").write_text(SPEC[: SPEC.index("targets:")] + "targets: {deploy: {}, newton: {}}\n")
    reason, help = "a .usda layer is read with usd-core, which is not installed", "pip install 'actspec[usd]'"
    assert run() == 0
    out = capsys.readouterr().out
    missed = [" ".join(line.split()) for line in out.splitlines() if reason in line]
    assert missed == [f"newton, fields {reason} {help}"]
    assert out.splitlines()[-1].startswith("1 target was read back and not run (deploy); ")
    assert run("-t", "newton") == 2
    found = capsys.readouterr()
    assert found.out == ""
    assert found.err.splitlines() == [
        f"USDA004 targets.newton: {reason}", f"  help: {help}", "1 error"
    ]  # fmt: skip
    assert run("--require-engines") == 2
    assert f"VFY002 targets.newton: {reason}" in capsys.readouterr().err


@pytest.mark.slow
def test_json(capsys: pytest.CaptureFixture[str]) -> None:
    """Rows with torque and fields, skips, approximations; a loss without size is in no number."""
    assert run("--output-format", "json") == 0
    found = record(capsys)
    torque = next(row for row in found["rows"] if row["quantity"] == "torque" and row["joint"] == "lift")
    assert (torque["target"], torque["group"], torque["unit"], torque["ok"]) == ("mujoco", "lift", "N", True)
    assert torque["engine"].startswith("mujoco ") and torque["at"]["error"] is None
    kp = next(row for row in found["rows"] if row["quantity"] == "kp" and row["joint"] == "left_knee")
    assert (kp["expected"], kp["got"], kp["engine"], kp["at"]) == (60.0, 60.0, None, None)
    assert [skip["setup"] for skip in found["skipped"] if skip["target"] == "isaaclab"] == [True]
    assert {loss["field"] for loss in found["approximations"]} >= {"command_filter", "encoder_bias"}


@pytest.mark.slow
def test_edited_file(capsys: pytest.CaptureFixture[str], folder: Path) -> None:
    """A file of a build folder that somebody edited is a disagreement, at its line, with exit code 1."""
    assert main(["compile", "rich.yaml", "-o", "out"]) == 0
    assert run("--built", "out", "--fields-only") == 0
    path = folder / "out" / "isaaclab" / "rich_cfg.py"
    text = path.read_text("utf-8").replace("effort_limit=22.5", "effort_limit=1e9")
    path.write_text(text, "utf-8")
    line = text[: text.index("effort_limit=1e9")].count("\n") + 1
    capsys.readouterr()
    assert run("--built", "out", "--fields-only") == 1
    out = capsys.readouterr().out
    place = str(Path("out", "isaaclab", "rich_cfg.py"))
    assert f"{place}:{line}:" in out
    assert (
        "VFY104 isaaclab left_hip and 1 more: the effort limit is 1e9 N*m, and should be 22.5 N*m: "
        "the limit is lost"
    ) in out
    assert run("--built", "out", "--fields-only", "-t", "deploy") == 0
    # one target's own folder does as well
    assert run("--built", "out/isaaclab", "--fields-only", "-t", "isaaclab") == 1


def test_missing_file(capsys: pytest.CaptureFixture[str]) -> None:
    """A build folder without a file of a target cannot be verified: exit code 2, every file reported."""
    assert run("--built", "nowhere") == 2
    err = capsys.readouterr().err
    assert err.count("VFY001") == 3
    assert "targets.isaaclab: there is no such file, and the spec compiles to it" in err
    assert err.splitlines()[-1] == "3 errors"


def test_strict(capsys: pytest.CaptureFixture[str]) -> None:
    """Approximations that the spec does not accept are an exit code of 1 with --strict alone."""
    assert run("--fields-only") == 0
    assert "--strict" not in capsys.readouterr().err
    assert run("--fields-only", "--strict") == 1
    # As `compile --strict` says it.
    refused = capsys.readouterr().err
    assert refused.startswith("--strict: ") and " that the spec does not accept\n" in refused


@pytest.mark.slow
def test_engines_can_be_required(capsys: pytest.CaptureFixture[str]) -> None:
    """With --require-engines what is not prepared is an exit code of 2."""
    assert run("--require-engines", "-t", "mujoco") == 0
    capsys.readouterr()
    assert run("--require-engines") == 2
    assert "VFY002 targets.isaaclab: Isaac Lab 2.3.2.post1 is not prepared" in capsys.readouterr().err


@pytest.mark.parametrize(
    "arguments, message",
    [
        ([], "no spec is named"),
        (["rich.yaml", "rich.yaml", "--built", "out"], "one folder of files is of one spec"),
        (["rich.yaml", "--fields-only", "--require-engines"], "no engine is run with --fields-only"),
        (["rich.yaml", "--run-edited"], "no edited file is run without --built"),
        (
            ["rich.yaml", "--built", "out", "--run-edited", "--fields-only"],
            "nothing is run with --fields-only",
        ),
        (["rich.yaml", "-t", "isaaclap"], "no target is named 'isaaclap'"),
        (["gone.yaml"], "gone.yaml"),
    ],
    ids=["no spec", "two specs", "contradiction", "no files", "nothing run", "target", "file"],
)
def test_options(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    """What cannot be done is said, with exit code 2."""
    assert main(["verify", *arguments]) == 2
    assert message in capsys.readouterr().err


def test_failure_in_json(capsys: pytest.CaptureFixture[str]) -> None:
    """A failure is JSON too."""
    assert run("--built", "nowhere", "--output-format", "json") == 2
    assert {item["code"] for item in record(capsys)["diagnostics"]} == {"VFY001"}


@pytest.mark.slow
def test_markdown(capsys: pytest.CaptureFixture[str]) -> None:
    """A table for a page."""
    assert run("--output-format", "markdown", "-t", "mujoco") == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "### rich"
    assert lines[2].startswith("| target | group | joints | engine |")
    assert all(line.count("|") == lines[2].count("|") for line in lines[2:8])


def test_edited_python_is_not_executed(capsys: pytest.CaptureFixture[str], folder: Path) -> None:
    """The table says that an edited cfg was not run, and what would run it; a remark is no disagreement."""
    assert main(["compile", "rich.yaml", "-o", "out"]) == 0
    path = folder / "out" / "isaaclab" / "rich_cfg.py"
    path.write_text(path.read_text("utf-8") + "# mine\n", "utf-8")
    capsys.readouterr()
    assert run("--built", "out", "-t", "isaaclab") == 0
    out = capsys.readouterr().out
    assert (
        "rich_cfg.py is not what the spec compiles to, and would be executed: only its fields are compared"
        in out
    )
    assert "look at it, then --run-edited" in out
    assert run("--built", "out", "-t", "isaaclab", "--run-edited") == 0
    assert "only its fields" not in capsys.readouterr().out


def test_github(capsys: pytest.CaptureFixture[str], folder: Path) -> None:
    """An annotation at the edited line, or at the spec where no file is there; what is not asked is a notice."""
    assert main(["compile", "rich.yaml", "-o", "out"]) == 0
    path = folder / "out" / "isaaclab" / "rich_cfg.py"
    text = path.read_text("utf-8").replace("effort_limit=22.5", "effort_limit=1e9")
    path.write_text(text, "utf-8")
    line = text[: text.index("effort_limit=1e9")].count("\n") + 1
    capsys.readouterr()
    arguments = ("--built", "out", "--fields-only", "-t", "isaaclab", "--output-format", "github")
    assert run(*arguments) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == (
        f"::error title=VFY104 isaaclab,file=out/isaaclab/rich_cfg.py,line={line},col=22::left_hip and 1 more: "
        "the effort limit is 1e9 N*m, and should be 22.5 N*m: the limit is lost"
    )
    assert lines[-1].startswith("::error title=rich,file=rich.yaml::1 disagreement in isaaclab; ")
    assert run("--fields-only", "-t", "deploy", "--output-format", "github") == 0
    assert [line.partition(" ")[0] for line in capsys.readouterr().out.splitlines()] == ["::notice"]
    assert run("--fields-only", "--strict", "--output-format", "github") == 1
    out = capsys.readouterr().out
    assert (
        "::error title=isaaclab.command_filter is not accepted,file=rich.yaml::left_knee command_filter: "
        in out
    )


def test_setup_says_what_it_would_do(capsys: pytest.CaptureFixture[str], folder: Path) -> None:
    """What, where, how large and how long is said first; without a terminal only --yes installs it."""
    assert main(["verify", "--setup", "rich.yaml"]) == 2
    out = capsys.readouterr()
    assert f"to be installed below {folder / 'engines'}" in out.out
    assert "2.4 GB" in out.out and "minutes" in out.out
    assert out.err == "use --yes to install it\n"
    assert not (folder / "engines").exists()


def test_setup_of_a_spec_that_needs_nothing(capsys: pytest.CaptureFixture[str], folder: Path) -> None:
    """A spec whose targets the installed MuJoCo can run needs no more."""
    assert main(["verify", "--setup", "rich.yaml", "-t", "mujoco==4.0", "-t", "deploy"]) == 0
    assert capsys.readouterr().out == "nothing is missing\n"


@pytest.mark.slow
def test_setup_without_a_registry(
    capsys: pytest.CaptureFixture[str], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Offline the reason is reported, exit code 2, and nothing that counts is left."""
    for name, value in (
        ("PIP_NO_INDEX", "1"),
        ("PIP_CONFIG_FILE", "/dev/null"),
        ("PIP_FIND_LINKS", "/dev/null"),
    ):
        monkeypatch.setenv(name, value)
    # gains in volts, which the installed MuJoCo reads otherwise
    assert main(["verify", "--setup", "rich.yaml", "-t", "mujoco==3.9", "--yes"]) == 2
    err = capsys.readouterr().err
    assert "VFY003 --setup: not installed: mujoco 3.9.0: ERROR" in err
    assert [p.name for p in (folder / "engines").iterdir() if p.suffix != ".lock"] == []


def test_the_last_line_does_not_call_an_approximation_agreement(folder: Path) -> None:
    """Targets that agree, those that do within what the spec accepts, and the largest torque error of these."""

    def said(losses: tuple[str, ...], accept: str) -> str:
        text = SPEC[: SPEC.index("targets:")] + TARGETS
        (folder / "rich.yaml").write_text(
            text[: text.index("accept:")] if "accept:" in text else text, "utf-8"
        )
        done = api.compile("rich.yaml")
        taken = replace(done.actuators, accept=((accept, "a reason"),) if accept else ())
        rows = (
            Row("mujoco", "hips", "hip", 2, "torque", "N*m", 1e-9, 1e-8, True),
            Row(
                "isaaclab",
                "hips",
                "hip",
                2,
                "torque",
                "N*m",
                0.3,
                0.4,
                True,
                approximations=losses,
                usual_error=0.02,
            ),
            Row(
                "isaaclab",
                "hips",
                "hip",
                2,
                "torque.step",
                "N*m",
                40.0,
                41.0,
                True,
                approximations=losses,
                usual_error=0.3,
            ),
            Row("deploy", "hips", "hip", 2, "kp", "N*m/rad", 0.0, 0.0, True),
        )
        return list(report(replace(done, actuators=taken), Agreement(rows, ())))[-1].partition(";")[0]

    read = "1 was read back and not run (deploy)"
    assert said((), "") == f"2 targets agree with the spec, {read}"
    lost = sorted({loss.key for loss in api.compile("rich.yaml").approximations})
    known = next((key for key in lost if key.startswith("isaaclab.")), "isaaclab.delay")
    size = "(largest 40 N*m, 0.3 N*m inside the ranges of command and speed)"
    agreed = f"1 target agrees with the spec, 1 within accepted approximations {size}, {read}"
    assert said((known,), known) == agreed
    if known in lost:
        assert said((known,), "") == agreed.replace("accepted", "known")
    # What the engine's own soft friction costs is no loss of the target.
    assert said((SOFT,), "") == f"2 targets agree with the spec, {read}"


def test_what_the_spec_itself_loses_is_told_beside_the_targets(folder: Path) -> None:
    """The law has it already: `compile` has 82 N*m of it in its last line, the targets 0.25 N*m; the larger is told."""
    (folder / "rich.yaml").write_text(SPEC[: SPEC.index("targets:")] + TARGETS, "utf-8")
    done = api.compile("rich.yaml")
    own = tuple(
        Approximation("spec", joint, "linkage_pose", "a", "b", "c", error)
        for joint, error in (("hip", 82.0), ("knee", 3.0))
    )
    key = "mujoco.delay.range"
    row = Row("mujoco", "hips", "hip", 2, "torque", "N*m", 0.25, 0.5, True, approximations=(key,))
    open_ = Approximation("mujoco", "hip", "delay.range", "a", "b", "c", 0.5)

    def said(own: tuple[Approximation, ...], losses: tuple[Approximation, ...]) -> list[str]:
        emissions = (replace(done.emissions[0], approximations=losses),)
        actuators = replace(done.actuators, approximations=own, accept=())
        made = replace(done, actuators=actuators, targets=done.targets[:1], emissions=emissions)
        return list(report(made, Agreement((row,), (), losses)))

    lines = said(own, (open_,))
    assert (
        "; the spec itself approximates linkage_pose (up to 82 N*m), alike in every target; the" in lines[-1]
    )
    assert "  known approximations (see --strict and `accept`)" in lines
    lines = said((), ())
    assert "the spec itself" not in lines[-1]
    assert "  known approximations, as the spec accepts" in lines


def test_the_table_of_the_page_has_the_fields_that_are_compared(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """docs/verify.md shows the A1: each of its targets, with the fields of its files and those that its engine tells.

    Engines, which this test does not run, tell of the objects that they made: Isaac Lab 1, mjlab and Newton 3 each.
    """
    monkeypatch.chdir(ROOT)
    assert main(["verify", "robots/a1.yaml", "--fields-only", "--output-format", "markdown"]) == 0

    def fields(text: str, column: int) -> dict[str, int]:
        lines = text[text.index("| target |") :].partition("\n\n")[0].splitlines()[2:]
        rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
        return {row[0]: int(row[column]) for row in rows}

    page = (ROOT / "docs" / "verify.md").read_text(encoding="utf-8")
    run = {"isaaclab 2.3": 1, "mjlab 1.6": 3, "newton 1.8": 3}
    read = fields(capsys.readouterr().out, 7)
    shown = fields(page, 7)
    assert list(shown) == ["mujoco 3.12", *run, "deploy", "randomization"]
    # Without usd-core Newton's is not read.
    assert {target: shown[target] - run.get(target, 0) for target in read} == read


def test_the_last_line_tells_what_was_only_read_back(folder: Path) -> None:
    """What ran no simulator agrees with nothing; what it is known to lose is told by the compilation's own bound."""
    (folder / "rich.yaml").write_text(SPEC[: SPEC.index("targets:")] + TARGETS, "utf-8")
    done = api.compile("rich.yaml")
    losses = tuple(
        Approximation("randomization", "hip", "kp", "a", "b", "c", error) for error in (0.25, 5.5, None)
    )
    rows = tuple(
        Row(name, "hips", "hip", 2, "kp", "N*m/rad", 0.0, 0.0, True) for name in ("deploy", "randomization")
    )

    def said(rows: tuple[Row, ...], accept: tuple[tuple[str, str], ...]) -> str:
        taken = replace(done, actuators=replace(done.actuators, accept=accept, approximations=losses))
        return list(report(taken, Agreement(rows, (), losses)))[-1].partition(";")[0]

    bounded = "was read back and not run (randomization) within accepted approximations"
    size = "(up to 5.5 N*m, as `compile` has it)"
    accept = (("randomization.kp", "a reason"),)
    assert said(rows, accept) == f"1 target was read back and not run (deploy), 1 {bounded} {size}"
    assert said(rows[1:], accept) == f"1 target {bounded} {size}"
    assert said(rows[1:], ()) == f"1 target {bounded} {size}".replace("accepted", "known")
    # A loss without a torque, such as a velocity limit, is one whatever was run: `compile` names it, too.
    losses = losses[2:]
    assert said(rows[1:], accept) == f"1 target {bounded}"
    run = Row("randomization", "hips", "hip", 2, "torque", "N*m", 1e-9, 1e-8, True)
    assert said((run,), accept) == "1 target agrees within accepted approximations"
    assert said((run,), ()) == "1 target agrees within known approximations"


def test_the_last_line_tells_what_was_not_run(folder: Path) -> None:
    """Of what was run: other targets are said to be read back, whatever was not asked of them."""
    (folder / "rich.yaml").write_text(SPEC[: SPEC.index("targets:")] + TARGETS, "utf-8")
    done = api.compile("rich.yaml")
    rows = (
        Row("mujoco", "hips", "hip", 2, "torque", "N*m", 1e-9, 1e-8, True),
        Row("deploy", "hips", "hip", 2, "kp", "N*m/rad", 0.0, 0.0, True),
    )
    skipped = (
        Skip("mujoco", "hips", "responses", "the step is too coarse"),
        Skip("mujoco", "hips", "responses", "a joint does not move"),
        Skip("mujoco", "knee", "responses", "the step is too coarse"),
        Skip("mujoco", "feet", "torque", "no law"),
        Skip("deploy", "", "torque", "no engine"),
    )
    last = list(report(done, Agreement(rows, skipped)))[-1]
    assert last.split("; ")[1:-1] == [
        "not run in full: responses of mujoco hips, mujoco knee",
        "not run in full: torque of mujoco feet",
    ]


def test_a_target_that_cannot_be_compiled_stops_no_other(
    capsys: pytest.CaptureFixture[str], folder: Path
) -> None:
    """mjlab cannot have an unknown kd, deploy can: deploy is compared, mjlab's error is said; exit code 2."""
    path = folder / "rich.yaml"
    path.write_text(path.read_text("utf-8").replace("kd: 1.5", "kd: unknown"), "utf-8")
    assert run("--fields-only", "-t", "mjlab", "-t", "deploy") == 2
    said = capsys.readouterr()
    assert "MJL001" in said.err and "  deploy " in said.out
    assert said.out.splitlines()[-1].startswith("1 target was read back and not run (deploy)")
    assert "; mjlab could not be compiled; " in said.out
    assert run("--fields-only", "-t", "mjlab", "-t", "deploy", "--output-format", "json") == 2
    found = record(capsys)
    assert "MJL001" in {item["code"] for item in found["diagnostics"]}
    assert {row["target"] for row in found["rows"]} == {"deploy"}
    # Of no target anything is left to compare.
    assert run("--fields-only", "-t", "mjlab") == 2
    assert capsys.readouterr().err.endswith("1 error\n")
