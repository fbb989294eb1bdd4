"""The figures of the specs that ship: sources, what follows from them, and the pages that repeat them."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from actspec import api
from actspec.cli.main import main
from actspec.ir import ActuatorSet, JointActuator, Level, Origin, Quantity
from tests.robots.published import ROBOTS, ROOT, number, plain, spec_of

NAMES = ("a1", "a1_stiff", "anymal_c", "anymal_d", "g1", "go1", "go2", "h1", "so101", "spot")
READABLE = (".xml", "_cfg.py", "_deploy.yaml")
"""Ends of the names of compiled files that the audit reads."""
MOTORS = sorted((ROBOTS / "motors").glob("*.yaml"))


def _resolved(name: str) -> ActuatorSet:
    return api.resolve(api.load(ROBOTS / f"{name}.yaml"))


def _joint(robot: ActuatorSet, name: str) -> JointActuator:
    joint = robot.joint(name)
    assert joint is not None
    return joint


def _rows(page: Path, heading: str) -> list[list[str]]:
    """Cells of the first table below a heading, without its head."""
    _, _, text = ("\n" + page.read_text(encoding="utf-8")).partition(f"\n{heading}\n")
    table = re.search(r"(?:^\|.*\n)+", text, re.MULTILINE)
    assert table is not None, heading
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table[0].splitlines()[2:]]


def test_every_robot_is_named_here() -> None:
    """No spec of the folder escapes these tests."""
    assert sorted(path.stem for path in ROBOTS.glob("*.yaml")) == sorted(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_every_figure_of_a_spec_names_a_listed_source(name: str) -> None:
    """Sources that figures name are listed, and all listed ones are named."""
    spec = spec_of(name)
    named: set[str] = set()

    def visit(node: Any) -> None:
        if isinstance(node, dict):
            if "value" in node and node["value"] != "unknown":
                assert "source" in node, node
                named.add(node["source"])
            for value in node.values():
                visit(value)
        elif isinstance(node, list):
            for value in node:
                visit(value)

    visit({key: value for key, value in spec.items() if key != "sources"})
    assert named == set(spec["sources"])


@pytest.mark.parametrize("name", NAMES)
def test_every_source_is_in_the_list(name: str) -> None:
    """SOURCES.md gives each source key of a spec with the same address."""
    listed: dict[str, str] = {}
    for cells in _rows(ROBOTS / "SOURCES.md", "# Where the numbers in this folder come from"):
        listed |= dict.fromkeys(cells[0].split(", "), cells[1])
    for key, source in spec_of(name)["sources"].items():
        if "url" in source:
            assert f"<{source['url']}>" in listed[key], key
        assert re.fullmatch(r"2026-\d\d-\d\d", str(source["accessed"])), key


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_the_audit_has_no_warning(
    name: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """With every approximation accepted, a robot compiles, and no rule has more than a remark about the result."""
    monkeypatch.chdir(tmp_path)
    spec = str(ROBOTS / f"{name}.yaml")
    assert main(["compile", spec, "-o", "out", "--strict"]) == 0
    files = [str(path) for path in sorted(Path("out").rglob("*.*")) if path.name.endswith(READABLE)]
    assert len(files) == 4
    capsys.readouterr()
    assert main(["audit", "--spec", spec, *files, "--output-format", "json", "--fail-on", "warning"]) == 0
    assert all(file["readable"] for file in json.loads(capsys.readouterr().out)["files"])


def test_every_motor_is_used() -> None:
    """A shared motor without a robot would be a figure that nothing checks."""
    shared = [name for file in MOTORS for name in plain(file)["motors"]]
    specs = [plain(path) for path in ROBOTS.glob("*.yaml")]
    parts = [part for spec in specs for part in (spec, *spec.get("variants", {}).values())]
    used = {group["motor"] for part in parts for group in part["actuators"].values() if "motor" in group}
    assert len(shared) == len(set(shared))
    assert set(shared) <= used


def _ratio(motor: dict[str, Any], first: int = 0) -> float:
    """Ratio of a gearbox from one of its stages on."""
    ratio = 1.0
    for stage in motor["gearbox"][first:]:
        gears = stage.get("planetary")
        ratio *= 1.0 + number(gears["ring"]) / number(gears["sun"]) if gears else number(stage["ratio"])
    return ratio


def _at_output(motor: dict[str, Any]) -> float:
    """Inertia of a motor and its gearbox at the output."""
    if "gearbox" in motor:
        stages = enumerate(motor["gearbox"], 1)
        own = sum(number(stage["inertia"]) * _ratio(motor, first) ** 2 for first, stage in stages)
        return number(motor["rotor_inertia"]) * _ratio(motor) ** 2 + own
    if "rotor_inertia" in motor:
        return number(motor["rotor_inertia"]) * number(motor["gear_ratio"]) ** 2
    return number(motor["reflected_inertia"])


def test_motors_of_the_sources_page() -> None:
    """The motor table of SOURCES.md is what the files say."""

    def figure(motor: dict[str, Any], field: str) -> str:
        given = motor[field]
        return given if given == "unknown" else f"{number(given):.12g}"

    rows = []
    for file in MOTORS:
        for name, motor in plain(file)["motors"].items():
            staged = "gearbox" in motor
            rotor = "rotor_inertia" in motor and not staged
            stated = figure(motor, "rotor_inertia" if rotor else "reflected_inertia") if not staged else ""
            inertia = stated or f"{_at_output(motor):.12g}"
            gear = f"{_ratio(motor):.12g}" if staged else figure(motor, "gear_ratio")
            rows.append([name, figure(motor, "peak_torque"), gear, f"{'rotor ' if rotor else ''}{inertia}"])
    found = [cells[:4] for cells in _rows(ROBOTS / "SOURCES.md", "## Motors: motors/*.yaml")]
    assert sorted(found) == sorted(rows)


def _cell(quantity: Quantity | None, digits: int = 4) -> str:
    """A figure, or a dash for what nobody states: an engine's default is not a figure of the robot."""
    if quantity is None or quantity.value is None or quantity.origin is Origin.DEFAULT:
        return "–"
    return f"{quantity.value:.{digits}g}"


def _group(name: str, group: str, joints: list[JointActuator]) -> list[str]:
    joint = joints[0]
    figures = {
        (_cell(each.kp), _cell(each.kd), _cell(each.effort_limit), _cell(each.armature)) for each in joints
    }
    assert len(figures) == 1, (name, group)
    speed = joint.no_load_speed if joint.level is Level.DC_MOTOR else joint.velocity_limit
    return [
        name,
        f"{group} ({len(joints)})",
        joint.level.value,
        f"{_cell(joint.kp)}, {_cell(joint.kd)}",
        _cell(joint.effort_limit),
        _cell(speed),
        _cell(joint.armature, 3),
        f"{_cell(joint.friction_coulomb)}, {_cell(joint.friction_viscous)}",
    ]


def test_figures_of_the_page() -> None:
    """The table of docs/robots.md is what the specs resolve to."""
    expected = []
    for name in NAMES:
        groups: dict[str, list[JointActuator]] = {}
        for joint in _resolved(name).joints:
            groups.setdefault(joint.group, []).append(joint)
        expected += [_group(name, group, groups[group]) for group in spec_of(name)["actuators"]]
    found = _rows(ROOT / "docs" / "robots.md", "## The figures")
    assert found == expected, "\n".join("| " + " | ".join(row) + " |" for row in expected)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "group", "inertia", "effort", "kp", "kd"),
    [
        # I = 1.11842e-4 kg*m^2 x 6^2 = 4.026312e-3; kp = I (20 pi)^2 = I x 3947.8418;
        # kd = 2 x 2 x I x 20 pi = I x 251.32741
        ("go1", "hip_thigh", 4.026312e-3, 23.7, 15.8952, 1.01192),
        # x 1.5^2 = 9.059202e-3; 23.7 N*m x 1.5
        ("go1", "knee", 9.059202e-3, 35.55, 35.7643, 2.27683),
        # 0.139e-4 x 16^2 + 0.017e-4 x 4.5^2 + 0.169e-4 = 3.5584e-3 + 0.034425e-3 + 0.0169e-3
        ("g1", "arms", 3.609725e-3, 25.0, 14.2506, 0.907223),
        # 0.489e-4 x 14.31818^2 + 0.098e-4 x 3.181818^2 + 0.533e-4
        ("g1", "hip_pitch_yaw", 1.0177520e-2, 88.0, 40.1792, 2.55789),
        # 0.489e-4 x 22.5^2 + 0.109e-4 x 5^2 + 0.738e-4 = 24.755625e-3 + 0.2725e-3 + 0.0738e-3
        ("g1", "hip_roll_knee", 2.5101925e-2, 139.0, 99.0984, 6.30880),
        # 0.068e-4 x 25^2
        ("g1", "wrists", 4.25e-3, 5.0, 16.7783, 1.06814),
        # two motors n5020
        ("g1", "ankles", 7.21945e-3, 50.0, 28.5012, 1.81445),
        ("g1", "waist", 7.21945e-3, 50.0, 28.5012, 1.81445),
    ],
    ids=["go1-hip", "go1-knee", "g1-5020", "g1-7520-14", "g1-7520-22", "g1-4010", "g1-ankle", "g1-waist"],
)
def test_derived_gains(name: str, group: str, inertia: float, effort: float, kp: float, kd: float) -> None:
    """The Go1's and G1's figures lead to the gains and the action scale that mjlab trains with."""
    actuators = spec_of(name)["actuators"][group]
    linkages = spec_of(name).get("linkages", {})
    linked = next((entry for key, entry in linkages.items() if key.endswith(group.removesuffix("s"))), None)
    named = [actuators["motor"]] if linked is None else linked["motors"]
    motor, motors = spec_of(name)["motors"][named[0]], len(named)
    assert len(set(named)) == 1
    reduction = number(actuators.get("reduction", 1))
    at_output = _at_output(motor)
    omega = 2 * np.pi * number(actuators["kp"]["frequency"])
    found = at_output * reduction**2 * motors
    assert found == pytest.approx(inertia, rel=1e-6)
    assert found * omega**2 == pytest.approx(kp, rel=1e-5)
    assert 2 * number(actuators["kd"]["ratio"]) * found * omega == pytest.approx(kd, rel=1e-5)
    assert number(motor["peak_torque"]) * reduction * motors == pytest.approx(effort)
    assert number(actuators["action_scale"]) == pytest.approx(0.25 * effort / (found * omega**2), rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("variant", "hip_pitch", "wrist"),
    [
        # Effort limit, speed, armature, kp. README.md of g1_description: 14.3 or 22.5, 4010 or 5010.
        ("mode_5", (88.0, 32.0, 1.0177520e-2, 40.1792), (5.0, 22.0, 4.25e-3, 16.7783)),
        ("mode_11", (139.0, 20.0, 2.5101925e-2, 99.0984), (5.0, 22.0, 4.25e-3, 16.7783)),
        # 0.084e-4 x 16^2 + 0.015e-4 x 4^2 + 0.068e-4 = 21.504e-4 + 0.24e-4 + 0.068e-4 = 2.1812e-3 kg*m^2
        ("mode_13", (88.0, 32.0, 1.0177520e-2, 40.1792), (13.4, 27.0, 2.1812e-3, 8.61103)),
        ("mode_15", (139.0, 20.0, 2.5101925e-2, 99.0984), (13.4, 27.0, 2.1812e-3, 8.61103)),
    ],
)
def test_variants_of_the_g1(variant: str, hip_pitch: tuple[float, ...], wrist: tuple[float, ...]) -> None:
    """A machine type is the gear of hip pitch and the motor of the wrists; all else is the same."""
    robot = api.resolve(api.load(f"{ROBOTS / 'g1.yaml'}#{variant}"))
    expected = {"hip_pitch": hip_pitch, "wrist_pitch": wrist, "wrist_yaw": wrist}
    plain = {joint.joint: joint for joint in api.resolve(api.load(ROBOTS / "g1.yaml")).joints}
    assert robot.variant == variant
    for joint in robot.joints:
        kind = joint.joint.removeprefix("left_").removeprefix("right_").removesuffix("_joint")
        other = plain[joint.joint]
        found, same = (
            (
                each.effort_limit.require(),
                each.velocity_limit.require(),
                each.armature.require(),
                each.kp.require() if each.kp is not None else None,
            )
            for each in (joint, other)
        )
        assert found == pytest.approx(expected.get(kind, same), rel=1e-5), joint.joint
        assert joint.action_scale.require() == pytest.approx(0.25 * found[0] / (found[3] or 0.0), rel=1e-6)


@pytest.mark.slow
def test_variants_compile_strictly(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Every variant compiles to every target, with the approximations that the spec accepts, and no warning."""
    for spec in ("g1.yaml#mode_11", "g1.yaml#mode_13", "g1.yaml#mode_15", "g1.yaml", "go1.yaml"):
        assert main(["compile", str(ROBOTS / spec), "-o", str(tmp_path / spec), "--strict"]) == 0
        # What an explicit drive is near is a note, as in the audit.
        said = capsys.readouterr().err
        assert "STB102 [info]" in said and "[warning]" not in said


@pytest.mark.parametrize(
    ("name", "joint", "armature", "effort", "no_load"),
    [
        # 1.11842e-4 kg*m^2 x 6^2
        ("go2", "RL_hip_joint", 4.026312e-3, 23.7, 30.1),
        # x 1.9169^2 = 3.67450561; 30.1 / 1.9169 = 15.702436
        ("go2", "FR_calf_joint", 1.47947062e-2, 45.43, 15.702436),
        ("h1", "torso_joint", 0.063259741, 200.0, None),
        ("h1", "left_knee_joint", 0.160478022, 300.0, None),
        # 0.01 kg*m^2 x (20/9)^2 = 0.04938272
        ("h1", "right_ankle_joint", 4.938272e-2, 40.0, None),
        ("h1", "left_shoulder_roll_joint", 4.938272e-2, 40.0, None),
        ("h1", "left_elbow_joint", 0.01, 18.0, None),
    ],
    ids=["go2-hip", "go2-knee", "h1-torso", "h1-knee", "h1-ankle", "h1-shoulder", "h1-elbow"],
)
def test_reflected_figures(
    name: str, joint: str, armature: float, effort: float, no_load: float | None
) -> None:
    """What follows from motor and reduction is worked out here by hand."""
    found = _joint(api.resolve(api.load(ROBOTS / f"{name}.yaml")), joint)
    assert found.armature.require() == pytest.approx(armature, rel=1e-6)
    assert found.effort_limit.require() == effort
    if no_load is None:
        assert found.no_load_speed is None
        return
    assert found.no_load_speed is not None and found.stall_torque is not None
    assert found.no_load_speed.require() == pytest.approx(no_load, rel=1e-7)
    # The limit is the torque of the line at rest, to the rounding of the reduction.
    assert found.stall_torque.require() == pytest.approx(effort, rel=2e-5)


@pytest.mark.parametrize(
    ("name", "slow", "fast", "speeds"),
    # The URDFs' speed limits [rad/s].
    [
        ("go1", "FL_calf_joint", "FL_hip_joint", (20.06, 30.1)),
        ("go2", "FL_calf_joint", "FL_hip_joint", (15.70, 30.1)),
        ("h1", "left_ankle_joint", "left_elbow_joint", (9.0, 20.0)),
    ],
    ids=["go1", "go2", "h1"],
)
def test_reduction_is_that_of_the_limits(
    name: str, slow: str, fast: str, speeds: tuple[float, float]
) -> None:
    """Behind a reduction the torque is higher, the speed lower by it, and the armature higher by its square."""
    robot = _resolved(name)
    strong, weak = _joint(robot, slow), _joint(robot, fast)
    ratio = speeds[1] / speeds[0]
    assert strong.effort_limit.require() / weak.effort_limit.require() == pytest.approx(ratio, rel=5e-4)
    assert strong.armature.require() / weak.armature.require() == pytest.approx(ratio**2, rel=1e-3)


def test_servo_is_bams() -> None:
    """Motor, gains and friction of the SO-101 follow from BAM's parameters of its servo, at LeRobot's P of 16."""
    # bam/params/feetech_sts3215_7_4V/m1.json; bam/feetech/actuator.py.
    torque_constant, resistance = 1.21164135295077, 2.6761663274455603
    volts, error_gain, duty = 7.4, 0.166, 0.97
    joint = _joint(api.resolve(api.load(ROBOTS / "so101.yaml")), "elbow_flex")
    found = {
        "stall": joint.stall_torque,
        "no load": joint.no_load_speed,
        "kp": joint.kp,
        "kd": joint.kd,
        "armature": joint.armature,
        "coulomb": joint.friction_coulomb,
        "viscous": joint.friction_viscous,
        "limit": joint.effort_limit,
    }
    stiffness = torque_constant * volts / resistance
    expected = {
        "stall": stiffness * duty,
        "no load": volts * duty / torque_constant,
        "kp": stiffness * error_gain * 16,
        "kd": torque_constant**2 / resistance,
        "armature": 0.02840336348682085,
        "coulomb": 0.05239296084748866,
        "viscous": 0.05908515565091076,
        # 19.5 kgf*cm
        "limit": 19.5 * 9.80665 * 0.01,
    }
    figures = {name: quantity.require() for name, quantity in found.items() if quantity is not None}
    assert figures == pytest.approx(expected, rel=2e-5)
    # kd is the slope of the line: then a PD clipped by the line is a voltage clipped by the supply.
    assert figures["kd"] == pytest.approx(figures["stall"] / figures["no load"], rel=2e-5)


def test_anydrives_brake_alike() -> None:
    """The ANYmal C's kd is the D's kd and joint friction together, so that it must not get that friction too."""
    c, d = (_joint(api.resolve(api.load(ROBOTS / f"anymal_{name}.yaml")), "RH_KFE") for name in "cd")
    assert c.kd is not None and d.kd is not None
    assert d.kd.require() + d.friction_viscous.require() == pytest.approx(c.kd.require(), rel=0.03)
    assert c.friction_viscous.origin is Origin.DEFAULT


def test_spots_knee_is_a_linkage() -> None:
    """Each knee gets the limit of its default pose; what that loses elsewhere is the table's least against it."""
    robot = api.resolve(api.load(ROBOTS / "spot.yaml"))
    knees = [joint for joint in robot.joints if joint.joint.endswith("_kn")]
    # 1.5 N*m x 75.208656 at -1.52 rad, the row nearest to -1.5 rad.
    assert [knee.effort_limit.require() for knee in knees] == pytest.approx([112.812984] * 4, rel=1e-9)
    # 1.5 N*m x 20.401667 at -0.2471 rad = 30.6025005
    assert {loss.field for loss in robot.approximations} == {"linkage_pose"}
    assert [loss.max_torque_error for loss in robot.approximations] == pytest.approx(
        [82.2104835] * 4, rel=1e-6
    )
    hip = _joint(robot, "hl_hy")
    # 0.88 N*m x 51 = 44.88, published rounded.
    assert hip.peak_torque is not None
    assert hip.peak_torque.require() == pytest.approx(44.88)
    assert hip.effort_limit.require() == 45.0
