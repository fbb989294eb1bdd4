"""`actspec compare`: variants against integrations of our own, steps that do not carry a drive, what is missing."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from lxml import etree

from actspec import api
from actspec.cli.main import main
from actspec.diagnostics import Collector
from actspec.owned import is_own
from actspec.resources import data_path
from actspec.study.compare import Comparison, _findings, compare
from actspec.study.variants import Assumed
from actspec.targets.choose import choose_targets

SPEC = """\
actspec: 1
robot: {{name: wheels, model: wheels.xml}}
timing: {{physics_dt: 2 ms}}
sources: {{us: {{title: an example}}}}
motors:
  small: {{side: joint, stall_torque: {{value: 12 N*m, source: us}}, no_load_speed: {{value: 15 rad/s, source: us}}}}
actuators:
  all:
    joints: [".*"]
    level: {level}
    motor: small
    kp: {{value: 40 N*m/rad, source: us}}
    kd: {{value: {kd} N*m*s/rad, source: us}}
    effort_limit: {{value: 10 N*m, source: us}}
    armature: {{value: 0 kg*m^2, source: us}}
    friction: {{coulomb: {{value: {coulomb} N*m, source: us}}, viscous: {{value: 0 N*m*s/rad, source: us}}}}
"""

MODEL = """\
<mujoco model="wheels"><compiler angle="radian"/><option timestep="0.002" integrator="{integrator}"/><worldbody>
{bodies}</worldbody><actuator>{motors}</actuator></mujoco>
"""


def folder(
    path: Path, *, inertias: tuple[float, ...], kd: float = 1.0, coulomb: float = 0.0, level: str = "dc_motor",
    integrator: str = "implicitfast",
) -> Path:  # fmt: skip
    """A spec of wheels that turn, each by itself."""
    bodies = "".join(
        f'<body name="b{k}" pos="{k} 0 0"><inertial pos="0 0 0" mass="1" diaginertia="{j} {j} {j}"/>'
        f'<joint name="j{k}" type="hinge" axis="0 0 1"/></body>\n'
        for k, j in enumerate(inertias)
    )
    motors = "".join(f'<motor joint="j{k}"/>' for k in range(len(inertias)))
    (path / "wheels.xml").write_text(MODEL.format(integrator=integrator, bodies=bodies, motors=motors))
    (path / "spec.yaml").write_text(SPEC.format(kd=kd, coulomb=coulomb, level=level))
    return path / "spec.yaml"


def compared(path: Path, given: Assumed = Assumed(), duration: float = 1.0) -> Comparison:  # noqa: B008
    spec = api.load(path)
    robot = api.load_robot(spec)
    actuators = api.resolve(spec, robot)
    options = choose_targets(spec, ("mujoco",), None, False, Collector())[0]
    names = [a.joint for a in actuators.joints]
    return compare(actuators, robot, options, spec=str(path), joints=names, given=given, duration=duration)


def integrated(
    inertia: float, kd: float, coulomb: float, size: float, *, line: bool, delay: float = 0.0,
    cutoff: float | None = None,
) -> dict[str, float]:  # fmt: skip
    """The same wheel in steps of 10 us, semi-implicitly, written anew: friction takes no more speed than there is."""
    h, kp, limit, stall, fastest = 1e-5, 40.0, 10.0, 12.0, 15.0
    q = qd = low = 0.0
    n = 50_000
    course, torques = np.zeros(n + 1), np.zeros(n)
    for k in range(n):
        asked = size if k * h >= delay - 1e-12 else 0.0
        low = asked if cutoff is None else low + (asked - low) * (1.0 - math.exp(-2.0 * math.pi * cutoff * h))
        torque = kp * (low - q) - kd * qd
        top, bottom = limit, -limit
        if line:
            top, bottom = min(limit, stall * (1 - qd / fastest)), max(-limit, stall * (-1 - qd / fastest))
        torque = max(min(torque, top), bottom)
        speed = qd + h * torque / inertia
        qd = math.copysign(max(abs(speed) - h * coulomb / inertia, 0.0), speed)
        q += h * qd
        course[k + 1], torques[k] = q, torque
    share = course / size
    return {
        "rise_time": h * (np.argmax(share >= 0.9) - np.argmax(share >= 0.1)),
        "overshoot": max(share.max() - 1.0, 0.0),
        "settling_time": h * np.flatnonzero(np.abs(share - 1.0) > 0.02)[-1],
        "peak_torque": np.abs(torques).max(),
        "peak_speed": np.abs(np.diff(course)).max() / h,
    }


@pytest.mark.slow
def test_metrics_are_those_of_fine_steps(tmp_path: Path) -> None:
    """Each variant within 1 % of an integration of our own at 10 us.

    L 10 and kp 40: the step goes 0.5 * 10 / 40 = 0.125 rad, the swing 0.5.
    """
    path = folder(tmp_path, inertias=(0.02,), kd=0.6, coulomb=0.05)
    found = compared(path, Assumed(cutoff=8.0, delay=0.0107), 0.5)
    assert [row.variant for row in found.rows[::3]] == ["ideal_pd", "filter", "delay", "dc_motor", "spec"]
    rows = {(row.variant, row.course): row for row in found.rows}
    assert rows["spec", "step"].amplitude == pytest.approx(0.125)
    assert rows["spec", "swing"].amplitude == pytest.approx(0.5)
    cases: list[tuple[str, str, float, dict[str, Any]]] = [
        ("ideal_pd", "swing", 0.5, {"line": False}),
        ("filter", "step", 0.125, {"line": False, "cutoff": 8.0}),
        ("delay", "step", 0.125, {"line": False, "delay": 0.0107}),
        ("spec", "swing", 0.5, {"line": True}),
    ]
    for variant, course, size, more in cases:
        metrics = rows[variant, course].law_metrics
        for name, value in integrated(0.02, 0.6, 0.05, size, **more).items():
            assert getattr(metrics, name) == pytest.approx(value, rel=0.01, abs=1e-4), (variant, name)
    # What a part changes: here the line of the swing alone.
    assert rows["dc_motor", "step"].change == pytest.approx(0.0, abs=1e-3)
    assert (rows["dc_motor", "swing"].change or 0.0) > 0.05
    assert rows["ideal_pd", "swing"].change == 0.0
    # MuJoCo's delay is a whole number of its steps: 10 ms of 10.7.
    assert (rows["delay", "step"].departure or 0.0) > (rows["ideal_pd", "step"].departure or 0.0)


def test_equal_joints_are_one(tmp_path: Path) -> None:
    """Inertias 5e-4 apart are one actuator, 2e-3 apart are two."""
    found = compared(folder(tmp_path, inertias=(0.02, 0.02001, 0.02004)), duration=0.1)
    assert [row.joints for row in found.rows[::9]] == [("j0", "j1"), ("j2",)]
    assert {(m.variant, m.joint) for m in found.missing} == {
        (variant, joint) for variant in ("filter", "delay", "network") for joint in ("j0", "j2")
    }


@pytest.mark.slow
def test_a_line_is_compared_at_level_ideal_pd(tmp_path: Path) -> None:
    """The motor's line is no part of the spec then, and the variant shows what it would change."""
    found = compared(folder(tmp_path, inertias=(0.02,), level="ideal_pd"), duration=0.3)
    rows = {(row.variant, row.course): row for row in found.rows}
    assert rows["spec", "swing"].change == 0.0
    assert (rows["dc_motor", "swing"].change or 0.0) > 0.05


@pytest.mark.slow
def test_a_step_that_does_not_carry_the_drive(tmp_path: Path) -> None:
    """J 0.00125, kd 4, 2 ms: h kd / J = 6.4. Euler rattles for ever, without a NaN; implicitfast comes to rest."""
    bad = compared(
        folder(tmp_path, inertias=(0.00125,), kd=4.0, level="ideal_pd", integrator="Euler"), duration=0.3
    )
    assert {row.stable for row in bad.rows} == {False}
    assert all(row.simulated_metrics is None and row.departure is None for row in bad.rows)
    assert bad.rows[0].explicit_ratio == pytest.approx(6.4)
    (finding,) = bad.findings
    assert finding.code == "CMP001"
    assert "2 ms with Euler" in finding.message
    assert "6.4" in finding.message
    assert finding.help == "integrator implicitfast, a shorter timing.physics_dt, or less kd"
    (same,) = _findings(bad.rows, bad.timestep, "implicitfast")
    assert same.help == "a shorter timing.physics_dt, or less kd"
    good = compared(folder(tmp_path, inertias=(0.00125,), kd=4.0, level="ideal_pd"), Assumed(cutoff=8.0), 0.5)
    assert {row.stable for row in good.rows} == {True}
    assert not good.findings
    # The filter's steps reach the drive at once: the simulated torque is several times the law's.
    filtered = next(row for row in good.rows if (row.variant, row.course) == ("filter", "step"))
    assert filtered.simulated_metrics is not None
    assert filtered.simulated_metrics.peak_torque > 3.0 * filtered.law_metrics.peak_torque


@pytest.mark.slow
def test_output_and_pictures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    """JSON as its schema has it, text with the answer, an SVG of its own; what is there is not replaced."""
    from jsonschema import Draft202012Validator

    monkeypatch.chdir(tmp_path)
    path = str(folder(tmp_path, inertias=(0.02,)).name)
    arguments = ["compare", path, "--duration", "0.3s", "--delay", "10ms", "--plot", "wheels.svg"]
    assert main([*arguments, "--output-format", "json"]) == 0
    record = json.loads(capsys.readouterr().out)
    schema = json.loads(data_path("schemas", "actspec-compare-v1.schema.json").read_text("utf-8"))
    Draft202012Validator.check_schema(schema)
    Draft202012Validator(schema).validate(record)
    assert [m["variant"] for m in record["missing"]] == ["filter", "network"]
    picture = etree.parse("wheels.svg").getroot()
    text = " ".join(picture.itertext())
    assert picture.tag == "{http://www.w3.org/2000/svg}svg"
    assert "j0: step worth half of the effort limit" in text
    (tmp_path / "wheels.svg").write_text("<svg/>")
    assert main(arguments) == 2
    assert "wheels.svg: OUT003: exists already" in capsys.readouterr().err
    assert main([*arguments, "--plot", "Wheels.svg"]) == 2
    assert "'Wheels.svg' is named twice" in capsys.readouterr().err
    assert main([*arguments, "--force"]) == 0
    assert is_own("wheels.svg")
    shown = capsys.readouterr().out
    assert "changes of PD and limit: " in shown
    assert "the delay (not in the spec)" in shown


@pytest.mark.parametrize(
    "more, said",
    [
        (["--filter", "30"], "--filter"),
        (["--delay", "10Hz"], "--delay"),
        (["--delay", "0ms"], "above 0"),
        (["--duration", "100s"], "at most 60 s"),
        (["--duration", "1us"], "at least 0.01 s"),
        (["--delay", "1e20 s"], "at most 60 s"),
        (["--plot", "a.txt"], "one of .svg, .png, .pdf"),
        (["--plot", "none/a.svg"], "no such folder"),
        (["--joint", "k0"], "matches no joint"),
        (["--plot", "spec.yaml.svg", "--joint", "nobody"], "matches no joint"),
    ],
)
def test_what_is_refused(
    more: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    """Exit code 2, and no picture."""
    monkeypatch.chdir(tmp_path)
    before = {folder(tmp_path, inertias=(0.02,)).name, "wheels.xml"}
    assert main(["compare", "spec.yaml", *more]) == 2
    assert said in capsys.readouterr().err
    assert {entry.name for entry in tmp_path.iterdir()} == before


@pytest.mark.slow
def test_a_target_in_words_of_another_version(tmp_path: Path) -> None:
    """A <dcmotor> of MuJoCo 3.11 is no model of 4.0: the same drive is compared in the words of that which is here."""
    path = folder(tmp_path, inertias=(0.05,))
    newest = compared(path, duration=0.2)
    path.write_text(path.read_text() + 'targets: {mujoco: {version: "3.11"}}\n')
    older = compared(path, duration=0.2)
    assert [(row.variant, row.course, row.departure) for row in older.rows] == [
        (row.variant, row.course, pytest.approx(row.departure)) for row in newest.rows
    ]


@pytest.mark.parametrize(
    ("kd", "viscous", "reason"),
    [
        # 100 / 1e-5 = 1e7 1/s: 0.1 us.
        (100.0, 0.0, "kd alone stops it within 0.1 us: state the armature, or correct kd"),
        # (1 + 4) / 1e-5 = 5e5 1/s: 2 us.
        (
            1.0,
            4.0,
            "friction.viscous alone stops it within 2 us: state the armature, or correct friction.viscous",
        ),
        # 1 / 1e-5 = 1e5 1/s, half of what is followed.
        (1.0, 0.0, None),
    ],
)
def test_a_joint_without_its_inertia_is_not_followed(
    kd: float, viscous: float, reason: str | None, tmp_path: Path
) -> None:
    """It was nan, or took no end of substeps."""
    path = folder(tmp_path, inertias=(1e-5,), kd=kd, level="ideal_pd")
    path.write_text(path.read_text().replace("viscous: {value: 0 ", f"viscous: {{value: {viscous} "))
    found = compared(path, duration=0.1)
    assert {one.reason for one in found.missing if one.variant == "ideal_pd"} == (
        {reason} if reason else set()
    )
    assert any(row.variant == "ideal_pd" for row in found.rows) == (reason is None)
