"""Identified values: where they stand, why one is missing, on which gains they rest, and what is drawn apart."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest

from actspec import api
from actspec.diagnostics import ResolveError, Severity, SpecError
from actspec.ir import Origin

MODEL = """<mujoco><worldbody><body name="thigh"><joint name="hip" axis="0 1 0" range="-1 1"/>
<geom size="0.1" mass="1"/></body></worldbody><actuator><motor joint="hip" ctrlrange="-40 40"/></actuator></mujoco>"""
SPEC = """actspec: 1
robot: {{name: leg, model: leg.xml}}
actuators:
  legs: {{joints: [hip], level: ideal_pd, kp: 25, kd: 0.5, effort_limit: 30, identified: results/leg.yaml{more}}}
"""
RESULTS = """format: actspec-results/1
robot: leg
method: rollout
date: "2026-11-21"
temperature: warm
joints:
  hip:
    armature: {value: 0.0104 kg*m^2, std: 0.0002 kg*m^2}
    delay: 6 ms
    friction:
      coulomb: {value: 0.21, std: 0.02}
    gains: {kp: 20, kd: 0.5}
    unidentifiable: [encoder_bias, friction.viscous]
    bounds_hit: [friction.static]
    left_out: {bandwidth: the tool has no such figure}
    combinations:
      kd+friction.viscous: {value: 0.62, std: 0.01, unit: N*m*s/rad}
    correlation: [[armature, friction.coulomb, -0.91], [armature, delay, 0.4]]
    reasons: {encoder_bias: without gravity on the joint it shows in nothing}
"""
"""armature stands on line 8, delay on 9, Coulomb on 11."""


@pytest.fixture
def leg(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A robot and its results; the working folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "results").mkdir()
    (tmp_path / "leg.xml").write_text(MODEL, encoding="utf-8")
    (tmp_path / "results" / "leg.yaml").write_text(RESULTS, encoding="utf-8")
    return tmp_path


def spec(folder: Path, more: str = "") -> str:
    """A spec beside the robot, with more fields in its group."""
    (folder / "leg.yaml").write_text(SPEC.format(more=more and ", " + more), encoding="utf-8")
    return "leg.yaml"


def refused(folder: Path, more: str) -> list[str]:
    """What is said against a spec, with place and help."""
    with pytest.raises(ResolveError) as caught:
        api.resolve(spec(folder, more))
    return [str(d) for d in caught.value.diagnostics if d.severity is Severity.ERROR]


def test_where_is_the_line_of_the_results(leg: Path) -> None:
    """A figure stands where the results have it, be it a winner or passed over."""
    joint = api.resolve(spec(leg, "friction: {coulomb: 0.2}")).joints[0]
    assert joint.delay is not None
    assert (str(joint.armature.span), joint.armature.source) == ("results/leg.yaml:8:15", "results/leg.yaml")
    assert (str(joint.delay.nominal.span), str(joint.friction_coulomb.span)) == (
        "results/leg.yaml:9:12",
        "leg.yaml:4:127",
    )
    (lost, *_) = joint.friction_coulomb.lost
    assert (lost.origin, str(lost.span)) == (Origin.IDENTIFIED, "results/leg.yaml:11:16")


@pytest.mark.parametrize(
    ("more", "said", "helps"),
    [
        pytest.param(
            "encoder_bias: identified",
            "encoder_bias is to be the identified value, but results/leg.yaml:13:22 lists it as unidentifiable: "
            "without gravity on the joint it shows in nothing",
            "base: {orientation",
            id="unidentifiable",
        ),
        pytest.param(
            "friction: {viscous: identified}",
            "friction.viscous is to be the identified value, but results/leg.yaml:13:36 lists it as unidentifiable; "
            "it has kd+friction.viscous = 0.62 N*m*s/rad",
            "log the torque",
            id="a sum is known",
        ),
        pytest.param(
            "friction: {static: identified}",
            "friction.static is to be the identified value, but results/leg.yaml:14:18 lists it as at a bound of the "
            "fit",
            "`actspec sysid design --experiment friction`",
            id="at a bound",
        ),
        pytest.param(
            "command_filter: {cutoff: identified}",
            "command_filter is to be the identified value, but results/leg.yaml:15:27 left it out: the tool has no "
            "such figure",
            "write the number here",
            id="left out by an import",
        ),
        pytest.param(
            "randomize: {kp: {from: identified}}",
            "no identified standard deviation of kp to take the range from: the fit took 20 as given "
            "(results/leg.yaml:12:17)",
            "scale, add or abs",
            id="held",
        ),
        pytest.param(
            "randomize: {delay: {from: identified}}",
            "no identified standard deviation of delay to take the range from: results/leg.yaml:9:12 has 0.006 s "
            "without `std`",
            "write `std` there",
            id="no std",
        ),
        pytest.param(
            "randomize: {encoder_bias: {from: identified}}",
            "no identified standard deviation of encoder_bias to take the range from: results/leg.yaml:13:22 lists it "
            "as unidentifiable: without gravity on the joint it shows in nothing",
            "scale, add or abs",
            id="range of what is not told",
        ),
    ],
)
def test_why_there_is_no_value(leg: Path, more: str, said: str, helps: str) -> None:
    """The file's reason, its line, and the experiment that would tell."""
    (error,) = refused(leg, more)
    message, help = error.split("\n")
    assert message.endswith(f": hip: {said}")
    assert helps in help


def test_a_joint_that_the_results_lack(leg: Path) -> None:
    """The names that they have are told."""
    (leg / "results" / "leg.yaml").write_text(RESULTS.replace("  hip:", "  hipp:"), encoding="utf-8")
    (error,) = refused(leg, "armature: identified")
    assert "but results/leg.yaml has no such joint, its joints are hipp" in error


def test_joints_that_the_results_lack_are_told_together(leg: Path) -> None:
    """One error a field with the names of all, and not one a joint."""
    ankles = "".join(f'<body><joint name="toe{i}"/><geom size="0.1"/></body>' for i in range(3))
    (leg / "leg.xml").write_text(
        MODEL.replace("</body></worldbody>", f"{ankles}</body></worldbody>"), encoding="utf-8"
    )
    spec(leg, "armature: identified, randomize: {delay: {from: identified}}")
    text = (leg / "leg.yaml").read_text(encoding="utf-8")
    (leg / "leg.yaml").write_text(text.replace("joints: [hip]", "joints: ['toe.*', hip]"), encoding="utf-8")
    with pytest.raises(ResolveError) as caught:
        api.resolve("leg.yaml")
    told = [d.message for d in caught.value.diagnostics if "no such joint" in d.message]
    assert len(told) == 2
    assert all(message.startswith("toe0, toe1, toe2: ") for message in told)


def test_figures_that_rest_on_other_gains(leg: Path) -> None:
    """The fit held kp 20, the spec has 25: armature and friction carry that factor."""
    (found,) = [d for d in api.resolve(spec(leg)).diagnostics if d.code == "SPEC175"]
    assert found.message == (
        "hip: armature and friction.coulomb rest on gains that the fit took as given: kp 20 N*m/rad, the spec has "
        "25 N*m/rad"
    )
    assert (found.severity, str(found.span)) == (Severity.INFO, "results/leg.yaml:12:12")


def test_equal_gains_and_own_figures_say_nothing(leg: Path) -> None:
    """0.5 % is rounding; and where the spec states the figures itself, none rests on the fit's gains."""
    own = "armature: 0.01, friction: {coulomb: 0.2}"
    assert "SPEC175" not in {d.code for d in api.resolve(spec(leg, own)).diagnostics}
    (leg / "results" / "leg.yaml").write_text(RESULTS.replace("kp: 20", "kp: 25.1"), encoding="utf-8")
    assert "SPEC175" not in {d.code for d in api.resolve(spec(leg)).diagnostics}


def test_draws_of_fields_whose_errors_go_together(leg: Path) -> None:
    """Two ranges of one fit at |r| 0.91 are an approximation that can be accepted; one range, or r 0.4, is none."""
    both = "randomize: {armature: {from: identified}, friction.coulomb: {from: identified}}"
    (loss,) = api.resolve(spec(leg, both)).approximations
    assert (loss.key, loss.joint, loss.max_torque_error) == ("spec.correlation", "hip", None)
    assert loss.asked == "armature and friction.coulomb with a correlation of -0.91"
    one = "randomize: {armature: {from: identified}, friction.coulomb: {scale: [0.9, 1.1]}}"
    assert api.resolve(spec(leg, one)).approximations == ()
    (leg / "results" / "leg.yaml").write_text(RESULTS.replace("-0.91", "0.5"), encoding="utf-8")
    assert api.resolve(spec(leg, both)).approximations == ()


def test_the_results_file_is_a_source(leg: Path) -> None:
    """Heads of generated files say how and when a figure was found, and of which bytes."""
    done = api.compile(spec(leg), targets=["mujoco==3.12"])
    text = done.emissions[0].files[0].data.decode()
    digest = hashlib.sha256(RESULTS.encode()).hexdigest()
    assert "armature 0.0104 kg*m^2 (identified; results/leg.yaml; std 0.0002 kg*m^2)" in text
    assert f"results/leg.yaml: identification by rollout, 2026-11-21, motors warm, sha256 {digest}" in text


def test_fields_that_results_do_not_have(leg: Path) -> None:
    """A misspelt field would compile as if the file did not doubt it."""
    (leg / "results" / "leg.yaml").write_text(
        RESULTS.replace("[friction.static]", "[coulomb]"), encoding="utf-8"
    )
    with pytest.raises(SpecError) as caught:
        api.load(spec(leg))
    (found,) = caught.value.diagnostics
    assert (found.code, str(found.span), found.message) == (
        "SPEC174",
        "results/leg.yaml:14:18",
        "'coulomb' is no field of a joint's results",
    )
    assert found.help == "did you mean 'friction.coulomb'?"
