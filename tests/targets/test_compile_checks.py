"""What a compile says of its targets together: explicit drives, accepted losses, places of errors."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from actspec import api
from actspec.diagnostics import Diagnostic, EmitError, Severity, Span

MODEL = """<mujoco><option timestep="0.002" integrator="%s"/><worldbody><body><joint name="hip"/>
<geom type="sphere" size="0.05" mass="1"/></body></worldbody></mujoco>"""

SPEC = """actspec: 1
robot: {name: leg, model: leg.xml}
motors: {m: {side: joint, stall_torque: 20 N*m, no_load_speed: 30 rad/s}}
actuators:
  legs: {joints: [hip], level: LEVEL, motor: m, kp: 40, kd: 13, effort_limit: 12, armature: 0.01}
targets:
  mujoco: {}
  isaaclab: {class: CLASS}
  mjlab: {}
  deploy: {}
"""
"""h kd / I + h^2 kp / (2 I) = 0.002 x 13 / 0.011 + 4e-6 x 40 / 0.022 = 2.37."""


def compiled(folder: Path, spec: str, *targets: str, integrator: str = "Euler") -> tuple[Diagnostic, ...]:
    """What a compile says."""
    (folder / "leg.xml").write_text(MODEL % integrator)
    (folder / "leg.yaml").write_text(spec)
    return api.compile(folder / "leg.yaml", targets=targets, output=str(folder / "out")).diagnostics


def concerned(said: tuple[Diagnostic, ...]) -> str | None:
    """What STB102 names; None where it is not said."""
    found = [item.message.partition("; concerns ")[2] for item in said if item.code == "STB102"]
    assert len(found) <= 1
    return found[0] if found else None


EULER = "MuJoCo with the Euler integrator"


@pytest.mark.parametrize(
    ("level", "cls", "integrator", "targets", "expected"),
    [
        ("ideal_pd", "auto", "Euler", (), f"{EULER}, isaaclab"),
        ("ideal_pd", "auto", "implicitfast", (), "isaaclab"),
        ("ideal_pd", "implicit", "implicitfast", (), None),
        ("ideal_pd", "custom", "implicitfast", (), "isaaclab"),
        ("dc_motor", "auto", "implicitfast", (), "isaaclab, mjlab"),
        ("dc_motor", "implicit", "Euler", (), f"{EULER}, mjlab"),
        ("ideal_pd", "auto", "Euler", ("mjlab", "deploy"), None),
        ("ideal_pd", "auto", "Euler", ("isaaclab",), "isaaclab"),
        ("ideal_pd", "auto", "Euler", ("mujoco==3.11",), EULER),
        ("dc_motor", "auto", "Euler", ("deploy",), None),
    ],
)
def test_explicit_drives_of_what_is_compiled(
    level: str, cls: str, integrator: str, targets: tuple[str, ...], expected: str | None, tmp_path: Path
) -> None:
    """Each chosen target answers for its own drive: mjlab's builtin ones and the solver's are implicit."""
    spec = SPEC.replace("LEVEL", level).replace("CLASS", cls)
    assert concerned(compiled(tmp_path, spec, *targets, integrator=integrator)) == expected


@pytest.mark.parametrize(
    ("right", "wrong", "code"),
    [
        # kd/kp is 3.1 s.
        ("kp: 40, kd: 13", "kp: 13, kd: 40", "SPEC192"),
        # The armature is a tenth of the motor's inertia.
        ("30 rad/s}", "30 rad/s, reflected_inertia: 0.1}", "SPEC191"),
    ],
)
def test_no_stability_of_a_doubted_number(right: str, wrong: str, code: str, tmp_path: Path) -> None:
    """One message a cause: the gain or the armature, not that the step is too long for it."""
    spec = SPEC.replace("LEVEL", "dc_motor").replace("CLASS", "auto")
    assert concerned(compiled(tmp_path, spec)) is not None
    said = compiled(tmp_path, spec.replace(right, wrong))
    assert code in [item.code for item in said]
    assert concerned(said) is None


LOSSY = (
    SPEC.replace("LEVEL", "ideal_pd")
    .replace("CLASS", "auto")
    .replace("armature: 0.01", "armature: 0.01, command_filter: {cutoff: 30 Hz}")
)
"""The filter is lost in Isaac Lab and mjlab, and kept in MuJoCo."""


def stale(said: tuple[Diagnostic, ...]) -> list[tuple[str, str | None]]:
    """Keys of `accept` that take nothing, with their help."""
    return [(item.where.removeprefix("accept."), item.help) for item in said if item.code == "SPEC164"]


@pytest.mark.parametrize(
    ("key", "targets", "expected"),
    [
        ("isaaclab.command_filter", (), []),
        ("isaaclab.comand_filter", (), ["did you mean 'isaaclab.command_filter'?"]),
        ("isaaclab.delay", (), ["remove it; its losses are command_filter"]),
        ("mujoco.command_filter", (), ["remove it; it loses nothing"]),
        ("isaaclab.delay", ("mjlab",), []),
        ("isaaclab.delay", ("isaaclab==2.2",), []),
        ("isaaclab.delay", ("isaaclab==2.3",), ["remove it; its losses are command_filter"]),
    ],
)
def test_accept_that_takes_nothing(
    key: str, targets: tuple[str, ...], expected: list[str], tmp_path: Path
) -> None:
    """A loss that does not occur in a target that is compiled as the spec has it is named, with the nearest."""
    said = compiled(tmp_path, f"{LOSSY}accept: {{{key}: because}}\n", *targets)
    assert stale(said) == [(key, text) for text in expected]
    for item in said:
        if item.code == "SPEC164":
            assert item.severity is Severity.WARNING
            assert item.span == Span(str(tmp_path / "leg.yaml"), 11, 10)


@pytest.mark.parametrize(
    ("code", "kp", "expected"),
    [("SPEC192", "40", ["remove it"]), ("SPEC192", "5", []), ("SPEC190", "5", ["remove it"])],
)
def test_accept_of_a_check_that_finds_nothing(
    code: str, kp: str, expected: list[str], tmp_path: Path
) -> None:
    """kd 13 beside kp 5 takes 2.6 s to come back, which SPEC192 finds; beside 40 it is 0.3 s."""
    said = compiled(
        tmp_path, f"{LOSSY.replace('kp: 40', f'kp: {kp}')}accept: {{spec.{code}: because}}\n", "mujoco"
    )
    assert stale(said) == [(f"spec.{code}", text) for text in expected]


NAMELESS = """actspec: 1
robot:
  name: leg
  model: none
  joints: [hip]
actuators: {legs: {joints: [hip], level: ideal_pd, kp: 25, kd: 0.5}}
"""


@pytest.mark.parametrize(
    ("target", "code"), [("mujoco", "MJC009"), ("urdf", "URD001")], ids=["mujoco", "urdf"]
)
def test_no_model_has_its_place(tmp_path: Path, target: str, code: str) -> None:
    """A target's error about `model: none` stands where that is written."""
    (tmp_path / "leg.yaml").write_text(NAMELESS)
    with pytest.raises(EmitError) as caught:
        api.compile(tmp_path / "leg.yaml", targets=[target], output=str(tmp_path / "out"), canonical=True)
    (fault,) = [item for item in caught.value.diagnostics if item.severity is Severity.ERROR]
    assert (fault.code, fault.span) == (code, Span(str(tmp_path / "leg.yaml"), 4, 10))


def test_what_a_target_lacks_has_its_place(tmp_path: Path) -> None:
    """An option that is not there is missed at the target; one that only the command line asks for has no line."""
    text = NAMELESS + "targets:\n  stage: {target: newton, root: /World}\n"
    (tmp_path / "leg.yaml").write_text(text)
    for target, place in (("stage", Span(str(tmp_path / "leg.yaml"), 8, 3)), ("newton", None)):
        with pytest.raises(EmitError) as caught:
            api.compile(tmp_path / "leg.yaml", targets=[target], output=str(tmp_path / "out"))
        (fault,) = [item for item in caught.value.diagnostics if item.severity is Severity.ERROR]
        assert (fault.code, fault.span) == ("NWT009", place)


@pytest.mark.skipif(os.sep != "/", reason="no such names here")
@pytest.mark.parametrize(("target", "code"), [("mujoco", "MJC008"), ("urdf", "URD005")])
@pytest.mark.parametrize(
    ("name", "reason"), [(b"f\xff", "XML cannot hold the path"), (b"a\\b", "takes a backslash for a slash")]
)
def test_a_folder_that_a_model_cannot_name(
    target: str, code: str, name: bytes, reason: str, tmp_path: Path
) -> None:
    """What is written beside the model names its mesh; from elsewhere it cannot, and a compile says so."""
    folder = Path(os.fsdecode(bytes(tmp_path) + b"/" + name))
    try:
        folder.mkdir()
    except OSError:
        pytest.skip("this file system takes UTF-8 alone")
    mass = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    mesh = '<collision><geometry><mesh filename="m.stl"/></geometry></collision>'
    (folder / "leg.urdf").write_text(
        f'<robot name="leg"><link name="a">{mass}</link><link name="b">{mass}{mesh}</link><joint name="hip" '
        'type="revolute"><parent link="a"/><child link="b"/><limit effort="3" velocity="3" lower="-1" upper="1"/>'
        "</joint></robot>"
    )
    (folder / "leg.yaml").write_text(
        NAMELESS.replace("none", "leg.urdf")
        .replace("  joints: [hip]\nact", "act")
        .replace("kd", "armature: 1, kd")
    )
    (emission,) = api.compile(folder / "leg.yaml", targets=[target], output=str(folder / "out")).emissions
    assert b"f\xff" not in emission.files[0].data
    with pytest.raises(EmitError) as caught:
        api.compile(folder / "leg.yaml", targets=[target], output=str(tmp_path / "out"))
    (fault,) = [item for item in caught.value.diagnostics if item.severity is Severity.ERROR]
    assert fault.code == code and reason in fault.message and fault.help is not None
    assert fault.help.startswith("rename the folder")


def test_names_that_usd_changes_have_their_place(tmp_path: Path) -> None:
    """The first joint whose name is no identifier is where the robot's file has it."""
    spec = SPEC.replace("LEVEL", "ideal_pd").replace("CLASS", "auto").replace("[hip]", '["hip-1"]')
    (tmp_path / "leg.yaml").write_text(spec)
    (tmp_path / "leg.xml").write_text((MODEL % "Euler").replace('"hip"', '"hip-1"'))
    said = api.compile(tmp_path / "leg.yaml", targets=["isaaclab"], output=str(tmp_path / "out")).diagnostics
    (item,) = [item for item in said if item.code == "ISL032"]
    assert item.where == "hip-1"
    assert item.span is not None and (item.span.path, item.span.line) == (str(tmp_path / "leg.xml"), 1)


FREE = """actspec: 1
robot: {name: leg, model: leg.xml}
motors: {m: {side: joint, stall_torque: 20 N*m, no_load_speed: 30 rad/s}}
actuators:
  legs: {joints: [hip], level: ideal_pd, kp: 40, kd: 1, effort_limit: unknown, armature: 0.01}
targets:
  mujoco: {}
  mjlab: {}
  newton: {root: /World/leg, joint_paths: {".*": leg}}
  deploy: {}
"""


def without_limit(said: tuple[Diagnostic, ...]) -> list[str]:
    """What SPEC166 says."""
    return [item.message for item in said if item.code == "SPEC166"]


@pytest.mark.parametrize(
    ("right", "wrong", "model", "expected"),
    [
        ("", "", "", "mujoco, mjlab, newton get"),
        # The file's own limit of the joint acts on what every drive gives.
        ("", "", '<joint name="hip" actuatorfrcrange="-9 9"/>', None),
        ("", "", '<joint name="hip" actuatorfrcrange="-1e6 1e6"/>', "mujoco, mjlab, newton get"),
        ("effort_limit: unknown, ", "", '<joint name="hip" actuatorfrcrange="-9 9"/>', None),
        # Left out it is as unknown, where the file says nothing.
        ("effort_limit: unknown, ", "", "", "mujoco, mjlab, newton get"),
        ("effort_limit: unknown", "effort_limit: 9", "", None),
        ('  mjlab: {}\n  newton: {root: /World/leg, joint_paths: {".*": leg}}\n', "", "", "mujoco gets"),
        ("actuators:", "accept: {mjlab.effort_limit: a bench}\nactuators:", "", "mujoco, newton get"),
        # A line ends at the stall torque.
        (
            "level: ideal_pd, kp: 40, kd: 1, effort_limit: unknown",
            "level: dc_motor, motor: m, kp: 40, kd: 1",
            "",
            None,
        ),
    ],
    ids=["all", "joint", "placeholder", "of the file", "left out", "stated", "one", "accepted", "line"],
)
def test_a_drive_without_any_limit(
    right: str, wrong: str, model: str, expected: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each target that is written without a limit is named, at the group's line; an accepted one is not."""
    assert right in FREE
    if model:
        monkeypatch.setattr(f"{__name__}.MODEL", MODEL.replace('<joint name="hip"/>', model))
    said = compiled(tmp_path, FREE.replace(right, wrong) if right else FREE)
    whole = f"hip: effort_limit is unknown, and {expected} a drive of unlimited torque"
    assert without_limit(said) == ([] if expected is None else [whole])
    assert "SPEC164" not in [item.code for item in said]


def test_a_limit_of_the_files_own_actuator(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """MuJoCo's drive keeps it; mjlab's has none of it, as the file's actuators are taken out."""
    servo = '</worldbody><actuator><position joint="hip" kp="40" forcerange="-9 9"/></actuator>'
    monkeypatch.setattr(f"{__name__}.MODEL", MODEL.replace("</worldbody>", servo))
    (told,) = without_limit(compiled(tmp_path, FREE, "mujoco", "mjlab"))
    assert "and mjlab gets a drive" in told


def test_an_accepted_limit_that_is_there(tmp_path: Path) -> None:
    """What is accepted and does not occur takes nothing."""
    spec = FREE.replace("unknown", "9") + "accept: {mujoco.effort_limit: a bench}\n"
    assert "SPEC164" in [item.code for item in compiled(tmp_path, spec, "mujoco")]
