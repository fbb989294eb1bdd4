"""The checks catch faults: each is seeded once, in the plan or in one of its two applications.

The seeded plan stands for a slip of the compiler; nothing here is a stranger's input.
"""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from actspec.diagnostics import Diagnostic
from actspec.ir import ActuatorSet
from actspec.robot.mjspec import compile_spec, open_spec
from actspec.robot.view import ModelFormat, RobotView
from actspec.simulators.mujoco import MujocoDialect, installed_dialect
from actspec.targets.mujoco.apply_spec import apply_to_spec
from actspec.targets.mujoco.check import check_readback, differences, outside_plan
from actspec.targets.mujoco.plan import JointEdit, Plan
from tests.compiling import Compiled, compile_text, view_of

mujoco = pytest.importorskip("mujoco")

ROBOT = """<mujoco>
  <worldbody>
    <body><joint name="hip" damping="0.1" armature="0.2" frictionloss="0.3"/><geom size=".1"/></body>
    <body><joint name="knee" damping="0.4" stiffness="5"/><geom size=".1"/></body>
  </worldbody>
  <actuator>
    <motor name="h" joint="hip"/>
    <motor name="k" joint="knee"/>
  </actuator>
</mujoco>
"""
GROUP = """  g:
    joints: [hip]
    level: ideal_pd
    kp: 40
    kd: 2
    effort_limit: 9
    armature: 0.05
    friction: {viscous: 0.25, coulomb: 0.6}
"""


@pytest.fixture(scope="module")
def compiled() -> Compiled:
    return compile_text(GROUP, ROBOT, robot="unmanaged: [knee]")


def readback(actuators: ActuatorSet, text: str) -> list[Diagnostic]:
    return list(check_readback(actuators, view_of(text)))


def broken(text: str, pattern: str, replacement: str) -> str:
    """The written text with one number changed."""
    found, count = re.subn(pattern, replacement, text)
    assert count == 1
    return found


def test_a_right_file_passes(compiled: Compiled) -> None:
    """Without a fault the checks say nothing."""
    assert readback(compiled.actuators, compiled.text) == []


@pytest.mark.parametrize(
    ("code", "pattern", "replacement", "says"),
    [
        # 0.25 added to kd as well
        ("DMP002", 'kv="2"', 'kv="2.25"', "damping is 2.5 N*m*s/rad in the written model"),
        ("DMP002", 'damping="0.25"', 'damping="0"', "damping is 2 N*m*s/rad in the written model"),
        ("DMP002", 'gear="1"', 'gear="1" damping="0.1"', "actuator 0.1"),
        ("FRC003", 'frictionloss="0.6"', 'frictionloss="0.0105"', "the spec asks for 0.6 N*m"),
        ("RTP001", 'kp="40"', 'kp="41"', "stiffness is 41"),
        ("RTP002", 'armature="0.05"', 'armature="0.06"', "armature is 0.06"),
        ("RTP003", 'forcerange="-9 9"', 'forcerange="-8 8"', "the effort limit is 8"),
        ("RTP004", 'joint="hip" kp', 'joint="knee" kp', "0 drives"),
    ],
    ids=["twice", "lost", "actuator", "friction", "kp", "armature", "limit", "drive"],
)
def test_readback_catches(compiled: Compiled, code: str, pattern: str, replacement: str, says: str) -> None:
    """A number of the written file that is not the spec's is an error that names both."""
    faults = readback(compiled.actuators, broken(compiled.text, pattern, replacement))
    assert [fault.code for fault in faults] == [code]
    assert says in faults[0].message


def edited(robot: RobotView, plan: Plan, dialect: MujocoDialect) -> object:
    spec = open_spec(robot.files, format=ModelFormat.MJCF)
    apply_to_spec(spec, plan, dialect, "test")
    return compile_spec(spec, robot.files)


STRAY = {
    "joint": (Plan(joints=(JointEdit("knee", armature=0.3),)), "dof_armature"),
    "stiffness": (Plan(joints=(JointEdit("knee", stiffness=1.0),)), "jnt_stiffness"),
    "step": (Plan(timestep=0.001), "opt.timestep"),
}


@pytest.mark.parametrize(("more", "field"), STRAY.values(), ids=STRAY.keys())
def test_an_edit_outside_of_the_plan_is_caught(more: Plan, field: str) -> None:
    """What the applied plan does and the stated one does not is named by field."""
    robot = view_of(ROBOT)
    original = edited(robot, Plan(), installed_dialect())
    assert outside_plan(original, original, Plan(), robot) == []
    found = outside_plan(original, edited(robot, more, installed_dialect()), Plan(), robot)
    assert [item.split(":")[0] for item in found] == [field]


def test_an_edited_foreign_actuator_is_caught(compiled: Compiled) -> None:
    """A number of an actuator that the plan leaves alone is compared too, and it is named."""
    robot = view_of(ROBOT)
    original = edited(robot, Plan(), installed_dialect())
    other = view_of(broken(ROBOT, 'name="k" joint="knee"', 'name="k" joint="knee" gear="2"'))
    found = outside_plan(original, edited(other, Plan(), installed_dialect()), Plan(), robot)
    assert "actuator_gear of 'k': 1.0 against 2.0 at [0]" in found


def test_a_text_that_is_another_model_is_caught(compiled: Compiled) -> None:
    """Each field in which two models differ is named, with the first numbers that do."""
    one = mujoco.MjModel.from_xml_string(compiled.text)
    assert differences(one, mujoco.MjModel.from_xml_string(compiled.text)) == []
    text = broken(compiled.text, 'damping="0.25"', 'damping="0.26"')
    found = differences(one, mujoco.MjModel.from_xml_string(text))
    assert found == ["dof_damping: 0.25 against 0.26 at [0]"]
    renamed = broken(compiled.text, 'name="k"', 'name="l"')
    assert any(item.startswith("names") for item in differences(one, mujoco.MjModel.from_xml_string(renamed)))


def test_mjc090_stops_the_compile(monkeypatch: pytest.MonkeyPatch) -> None:
    """An application that reaches another joint ends in MJC090 and writes nothing."""
    from actspec.diagnostics import EmitError
    from actspec.targets.mujoco import emit as module

    def careless(spec: object, plan: Plan, *rest: object, **named: object) -> None:
        more = replace(plan, joints=(*plan.joints, JointEdit("knee", frictionloss=0.7)))
        apply_to_spec(spec, more, *rest, **named)  # type: ignore[arg-type]

    monkeypatch.setattr(module, "apply_to_spec", careless)
    with pytest.raises(EmitError, match=r"MJC090: .*dof_frictionloss"):
        compile_text(GROUP, ROBOT, robot="unmanaged: [knee]")


def test_mjc091_stops_the_compile(monkeypatch: pytest.MonkeyPatch) -> None:
    """A text edit that is not the plan's ends in MJC091, with the field and both numbers."""
    from actspec.diagnostics import EmitError
    from actspec.targets.mujoco import emit as module
    from actspec.targets.mujoco.apply_text import text_edits

    def careless(document: object, plan: Plan, *rest: object) -> object:
        (joint,) = plan.joints
        return text_edits(document, replace(plan, joints=(replace(joint, armature=0.051),)), *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(module, "text_edits", careless)
    with pytest.raises(EmitError, match=r"MJC091: .*dof_armature: 0\.05 against 0\.051"):
        compile_text(GROUP, ROBOT, robot="unmanaged: [knee]")


def test_an_edit_that_mujoco_refuses_is_not_blamed_on_the_file(monkeypatch: pytest.MonkeyPatch) -> None:
    """The file compiled as it was: MJC091 names the joint, and no ROBOT111 at the author's XML."""
    from actspec.diagnostics import EmitError
    from actspec.targets.mujoco import emit as module

    def careless(spec: object, plan: Plan, *rest: object, **named: object) -> None:
        (joint,) = plan.joints
        apply_to_spec(spec, replace(plan, joints=(replace(joint, effort=-5.0),)), *rest, **named)  # type: ignore[arg-type]

    monkeypatch.setattr(module, "apply_to_spec", careless)
    with pytest.raises(
        EmitError, match=r"MJC091 hip: the edited model does not compile: MuJoCo refuses"
    ) as caught:
        compile_text(GROUP, ROBOT, robot="unmanaged: [knee]")
    assert [item.span for item in caught.value.diagnostics] == [None]


def test_a_plan_that_counts_damping_twice_stops_the_compile(monkeypatch: pytest.MonkeyPatch) -> None:
    """A wrong plan is the same in both applications: only reading the file back can tell, and does."""
    from actspec.diagnostics import EmitError
    from actspec.targets.mujoco import emit as module
    from actspec.targets.mujoco.plan import plan_model

    def careless(*given: object) -> object:
        plan, lost = plan_model(*given)  # type: ignore[arg-type]
        (entry,) = plan.replaced
        drive = replace(entry.drive, kd=entry.drive.kd + 0.25)
        return replace(plan, replaced=(replace(entry, drive=drive),)), lost

    monkeypatch.setattr(module, "plan_model", careless)
    with pytest.raises(EmitError, match=r"DMP002 .*hip: damping is 2\.5 "):
        compile_text(GROUP, ROBOT, robot="unmanaged: [knee]")
