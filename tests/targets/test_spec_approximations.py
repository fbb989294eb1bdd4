"""What the spec approximates itself goes through a compile as a target's losses do, once for all targets."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from actspec.cli.main import main
from actspec.diagnostics import EXIT_CLEAN, EXIT_FINDINGS

MODEL = """<mujoco><option timestep="0.002" integrator="implicitfast"/><worldbody><body>
<joint name="pitch" axis="0 1 0"/><joint name="roll" axis="1 0 0"/><geom type="sphere" size="0.05" mass="1"/>
</body></worldbody></mujoco>"""

SPEC = """actspec: 1
robot: {name: ankle, model: ankle.xml}
motors: {rod: {side: joint, peak_torque: 25 N*m, reflected_inertia: 0.004 kg*m^2}}
linkages: {ankle: {joints: [pitch, roll], motors: [rod, rod], jacobian: [[1, 0.6], [1, -0.6]], at: any}}
actuators: {ankle: {joints: [pitch, roll], level: ideal_pd, kp: 40, kd: 1, friction: {coulomb: 0, viscous: 0}}}
targets: {mujoco: {}, isaaclab: {}, mjlab: {}, deploy: {}}
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with the robot and its spec."""
    (tmp_path / "ankle.xml").write_text(MODEL)
    (tmp_path / "ankle.yaml").write_text(SPEC)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_told_once_for_all_targets(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The JSON of a compile has one entry a joint, the manifest of every target both."""
    assert main(["compile", "ankle.yaml", "--output-format", "json"]) == EXIT_CLEAN
    losses = json.loads(capsys.readouterr().out)["approximations"]
    # Alone 2 x 25 and 2 x 25 x 0.6; both at once ask for twice the motors' torque.
    assert [
        (loss["target"], loss["joint"], loss["field"], loss["max_torque_error"])
        for loss in losses
        if loss["target"] == "spec"
    ] == [
        ("spec", "pitch", "linkage_limits", pytest.approx(25.0)),
        ("spec", "roll", "linkage_limits", pytest.approx(15.0)),
    ]
    for target in ("mujoco", "isaaclab", "mjlab", "deploy"):
        record = json.loads((folder / "build" / "ankle" / target / "manifest.json").read_text())
        assert [loss["joint"] for loss in record["approximations"] if loss["target"] == "spec"] == [
            "pitch",
            "roll",
        ]


def test_strict_asks_for_its_reason(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`--strict` refuses until `accept` has `spec.linkage_limits`."""
    assert main(["compile", "ankle.yaml", "--strict"]) == EXIT_FINDINGS
    assert "  spec.linkage_limits (2 joints)\n" in capsys.readouterr().err
    (folder / "ankle.yaml").write_text(f"{SPEC}accept: {{spec.linkage_limits: roll stays small}}\n")
    assert main(["compile", "ankle.yaml", "--strict"]) == EXIT_CLEAN
    assert "spec.linkage_limits" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("reason", "held"),
    [
        ("roll stays small", True),
        # 25 N*m at the pitch, 15 at the roll; a reason rounds by a tenth.
        ("up to 25 N*m, which nobody asks for", True),
        ("at most 23 N*m", True),
        ("at most 22 N*m", False),
        ("up to 2.5 N*m", False),
        # Of several the largest; and no torque.
        ("up to 2.5 N*m at rest, up to 25 N*m in a fall", True),
        ("up to 2.5 N*m/rad softer", True),
        ("up to 4 ms late", True),
        ("roll stays below 8 N*m", True),
    ],
)
def test_a_reason_that_states_a_bound(
    folder: Path, capsys: pytest.CaptureFixture[str], reason: str, held: bool
) -> None:
    """What has grown beyond what was accepted is not accepted."""
    (folder / "ankle.yaml").write_text(f'{SPEC}accept: {{spec.linkage_limits: "{reason}"}}\n')
    assert main(["compile", "ankle.yaml", "--strict"]) == (EXIT_CLEAN if held else EXIT_FINDINGS)
    said = capsys.readouterr()
    assert ("1 approximation, accepted" in said.out) is held
    told = (
        "ankle.yaml:7:31: SPEC165 [warning] accept.spec.linkage_limits: the torque error is up to 25 N*m (pitch), "
        "more than this reason says: it is not accepted"
    )
    assert (told in said.err) is not held


def test_accept_that_takes_nothing(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A key of the spec's own that is misspelt is named, with the right one."""
    (folder / "ankle.yaml").write_text(f"{SPEC}accept: {{spec.linkage_limit: roll stays small}}\n")
    assert main(["compile", "ankle.yaml"]) == EXIT_CLEAN
    said = capsys.readouterr().err
    assert "SPEC164 [warning] accept.spec.linkage_limit: the spec itself has no approximation" in said
    assert "did you mean 'spec.linkage_limits'?" in said


def test_show(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`show` names the motors of the linkage and what it simplifies."""
    assert main(["show", "ankle.yaml", "roll"]) == EXIT_CLEAN
    said = capsys.readouterr().out
    assert "motor rod by the linkage ankle)" in said
    assert "approximated, spec.linkage_limits: 30 N*m that it shares with pitch -> " in said
    assert "; torque error 15 N*m (" in said
