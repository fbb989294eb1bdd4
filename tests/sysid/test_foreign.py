"""Results of BAM, PACE, mujoco.sysid and lines: what their figures are here, and what is refused or left out.

The files are written here in the formats that the tools' code has (see the modules); numbers are chosen so that a wrong
sign, order or convention gives another one.
"""

from __future__ import annotations

import json
import os
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from actspec import api
from actspec.cli.main import main
from actspec.diagnostics import ResolveError
from actspec.laws import law_of
from actspec.spec.document import load_document
from actspec.spec.results import Results, validate_results

MODEL = """<mujoco><worldbody><body name="thigh"><joint name="hip" axis="0 1 0" range="-1 1"/>
<geom size="0.1" mass="1"/><body name="shank"><joint name="knee" axis="0 1 0" range="-1 1"/><geom size="0.1" mass="1"/>
</body></body></worldbody><actuator><motor joint="hip"/><motor joint="knee"/></actuator></mujoco>"""
M1 = {
    "kt": 1.5,
    "R": 3.0,
    "armature": 0.012,
    "friction_base": 0.1,
    "friction_viscous": 0.03,
    "model": "m1",
    "actuator": "mx64",
}
STRIBECK = {"friction_stribeck": 0.05, "dtheta_stribeck": 0.8, "alpha": 2.0}
LOADED = {"load_friction_base": 0.2}


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def taken(tool: str, file: str, *more: str, exit: int = 0) -> Results:
    """Results of an import that has this exit code."""
    command = ["sysid", "import", file, "--from", tool, "--robot", "leg", "-o", "r.yaml", "--force", *more]
    assert main(command) == exit
    return validate_results(load_document("r.yaml"))


def refused(capsys: pytest.CaptureFixture[str], tool: str, file: str, *more: str) -> str:
    """What is said where nothing is written."""
    assert main(["sysid", "import", file, "--from", tool, "--robot", "leg", "-o", "no.yaml", *more]) == 2
    assert not os.path.exists("no.yaml")
    return capsys.readouterr().err


def bam(**changed: Any) -> str:
    """A parameter file of BAM; a parameter that is None is not there."""
    data = {key: value for key, value in {**M1, **changed}.items() if value is not None}
    Path("m.json").write_text(json.dumps(data), encoding="utf-8")
    return "m.json"


def figures(results: Results, joint: str = "hip") -> dict[str, float]:
    """A joint's values by field."""
    found = results.joints[joint]
    every = {name: getattr(found, name) for name in ("kp", "kd", "armature", "delay", "encoder_bias")}
    every |= {f"friction.{name}": value for name, value in found.friction}
    return {name: value.value for name, value in every.items() if value is not None}


def test_bam_m1_is_exact() -> None:
    """Its viscous friction is without kt^2/R = 1.5^2/3 = 0.75, which is the drive's kd; no std is invented."""
    found = taken("bam", bam(), "--joint", "hip", "knee")
    expected = {"armature": 0.012, "kd": 0.75, "friction.coulomb": 0.1, "friction.viscous": 0.03}
    assert figures(found) == figures(found, "knee") == expected
    hip = found.joints["hip"]
    assert hip.armature is not None and hip.armature.std is None
    assert hip.left_out["kt"].startswith("1.5 N*m/A")
    # 1.5 / 3 = 0.5 N*m a volt at standstill, 1 / 1.5 = 0.666667 rad/s a volt without load.
    assert "stall_torque 0.5 N*m/V x V, no_load_speed 0.666667 rad/s/V x V" in hip.left_out["R"]


def test_bam_m1_compiled_has_its_motor_torque(folder: Path) -> None:
    """The law of the compiled spec is BAM's voltage servo wherever it drives: P on the duty, DC motor with back-EMF."""
    taken("bam", bam(), "--joint", "hip")
    gain, volts = 4.0, 12.0
    # kp = gain x V x kt / R = 4 x 12 x 0.5; stall 12 x 0.5; no load 12 / 1.5.
    Path("leg.xml").write_text(MODEL, encoding="utf-8")
    Path("spec.yaml").write_text(
        "actspec: 1\nrobot: {name: leg, model: leg.xml, unmanaged: [knee]}\n"
        "motors: {servo: {side: joint, gear_ratio: 1, stall_torque: 6 N*m, no_load_speed: 8 rad/s}}\n"
        "actuators:\n  legs: {joints: [hip], motor: servo, level: dc_motor, kp: 24, kd: identified, effort_limit: 6,\n"
        "    identified: r.yaml}\n",
        encoding="utf-8",
    )
    done = api.compile("spec.yaml", targets=["mujoco==3.12"])
    text = done.emissions[0].files[0].data.decode()
    assert 'armature="0.012"' in text and 'frictionloss="0.1"' in text and 'damping="0.03"' in text
    assert "identification by bam m1 of mx64" in text
    law = law_of(done.actuators.joints[0])
    for error in np.linspace(-0.6, 0.6, 13):
        for speed in np.linspace(-7.0, 7.0, 15):
            voltage = np.clip(volts * gain * error, -volts, volts)
            torque = 1.5 * voltage / 3.0 - 1.5**2 * speed / 3.0
            if torque * speed >= 0.0:
                assert float(law.torque(error, 0.0, speed)) == pytest.approx(torque, abs=1e-12)


def test_bam_m2_with_a_gaussian_is_the_spec_s_curve() -> None:
    """static = base + stribeck = 0.15 at rest, 0.1 + 0.05 exp(-(v/0.8)^2) moving."""
    found = taken("bam", bam(model="m2", **STRIBECK), "--joint", "hip")
    got = figures(found)
    assert got["friction.coulomb"] == 0.1 and got["friction.static"] == pytest.approx(0.15)
    assert got["friction.stribeck_velocity"] == 0.8


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        pytest.param(
            {"model": "m2", **STRIBECK, "alpha": 3.0}, "falls off by |qd/v|^3", id="m2, another exponent"
        ),
        pytest.param({"model": "m3", **LOADED}, "grows with the load (load_friction_base)", id="m3"),
        pytest.param({"model": "m4", **STRIBECK, **LOADED}, "grows with the load", id="m4"),
        pytest.param({"model": "m5", **STRIBECK, "load_friction_motor": 0.1}, "grows with the load", id="m5"),
        pytest.param(
            {"model": "m6", **STRIBECK, "load_friction_motor_quad": 0.1}, "grows with the load", id="m6"
        ),
    ],
)
def test_bam_friction_that_is_no_coulomb_friction(
    changed: dict[str, Any], said: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It is left out with its numbers, and a spec that asks for it gets the reason."""
    found = taken("bam", bam(**changed), "--joint", "hip", exit=1)
    assert figures(found) == {"armature": 0.012, "kd": 0.75, "friction.viscous": 0.03}
    assert said in found.joints["hip"].left_out["friction.coulomb"]
    assert "friction_base 0.1" in found.joints["hip"].left_out["friction.coulomb"]
    assert "SYS073 [warning]" in capsys.readouterr().err
    Path("leg.xml").write_text(MODEL, encoding="utf-8")
    Path("spec.yaml").write_text(
        "actspec: 1\nrobot: {name: leg, model: leg.xml, unmanaged: [knee]}\nactuators:\n  legs: {joints: [hip], "
        "level: ideal_pd, kp: 1, kd: 1, identified: r.yaml, friction: {coulomb: identified}}\n",
        encoding="utf-8",
    )
    with pytest.raises(ResolveError, match=r"RES002 .*r\.yaml:\d+:\d+ left it out: .*") as caught:
        api.resolve("spec.yaml")
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("changed", "kd"),
    [
        pytest.param({"actuator": "erob80_50"}, "end of the supply alone", id="current"),
        pytest.param({"actuator": "unitree_go1", "kt": None, "R": None}, "setting of the drive", id="torque"),
        pytest.param({"actuator": "mine"}, "'mine' is not known here", id="unknown"),
        pytest.param({"actuator": "erob80_100", "R": None}, "no kt and R", id="no resistance"),
    ],
)
def test_back_emf_is_kd_of_voltage_servos_alone(changed: dict[str, Any], kd: str) -> None:
    """Behind a current loop it acts where the supply ends."""
    found = taken("bam", bam(**changed), "--joint", "hip")
    assert "kd" not in figures(found)
    assert kd in found.joints["hip"].left_out["kd"]


def test_other_parameters_of_bam_are_listed() -> None:
    """The zero of a test bench is no encoder's bias."""
    found = taken("bam", bam(q_offset=-0.05, surprise=3.0), "--joint", "hip")
    assert "encoder_bias" not in figures(found)
    left = found.joints["hip"].left_out
    assert left["q_offset"].startswith("-0.05 rad") and left["surprise"].startswith("3.0")


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        pytest.param({"model": "m7"}, "SYS070", id="model"),
        pytest.param({"actuator": None}, "names no actuator", id="actuator"),
        pytest.param({"friction_base": None}, "no `friction_base`", id="missing"),
        pytest.param({"friction_viscous": -0.01}, "SYS072", id="negative"),
        pytest.param({"armature": "0.1"}, "must be a number", id="text"),
        pytest.param({"kt": 0.0}, "must be above 0", id="no constant"),
        pytest.param({"model": "m2"}, "no `friction_stribeck`", id="m2 without its curve"),
        pytest.param({"kt": float("nan")}, "SYS07", id="nan"),
    ],
)
def test_files_that_are_not_bam_s(
    changed: dict[str, Any], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """No number is invented."""
    assert said in refused(capsys, "bam", bam(**changed), "--joint", "hip")


VECTOR = [0.011, 0.012, 0.21, 0.22, 0.31, 0.32, 0.041, -0.042, 3.7]
"""Two joints: armature, viscous, friction, bias, then the delay in steps."""
PACE = ["--joint", "hip", "knee", "--layout", "armature,viscous,friction,bias,delay", "--step", "2.5 ms"]


def vector(numbers: list[float] = VECTOR, text: str = "\n") -> str:
    """A mean of PACE as text."""
    Path("mean.csv").write_text(text.join(map(str, numbers)) + "\n", encoding="utf-8")
    return "mean.csv"


def test_pace_at_head() -> None:
    """q = q_measured + b, so 0.041 is -0.041 here; the delay is the torque's and stays out: 3 whole steps, 7.5 ms."""
    found = taken("pace", vector(), *PACE, "--commit", "f8ec8b85015140633870463dd27d498ac9f96b53", exit=1)
    static = {"armature": 0.011, "friction.viscous": 0.21, "friction.static": 0.31, "encoder_bias": -0.041}
    assert figures(found) == static
    assert figures(found, "knee")["encoder_bias"] == 0.042
    left = found.joints["knee"].left_out
    assert "3 steps of 0.0025 s (mean 3.7) = 0.0075 s" in left["delay"]
    assert "static friction alone" in left["friction.coulomb"]
    assert found.commit is not None and found.commit.startswith("f8ec8b8")


def test_pace_before() -> None:
    """At 7e815b6 the delay was the command's, and the bias had two signs at once."""
    found = taken("pace", vector(text=","), *PACE, "--commit", "7e815b6", exit=1)
    got = figures(found)
    assert got["delay"] == 0.0075 and "encoder_bias" not in got
    assert "the comparison subtracts it" in found.joints["hip"].left_out["encoder_bias"]


def test_pace_with_sliding_friction() -> None:
    """b09382f sets static and sliding friction to the same."""
    found = taken("pace", vector(), *PACE, "--commit", "b09382f", exit=1)
    assert figures(found)["friction.coulomb"] == 0.31 and "friction.static" not in figures(found)


def test_pace_with_command_delay_and_two_frictions(capsys: pytest.CaptureFixture[str]) -> None:
    """v0.2.0 delays the command, and fits sliding friction as a share of the static one: 0.5 x 0.31."""
    layout = ["--layout", "armature,viscous,friction,ratio,bias,delay", *PACE[5:], "--commit", "7ad0f45"]
    numbers = [*VECTOR[:6], 0.5, 0.25, *VECTOR[6:]]
    found = taken("pace", vector(numbers), *PACE[:3], *layout)
    got = figures(found)
    assert (got["friction.static"], got["friction.coulomb"], got["delay"]) == (0.31, 0.155, 0.0075)
    assert got["encoder_bias"] == -0.041 and figures(found, "knee")["friction.coulomb"] == 0.08
    numbers[6] = 1.2
    assert "at most the static one" in refused(capsys, "pace", vector(numbers), *PACE[:3], *layout)
    layout[1] = layout[1].replace("ratio,", "").replace("delay", "effort_delay")
    found = taken("pace", vector(), *PACE[:3], *layout, exit=1)
    assert figures(found)["friction.coulomb"] == 0.31 and "delay" not in figures(found)


def test_pace_in_another_layout() -> None:
    """Blocks are taken in the order that is stated."""
    more = ["--joint", "hip", "knee", "--layout", "viscous,armature", "--step", "1 ms", "--commit", "f8ec8b8"]
    assert figures(taken("pace", vector([1.0, 2.0, 3.0, 4.0]), *more), "knee") == {
        "friction.viscous": 2.0,
        "armature": 4.0,
    }


@pytest.mark.parametrize(
    ("more", "said"),
    [
        pytest.param([*PACE[3:], "--commit", "f8ec8b8"], "--joint", id="joints"),
        pytest.param([*PACE[:3], *PACE[5:], "--commit", "f8ec8b8"], "--layout", id="layout"),
        pytest.param([*PACE[:5], "--commit", "f8ec8b8"], "--step", id="step"),
        pytest.param(PACE, "--commit", id="commit"),
        pytest.param(
            [*PACE[:4], "armature,viscous,ratio,bias,delay", *PACE[5:], "--commit", "v0.2.0"],
            "not there",
            id="ratio",
        ),
        pytest.param([*PACE, "--commit", "0123456"], "is not known here", id="unknown commit"),
        pytest.param(["--joint", "", *PACE[2:], "--commit", "f8ec8b8"], "no name", id="empty name"),
        pytest.param(
            ["--joint", "hip", *PACE[3:], "--commit", "f8ec8b8"], "1 + 1 + 1 + 1 + 1 = 5", id="too few joints"
        ),
        pytest.param(
            [*PACE[:4], "armature,damping", *PACE[5:], "--commit", "f8ec8b8"], "'damping'", id="block"
        ),
        pytest.param(["--joint", "hip", "hip", *PACE[3:], "--commit", "f8ec8b8"], "named twice", id="twice"),
        pytest.param(
            [*PACE[:-1], "2.5 s", "--commit", "7ad0f45"], "must be at most 0.1 s, got 2.5 s", id="seconds"
        ),
    ],
)
def test_pace_is_refused_without_its_meaning(
    more: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """A vector without names is nothing without order, layout, step and commit."""
    assert said in refused(capsys, "pace", vector(), *more)


@pytest.mark.parametrize("name", ["mean_100.pt", "mean.csv", "results.pkl"])
def test_no_pickle_is_opened(name: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """By its name or its first bytes; the line that makes text of it is told."""

    class Trap:
        def __reduce__(self) -> tuple[Any, tuple[str]]:
            return (os.mkdir, (str(folder / "trapped"),))

    Path(name).write_bytes(pickle.dumps(Trap()))
    said = refused(capsys, "pace", name, *PACE, "--commit", "f8ec8b8")
    assert "SYS075" in said and "weights_only=True" in said
    assert not (folder / "trapped").exists()


def parameters(**changed: Any) -> str:
    """A `params_x_hat.yaml` as mujoco.sysid writes it: name to (value, nominal, low, high, frozen)."""
    given = {
        "hip_armature": ([0.031], [0.01], [0.001], [1.0], False),
        "damping_hip": ([0.42], [0.1], [0], [5], False),
        "hip_pdgain": ([25.5, 1.2], [20.0, 1.0], [0, 0], [100, 10], False),
        "knee.frictionloss": ([0.0005], [0.1], [0], [5], False),
        "knee_armature": ([0.02], [0.02], [0.001], [1.0], True),
        "odd": ([0.7], [0.5], [0], [9], False),
        **changed,
    }
    keys = ("value", "nominal", "min_value", "max_value", "frozen")
    data = {name: {"name": name, **dict(zip(keys, entry, strict=True))} for name, entry in given.items()}
    Path("params_x_hat.yaml").write_text(yaml.safe_dump(data, default_flow_style=False), encoding="utf-8")
    return "params_x_hat.yaml"


def test_mujoco_parameters_by_name(capsys: pytest.CaptureFixture[str]) -> None:
    """Joint and word name the field; frozen, at a bound (0.0005 of 5) and unnamed ones are left out and told."""
    found = taken("mujoco-sysid", parameters(), "--joint", "hip", "knee", "--step", "2 ms", exit=1)
    assert figures(found) == {"armature": 0.031, "friction.viscous": 0.42, "kp": 25.5, "kd": 1.2}
    knee = found.joints["knee"]
    assert knee.bounds_hit == ("friction.coulomb",) and "frozen" in knee.left_out["armature"]
    assert found.note is not None and "odd 0.7" in found.note
    # h kd / 2 = 0.002 x 1.2 / 2
    assert "hip 0.0012 kg*m^2 is missing in it" in capsys.readouterr().err


def test_mujoco_parameters_by_map() -> None:
    """`--map` names what the name does not; slides are in N and m."""
    more = ["--map", "odd=knee.friction.viscous", "--linear"]
    found = taken("mujoco-sysid", parameters(), *more, exit=1)
    viscous = found.joints["knee"].friction.viscous
    assert viscous is not None and (viscous.value, viscous.unit) == (0.7, "N*s/m")
    assert list(found.joints) == ["knee"]


@pytest.mark.parametrize(
    ("changed", "more", "said"),
    [
        pytest.param({}, [], "--joint", id="no joint"),
        pytest.param({}, ["--map", "odd=knee.stiffness"], "maps no parameter", id="field"),
        pytest.param({}, ["--map", "even=knee.kp"], "no parameter 'even'", id="name"),
        pytest.param({}, ["--joint", "hip", "--map", "odd=hip.armature"], "two parameters", id="twice"),
        pytest.param(
            {"hip_armature": ([-0.1], [0.1], [-1], [1], False)}, ["--joint", "hip"], "below 0", id="sign"
        ),
        pytest.param(
            {"hip_armature": (["x"], [0.1], [0], [1], False)}, ["--joint", "hip"], "a number", id="text"
        ),
    ],
)
def test_mujoco_parameters_refused(
    changed: dict[str, Any], more: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nothing is guessed."""
    assert said in refused(capsys, "mujoco-sysid", parameters(**changed), *more)


def test_mujoco_parameters_before_the_fit(capsys: pytest.CaptureFixture[str]) -> None:
    """`params_x_0.yaml` lies beside the result and looks like it."""
    data = yaml.safe_load(Path(parameters()).read_text("utf-8"))
    for entry in data.values():
        entry["value"] = entry["nominal"]
    Path("other.yaml").write_text(yaml.safe_dump(data), encoding="utf-8")
    assert "before the fit" in refused(capsys, "mujoco-sysid", "other.yaml", "--joint", "hip")
    os.rename("params_x_hat.yaml", "params_x_0.yaml")
    assert "before the fit" in refused(capsys, "mujoco-sysid", "params_x_0.yaml", "--joint", "hip")


def test_a_line_is_viscous_and_coulomb() -> None:
    """k v + b for every joint, or by joint; units as written, std taken along."""
    Path("line.yaml").write_text("k: 0.02 N*m*s/rad\nb: {value: 350 N*mm, std: 10 N*mm}\n", encoding="utf-8")
    found = taken("line", "line.yaml", "--joint", "hip", "knee")
    assert figures(found) == figures(found, "knee") == {"friction.viscous": 0.02, "friction.coulomb": 0.35}
    coulomb = found.joints["hip"].friction.coulomb
    assert coulomb is not None and coulomb.std == pytest.approx(0.01)
    text = "knee: {k: 0.1 N*m*s/rad, b: 0.3 N*m}\nhip: {k: 0.2 N*m*s/rad, b: 0.4 N*m}\n"
    Path("line.yaml").write_text(text, encoding="utf-8")
    assert figures(taken("line", "line.yaml"), "knee")["friction.coulomb"] == 0.3
    assert list(taken("line", "line.yaml", "--joint", "hip").joints) == ["hip"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        pytest.param("k: 0.02\nb: 0.3 N*m\n", "0.02 has no unit", id="no unit"),
        pytest.param("k: 0.02 N*m\nb: 0.3 N*m\n", "SYS072", id="kind"),
        pytest.param("k: 0.02 N*m*s/rad\nb: -0.3 N*m\n", "SYS072", id="negative"),
        pytest.param("k: 0.02 N*m*s/rad\n", "SYS070", id="no b"),
        pytest.param("include: [x.yaml]\n", "SYS070", id="include"),
        pytest.param("[1, 2", "SYS070", id="no YAML"),
    ],
)
def test_lines_refused(text: str, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    """A number without a unit is none."""
    Path("line.yaml").write_text(text, encoding="utf-8")
    assert said in refused(capsys, "line", "line.yaml", "--joint", "hip")


def test_friction_at_the_lower_bound_has_no_value() -> None:
    """Both tools search from 0 on: a friction of 1e-10 is the bound, not a measurement."""
    found = taken("bam", bam(friction_base=2e-10), "--joint", "hip", exit=1).joints["hip"]
    assert found.friction.coulomb is None and found.bounds_hit == ("friction.coulomb",)
    numbers = [0.01, 0.0, 0.3]
    more = [
        "--joint",
        "hip",
        "--layout",
        "armature,viscous,friction",
        "--step",
        "1 ms",
        "--commit",
        "f8ec8b8",
    ]
    found = taken("pace", vector(numbers), *more, exit=1).joints["hip"]
    assert found.friction.viscous is None and found.bounds_hit == ("friction.viscous",)


def test_json_may_be_indented_by_tabs() -> None:
    """YAML forbids it, JSON does not."""
    Path("m.json").write_text(json.dumps(M1, indent="\t"), encoding="utf-8")
    assert figures(taken("bam", "m.json", "--joint", "hip"))["kd"] == 0.75


def test_what_is_there_stays(capsys: pytest.CaptureFixture[str]) -> None:
    """`--force` replaces; options of another tool are refused."""
    Path("no.yaml").write_text("mine", encoding="utf-8")
    command = ["sysid", "import", bam(), "--from", "bam", "--robot", "leg", "--joint", "hip", "-o", "no.yaml"]
    assert main(command) == 2 and Path("no.yaml").read_text("utf-8") == "mine"
    assert main([*command, "--step", "1 ms", "--force"]) == 2 and Path("no.yaml").read_text("utf-8") == "mine"
    assert main([*command, "--force"]) == 0 and "armature" in Path("no.yaml").read_text("utf-8")
