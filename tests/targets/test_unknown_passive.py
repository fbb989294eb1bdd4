"""What the spec says is unknown of armature and friction: one truth in every target, reported in each."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec import api
from actspec.ir import Origin
from actspec.report.show import details

MODEL = """<mujoco model="leg"><default><joint damping="0.1"/></default><worldbody><body name="thigh">
<joint name="hip" axis="0 1 0"{}/><geom size="0.1" mass="1"/></body></worldbody></mujoco>"""
SPEC = """actspec: 1
robot: {{name: leg, model: leg.xml}}
motors: {{m: {{side: joint, peak_torque: 20 N*m, gear_ratio: 8, {motor}}}}}
actuators:
  legs: {{joints: [hip], motor: m, level: ideal_pd, kp: 60, kd: 1.5{group}}}
targets: {{mujoco: {{version: "3.12"}}, isaaclab: {{version: "2.3"}}, mjlab: {{version: "1.6"}}, newton: {{}}}}
{more}
"""


def compiled(
    folder: Path,
    motor: str = "rotor_inertia: unknown",
    group: str = "",
    *,
    armature: str = "",
    more: str = "",
) -> api.Compilation:
    """A joint whose damping the file states, and whose armature it may."""
    (folder / "leg.xml").write_text(MODEL.format(armature), "utf-8")
    (folder / "leg.yaml").write_text(SPEC.format(motor=motor, group=group, more=more), "utf-8")
    return api.compile(folder / "leg.yaml", output=str(folder / "out"))


def warned(done: api.Compilation) -> list[str]:
    """Codes of the warnings about the armature."""
    return [item.code for item in done.diagnostics if item.code in ("MJC016", "ISL030")]


@pytest.mark.parametrize(
    "motor, group",
    [
        ("rotor_inertia: unknown", ""),
        ("reflected_inertia: unknown", ""),
        ("rotor_inertia: 1e-4 kg*m^2", ", armature: unknown"),
    ],
    ids=["rotor", "reflected", "group"],
)
def test_unknown_armature_is_not_0(tmp_path: Path, motor: str, group: str) -> None:
    """MuJoCo's own 0 and the stage's number are approximations, in all targets alike, and no number of the spec."""
    done = compiled(tmp_path, motor, group)
    (joint,) = done.actuators.joints
    assert joint.armature.value is None and joint.armature.span is not None
    assert warned(done) == ["ISL030", "MJC016"]
    found = {(loss.key, loss.asked, loss.emitted) for loss in done.approximations}
    assert found == {
        ("mujoco.armature", "unknown", "0 kg*m^2, MuJoCo's default"),
        ("isaaclab.armature", "unknown", "the USD's own"),
        ("mjlab.armature", "unknown", "0 kg*m^2, MuJoCo's default"),
        ("newton.armature", "unknown", "the stage's own"),
    }


def test_what_the_file_states_is_known(tmp_path: Path) -> None:
    """An armature of the file goes before a rotor that is unknown: 0.03, of origin model, nothing is lost."""
    done = compiled(tmp_path, armature=' armature="0.03"')
    (joint,) = done.actuators.joints
    assert (joint.armature.value, joint.armature.origin) == (0.03, Origin.MODEL)
    assert not warned(done) and not done.approximations


def test_what_nobody_speaks_of_is_not_asked_for(tmp_path: Path) -> None:
    """A motor without a word of its rotor: the file's default as ever, and no loss."""
    done = compiled(tmp_path, "note: nothing of the rotor")
    assert done.actuators.joints[0].armature.origin is Origin.DEFAULT
    assert not warned(done) and not done.approximations


def test_accepted(tmp_path: Path) -> None:
    """`accept` takes it by its name, and the warning of that target with it."""
    done = compiled(tmp_path, more="accept: {mujoco.armature: nobody knows it}")
    assert warned(done) == ["ISL030"]
    assert "mujoco.armature" not in {loss.key for loss in done.unaccepted}


def test_unknown_friction(tmp_path: Path) -> None:
    """The file's 0.1 acts in MuJoCo and mjlab, and its default 0 as dry friction: each is said."""
    rotor = "rotor_inertia: 1e-4 kg*m^2"
    done = compiled(tmp_path, rotor, ", friction: {viscous: unknown, coulomb: unknown}")
    found = {loss.key: loss.emitted for loss in done.approximations}
    assert found == {
        "mujoco.friction.viscous": "0.1 N*m*s/rad, the file's",
        "mujoco.friction.coulomb": "0 N*m, MuJoCo's default",
        "mjlab.friction.viscous": "0.1 N*m*s/rad, the model's own",
        "mjlab.friction.coulomb": "0 N*m, MuJoCo's default",
        "isaaclab.friction.viscous": "the USD's own",
        "isaaclab.friction.coulomb": "the USD's own",
        "newton.friction.viscous": "the stage's own",
        "newton.friction.coulomb": "the stage's own",
    }
    assert all(loss.max_torque_error is None for loss in done.approximations)
    assert "viscous friction, which is unknown" in "\n".join(details(done.actuators.joints[0], ()))


def test_shown_inertia_lacks_an_unknown_armature(tmp_path: Path) -> None:
    """What `show` computes of the inertia says that the armature is not in it; of a known one it does not."""
    said = ["\n".join(details(compiled(tmp_path, motor).actuators.joints[0], ())) for motor in (
        "rotor_inertia: unknown", "rotor_inertia: 1e-4 kg*m^2")]  # fmt: skip
    assert ["armature is unknown" in text for text in said] == [True, False]
