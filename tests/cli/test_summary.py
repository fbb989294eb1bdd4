"""What `actspec compile` says: where the files are, what was lost, and what of it the spec accepts."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from actspec.cli.main import main

SPEC = """actspec: 1
robot: {name: arm, model: none, joints: [shoulder, elbow, slider]}
actuators:
  arm:
    joints: [shoulder, elbow]
    level: ideal_pd
    kp: 20 N*m/rad
    kd: 1 N*m*s/rad
    effort_limit: 10 N*m
    armature: 0.01 kg*m^2
    velocity_limit: 20 rad/s
    overrides: {elbow: {velocity_limit: 30 rad/s}}
  wrist:
    joints: [slider]
    level: ideal_pd
    kp: 20 N*m/rad
    kd: 1 N*m*s/rad
    effort_limit: 10 N*m
    armature: 0.01 kg*m^2
    delay: 9 ms
timing: {physics_dt: 5 ms}
targets:
  mjlab: {version: "1.6"}
"""
"""mjlab has no speed limit, and its delay is a whole number of steps: 9 ms become 10 ms."""

LIMIT = "mjlab has no speed limit of a joint; its velocity_limit is the no-load speed"
STEPS = "a delay is a whole number of steps; 1 ms more than asked"


@pytest.fixture
def spec(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Three joints without a model, in the working folder."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "arm.yaml"
    path.write_text(SPEC)
    return path


def _said(capsys: Any, *arguments: str) -> list[str]:
    capsys.readouterr()
    main(["compile", "arm.yaml", *arguments])
    out: str = capsys.readouterr().out
    return out.splitlines()


def _about(lines: list[str], start: str) -> list[str]:
    """The lines from the first that begins with `start` to the next empty one."""
    first = next(i for i, line in enumerate(lines) if line.strip().startswith(start))
    rest = lines[first:]
    return rest[: rest.index("")]


def test_each_file_has_its_path_and_state(spec: Path, capsys: Any) -> None:
    """One target: its files and its manifest; what stays the same is unchanged."""
    assert _about(_said(capsys), "target") == [
        "  target     file",
        "  mjlab 1.6  build/arm/mjlab/arm_cfg.py     written",
        "             build/arm/mjlab/manifest.json  written",
    ]
    assert _about(_said(capsys), "target") == [
        "  target     file",
        "  mjlab 1.6  build/arm/mjlab/arm_cfg.py     unchanged",
        "             build/arm/mjlab/manifest.json  unchanged",
    ]


def test_several_targets_share_the_line_of_their_manifests(spec: Path, capsys: Any) -> None:
    """A target with a name of its own says its kind; one without a version says none."""
    spec.write_text(SPEC + "  old: {target: mjlab, version: '1.5'}\n  deploy: {}\n")
    assert _about(_said(capsys, "-o", "out"), "target") == [
        "  target           file",
        "  mjlab 1.6        out/mjlab/arm_cfg.py        written",
        "  old (mjlab 1.5)  out/old/arm_cfg.py          written",
        "  deploy           out/deploy/arm_deploy.yaml  written",
        "                   out/*/manifest.json         written",
    ]


def test_losses_that_differ_in_the_number_share_a_line(spec: Path, capsys: Any) -> None:
    """Two speed limits are one line with both; how many joints, where it is not all; 120 columns."""
    lines = _said(capsys)
    # The step of 0.5 L/kp comes 1 ms late, and 0.5 x 10 N*m is missing for that time.
    told = _about(lines, "approximated")
    assert max(map(len, told)) <= 120
    assert "\n".join(told).replace("\n        ", " ").splitlines() == [
        "  approximated",
        "    mjlab.velocity_limit",
        f"      2 of 3 joints: 20 rad/s, 30 rad/s -> none ({LIMIT})",
        "    mjlab.delay",
        f"      1 of 3 joints: 9 ms -> 2 steps of 5 ms; torque error up to 5 N*m ({STEPS})",
    ]
    assert lines[-1] == "2 approximations, torque error up to 5 N*m; 0 warnings"


def test_what_is_accepted_gives_its_reason_in_one_line(spec: Path, capsys: Any) -> None:
    """An accepted loss is a row with key, size and reason; the other is still told in full."""
    spec.write_text(SPEC + "accept: {mjlab.delay: a step more}\n")
    lines = _said(capsys)
    assert _about(lines, "approximated, as") == [
        "  approximated, as the spec accepts  torque error  because",
        "  mjlab.delay                        up to 5 N*m   a step more",
    ]
    assert lines[lines.index("  approximated") + 1] == "    mjlab.velocity_limit"
    assert "    mjlab.delay" not in lines
    assert lines[-1] == "2 approximations, 1 not accepted, torque error up to 5 N*m; 0 warnings"


def test_all_accepted(spec: Path, capsys: Any) -> None:
    """With every loss accepted nothing is left to tell in full; a size that is none is a dash."""
    spec.write_text(SPEC + "accept: {mjlab.delay: a step more, mjlab.velocity_limit: never that fast}\n")
    lines = _said(capsys)
    assert "  mjlab.velocity_limit               -             never that fast" in lines
    assert "  approximated" not in lines
    assert lines[-1] == "2 approximations, accepted, torque error up to 5 N*m; 0 warnings"


def test_nothing_lost(spec: Path, capsys: Any) -> None:
    """Without a loss the summary ends with one line that says so."""
    lines = _said(capsys, "-t", "deploy")
    assert not [line for line in lines if line.strip().startswith("approximated")]
    assert lines[-1] == "no approximation; 0 warnings"


def test_what_strict_refuses_is_counted_as_above(spec: Path, capsys: Any) -> None:
    """Two approximations, of three joints: the summary and --strict have one count."""
    capsys.readouterr()
    assert main(["compile", "arm.yaml", "--strict"]) == 1
    out, err = capsys.readouterr()
    assert out.splitlines()[-1].startswith("2 approximations, ")
    assert err.splitlines()[-4:-1] == [
        "--strict: 2 approximations that the spec does not accept; nothing was written",
        "  mjlab.delay (1 joint)",
        "  mjlab.velocity_limit (2 joints)",
    ]


def test_a_step_is_not_mujoco_s_for_isaac_lab_alone(spec: Path, capsys: Any) -> None:
    """Isaac Lab has not MuJoCo's default: that no step is stated is said, and 2 ms only where a delay counts them."""
    spec.write_text(SPEC.replace("timing: {physics_dt: 5 ms}\n", ""))
    assert _said(capsys, "-t", "isaaclab")[0].endswith(", no physics step stated, 2 ms taken")
    spec.write_text(re.sub(r"\n *delay: .*", "", spec.read_text()))
    assert "delay" not in spec.read_text()
    assert _said(capsys, "-t", "isaaclab")[0].endswith(", no physics step stated")


@pytest.mark.parametrize("stated", [True, False])
def test_a_step_that_nobody_states(spec: Path, stated: bool, capsys: Any) -> None:
    """Summary and files say whose the 2 ms are: a list of joints has no step, and the spec none."""
    spec.write_text(
        SPEC.replace("5 ms", "2 ms") if stated else SPEC.replace("timing: {physics_dt: 5 ms}\n", "")
    )
    lines = _said(capsys, "-t", "isaaclab", "-t", "mjlab", "-t", "deploy")
    whose = "MuJoCo's default: neither the spec nor its model states one"
    assert lines[0].endswith(", physics 2 ms" if stated else f", physics 2 ms ({whose})")
    for path, line in (
        (
            "isaaclab/arm_cfg.py",
            f"\nDelays, filters and networks count physics steps of 0.002 s,\n{whose}.\n",
        ),
        ("mjlab/arm_cfg.py", f"\n# The step is {whose}.\n"),
        ("deploy/arm_deploy.yaml", f"  physics_dt: 0.002  # s, of the simulation; {whose}\n"),
    ):
        assert (line in Path("build/arm", path).read_text()) is not stated


def test_a_step_that_nothing_counts(spec: Path, capsys: Any) -> None:
    """Nobody stated a step, and without delay, filter and network none counts: the module is made for any."""
    text = re.sub(r"\n *(delay|command_filter):.*", "", SPEC.replace("timing: {physics_dt: 5 ms}\n", ""))
    spec.write_text(text)
    _said(capsys, "-t", "isaaclab")
    written = Path("build/arm/isaaclab/arm_cfg.py").read_text()
    assert "\nNo step of the simulation is stated, and nothing here counts one.\n" in written
    assert "0.002" not in written and "SimulationCfg" not in written


def test_strict_says_not_written(spec: Path, capsys: Any) -> None:
    """Where --strict refuses, no file is called written."""
    lines = _said(capsys, "--strict")
    assert "  mjlab 1.6  build/arm/mjlab/arm_cfg.py     not written" in lines


ALIKE = """actspec: 1
robot: {name: arm, model: none, joints: [shoulder, elbow]}
actuators:
  arm:
    joints: [shoulder, elbow]
    level: ideal_pd
    kp: 20 N*m/rad
    kd: 1 N*m*s/rad
    effort_limit: 10 N*m
    armature: 0.01 kg*m^2
    command_filter: {cutoff: 30 Hz}
    overrides: {elbow: {effort_limit: 8 N*m}}
    randomize: {armature: {scale: [0.5, 2]}}
timing: {physics_dt: 5 ms}
targets:
  deploy: {}
  mjlab: {version: "1.6"}
  randomization: {for: [mjlab, json]}
"""


def test_a_target_with_several_files_is_named_once(spec: Path, capsys: Any) -> None:
    """The second file of a target stands below the first, without the target's name."""
    spec.write_text(ALIKE)
    assert [line.split()[0] for line in _about(_said(capsys), "target")] == [
        "target",
        "deploy",
        "mjlab",
        "randomization",
        "build/arm/randomization/arm_randomization.json",
        "build/arm/*/manifest.json",
    ]


def test_the_largest_size_stands_for_all(spec: Path, capsys: Any) -> None:
    """A lost filter costs half of the limit: 5 N*m and 4 N*m, of which 5 is said; no count where all joints lose it."""
    spec.write_text(ALIKE)
    lines = _said(capsys)
    (told,) = [line.strip() for line in lines if " -> " in line]
    assert told.startswith("30 Hz -> none; torque error up to 5 N*m (")
    assert lines[-1] == "1 approximation, torque error up to 5 N*m; 0 warnings"
