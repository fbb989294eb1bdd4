"""The fragment for a robot without a model: classes, actuators, head, and the bench that includes it."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from actspec import api, output
from actspec.diagnostics import Collector, EmitError, Severity
from actspec.ir import ActuatorSet
from actspec.laws import law_of
from actspec.learn.reset import reset
from actspec.resolution import resolve
from actspec.robot.load import listed_robot
from actspec.robot.view import ModelFile
from actspec.spec.document import document_from_text
from actspec.spec.validate import validate
from actspec.targets.base import Emission
from actspec.targets.mujoco.emit import check_written, emit
from tests.compiling import MOTORS, installed, options

mujoco = pytest.importorskip("mujoco")

JOINTS = "[hip, {name: knee, range: [-1 rad, 2 rad]}, {name: foot, kind: slide, range: [0, 10 mm]}, tail]"
LEG = """
  legs:
    joints: [hip, knee]
    level: ideal_pd
    kp: 40
    kd: 1
    effort_limit: 12
    armature: 0.01 kg*m^2
    friction: {coulomb: 0.2 N*m, viscous: 0.03}
    overrides: {knee: {armature: 0.02 kg*m^2}}
  foot:
    joints: [foot]
    level: ideal_pd
    kp: 400
    kd: 3
    effort_limit: 50 N
    friction: {coulomb: 0 N}
"""
PATH = """
  legs:
    joints: [hip]
    level: ideal_pd
    kp: 40
    kd: 1
    effort_limit: 12
    command_filter: {cutoff: 10 Hz}
    delay: 15 ms
"""
MOTOR = """
  legs:
    joints: [hip]
    level: dc_motor
    motor: line
    kp: 40
    kd: 1
"""


@dataclass(frozen=True, slots=True)
class Listed:
    """A spec with `model: none`, compiled."""

    actuators: ActuatorSet
    emission: Emission

    @property
    def bench(self) -> str:
        return self.emission.files[0].data.decode("utf-8")

    @property
    def text(self) -> str:
        return self.emission.files[1].data.decode("utf-8")

    @property
    def body(self) -> str:
        """The fragment without its head."""
        return self.text[self.text.index("\n<mujoco>") + 1 :]

    @property
    def steps(self) -> str:
        """The head's instructions, without their indentation."""
        start = self.text.index("How to use it:")
        return re.sub(r"\n +", "\n", self.text[start : self.text.index("-->", start)])

    def model(self, host: str) -> Any:
        """A model in which the fragment stands where `host` has `FRAGMENT`, compiled here."""
        return mujoco.MjModel.from_xml_string(host.replace("FRAGMENT", inner(self.text)))


def inner(text: str) -> str:
    """What an include puts in its place: the elements below the root."""
    start = text.index("<mujoco>", text.index("\n<mujoco>")) + len("<mujoco>")
    return text[start : text.rindex("</mujoco>")]


def compiled(
    actuators: str = LEG,
    version: str = "3.12",
    *,
    joints: str = JOINTS,
    name: str = "leg",
    timing: str = "{physics_dt: 5 ms}",
    unmanaged: str = "[tail]",
    canonical: bool = False,
) -> Listed:
    """Compile a spec without a model."""
    text = f"actspec: 1\nrobot: {{name: {name}, model: none, joints: {joints}, unmanaged: {unmanaged}}}\n"
    text += f"timing: {timing}\nmotors:{MOTORS}\nactuators:{actuators}"
    spec = validate(document_from_text(text, "leg.yaml"))
    robot = listed_robot(spec)
    resolved = resolve(spec, robot)
    return Listed(resolved, emit(resolved, robot, options(version, canonical=canonical)))


def of_hip(actuators: str, version: str = "3.12", **rest: Any) -> Listed:
    """The same of a robot that has a hip alone."""
    return compiled(actuators, version, joints="[hip]", unmanaged="[]", **rest)


# -- text --------------------------------------------------------------------------------------


def test_one_class_for_each_set_of_numbers() -> None:
    """A stated 0 is written, an unknown number is not, and joints with the same numbers share a class."""
    found = compiled(LEG.replace("[hip, knee]", "[hip, knee, tail]"), unmanaged="[]").body
    assert found[: found.index("  <actuator>")] == (
        "<mujoco>\n"
        '  <option timestep="0.005"/>\n'
        "  <default>\n"
        '    <default class="actspec_leg_legs">\n'
        '      <joint damping="0.03 0 0" armature="0.01" frictionloss="0.2" actuatorfrcrange="-12 12" '
        'actuatorfrclimited="true"/>\n'
        "    </default>\n"
        '    <default class="actspec_leg_legs_2">\n'
        '      <joint damping="0.03 0 0" armature="0.02" frictionloss="0.2" actuatorfrcrange="-12 12" '
        'actuatorfrclimited="true"/>\n'
        "    </default>\n"
        '    <default class="actspec_leg_foot">\n'
        '      <joint frictionloss="0" actuatorfrcrange="-50 50" actuatorfrclimited="true"/>\n'
        "    </default>\n"
        "  </default>\n"
    )


def test_joints_of_two_groups_share_a_class() -> None:
    """The class of equal numbers has the name of the first group."""
    groups = "\n  a: {joints: [hip], level: ideal_pd, kp: 4, kd: 1, effort_limit: 3}"
    groups += groups.replace("  a:", "  b:").replace("hip", "tail")
    found = compiled(groups, joints="[hip, tail]", unmanaged="[]")
    assert re.findall(r'class="(\w+)"', found.body) == ["actspec_leg_a"]
    assert re.findall(r'class="(\w+)"', found.bench) == ["actspec_leg_a"] * 2


def test_hinges_and_slides_share_none() -> None:
    """3 N*m at a hinge and 3 N at a slide are the same figure and two things."""
    group = "\n  a: {{joints: [{}], level: ideal_pd, kp: 4, kd: 1, effort_limit: 3}}"
    text = group.format("hip") + group.format("foot").replace("  a:", "  b:")
    found = compiled(text, joints="[hip, {name: foot, kind: slide}]", unmanaged="[]")
    assert re.findall(r'class="(\w+)"', found.bench) == ["actspec_leg_a", "actspec_leg_b"]


def test_names_of_classes_are_distinct() -> None:
    """A group may be called as the second class of another one would be."""
    text = LEG.replace("  foot:\n", "  legs_2:\n")
    assert re.findall(r'class="(\w+)"', compiled(text).body) == [
        "actspec_leg_legs",
        "actspec_leg_legs_2",
        "actspec_leg_legs_2_2",
    ]


VERSIONS = {
    "3.2": ('damping="0.03"', False, None),
    "3.4": ('damping="0.03"', False, None),
    "3.5": ('damping="0.03"', True, None),
    "3.6": ('damping="0.03"', True, None),
    # K = 24/30 = 0.8, R = 0.8*24/45, R/K = 24/45 = 0.5333; kp 40 -> 21.333, kd 1 -> 0.5333 - 0.8 = -0.2667
    "3.7": ('damping="0.03 0 0"', True, ("position", 21.0 + 1 / 3, -0.8 / 3)),
    "3.11": ('damping="0.03 0 0"', True, ("position", 21.0 + 1 / 3, -0.8 / 3)),
    "3.12": ('damping="0.03 0 0"', True, ("pos", 40.0, 1.0)),
    "3.17": ('damping="0.03 0 0"', True, ("pos", 40.0, 1.0)),
    "4.0": ('damping="0.03 0 0"', True, ("pos", 40.0, 1.0)),
}
"""Joint damping, whether a delay is written, and the dcmotor's input and gains."""


@pytest.mark.slow
@pytest.mark.parametrize("version", VERSIONS)
def test_words_of_each_version(version: str) -> None:
    """Damping, delay and dcmotor are in the words of the version; what it lacks is an approximation."""
    damping, delayed, dcmotor = VERSIONS[version]
    assert f"<joint {damping} armature=" in compiled(version=version).body
    path = of_hip(PATH, version)
    assert ('delay="0.015" nsample="3"' in path.body) is delayed
    assert [loss.field for loss in path.emission.approximations] == ([] if delayed else ["delay"])
    # 1/(2 pi 10 Hz)
    assert f'dynprm="{1 / (20 * np.pi)!r} 0 0 0 0 0 0 0 0 0"' in path.body
    motor = of_hip(MOTOR, version)
    lost = [(loss.field, loss.max_torque_error) for loss in motor.emission.approximations]
    if dcmotor is None:
        assert "<dcmotor" not in motor.body
        # 24 N*m where the motor at w0 has none left: no inertia is in it.
        assert lost == [("torque_speed_curve", 24.0)]
        return
    assert lost == []
    keyword, kp, kd = dcmotor
    found = re.search(r'input="(\w+)" controller="(\S+) 0 (\S+) 0 0 24"', motor.body)
    assert found is not None
    assert found[1] == keyword
    np.testing.assert_allclose([float(found[2]), float(found[3])], [kp, kd], rtol=1e-12)


def test_bench_is_the_listed_joints() -> None:
    """Each listed joint, kind and range, with its class, and the include last; unmanaged ones have no class."""
    text = compiled().bench
    assert [line.strip() for line in text.splitlines() if "<joint" in line or "<include" in line] == [
        '<joint name="hip" type="hinge" class="actspec_leg_legs"/>',
        '<joint name="knee" type="hinge" class="actspec_leg_legs_2" range="-1 2"/>',
        '<joint name="foot" type="slide" class="actspec_leg_foot" range="0 0.01"/>',
        '<joint name="tail" type="hinge"/>',
        '<include file="leg_actuators.xml"/>',
    ]


def test_head_says_what_to_do() -> None:
    """Every step with the names in it."""
    assert compiled().steps == (
        "How to use it:\n"
        '1. Write <include file="leg_actuators.xml"/> as the last element of the model\'s <mujoco>.\n'
        "2. Give each joint its class:\n"
        'class="actspec_leg_legs": hip\n'
        'class="actspec_leg_legs_2": knee\n'
        'class="actspec_leg_foot": foot\n'
        "and remove armature, damping, frictionloss, actuatorfrcrange, springdamper from the joint's own element, "
        "where they\n"
        "would win. Write there what a class or childclass gave the joint before (axis, range, ...).\n"
        "3. Remove other actuators of these joints: the actuators here are named like their joints.\n"
        "4. This file sets option/timestep to 0.005 s (timing.physics_dt); only an <option> behind the\n"
        "include would override it.\n"
    )


def test_head_has_provenance_and_losses() -> None:
    """The numbers with their origin, the hash of the spec, and what is lost."""
    found = of_hip(PATH, "3.4")
    head = found.text[: found.text.index("How to use it:")]
    assert f"spec sha256 {found.actuators.spec_sha256}\n" in head
    assert "  model none (the spec lists the joints)\n" in head
    assert "    kp 40 N*m/rad (authored)\n" in head
    # 0.5 * 12 N*m, less what the filter has not let through: 6 (1 - e^(-2 pi 10 Hz 15 ms)) = 3.66203
    assert (
        "delay: 15 ms -> none; at most 3.66203 N*m (MuJoCo 3.4 has no actuator delay (3.5 and later have)): hip"
        in head
    )


def test_timestep_is_the_models_where_nobody_states_one() -> None:
    """A default step is not written over the model's; the head says what was taken for it, and for the delay."""
    found = of_hip(PATH, timing="{}")
    assert "<option" not in found.body
    assert (
        "4. The spec states no timing.physics_dt: option/timestep stays the model's, taken for 0.002 s here."
    ) in found.steps
    assert (
        "Delays are whole steps of 0.002 s: at another timestep they are not what is stated here."
        in found.steps
    )
    # 15 ms are 7.5 steps of 2 ms
    assert 'delay="0.016" nsample="8"' in found.body


def test_clamped_command_names_its_condition() -> None:
    """`inheritrange` of the including model would override a clamp, so the head names the joints."""
    found = compiled(LEG.replace("kp: 400\n", "kp: 400\n    command_range: [0, 5 mm]\n"))
    assert "must not hold inheritrange, which would override the\ncontrol range of: foot\n" in found.steps
    assert 'ctrllimited="true" ctrlrange="0 0.005"' in found.body
    assert "inheritrange" not in compiled().text


NAMES = {
    "quotes": "a\"b'c",
    "unicode": "хип-ø-关节",
    "markup": "a<b>&c",
    "spaces": "left  hip ",
    "newline": "a\nb",
    "comment": "a--b-->",
}


@pytest.mark.parametrize("name", NAMES.values(), ids=NAMES.keys())
def test_odd_names(name: str, tmp_path: Path) -> None:
    """A joint may be called anything: bench and fragment load, and their heads stay comments."""
    quoted = '"' + name.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n") + '"'
    group = LEG[: LEG.index("    overrides")].replace("[hip, knee]", r"['[\s\S]*']")
    found = compiled(group, installed(), joints=f"[{quoted}]", unmanaged="[]")
    model = written(found, tmp_path)
    assert mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_ACTUATOR, 0) == name
    assert model.dof_damping.tolist() == [0.03]


def test_robots_and_groups_may_be_called_anything() -> None:
    """File and classes have names that XML and every file system take."""
    text = LEG.replace("  legs:", '  "é <& legs-1":').replace("  foot:", '  "é":')
    found = compiled(text, name="2-leg.v1")
    assert [file.path for file in found.emission.files] == [
        "robot_2_leg_v1_bench.xml",
        "robot_2_leg_v1_actuators.xml",
    ]
    assert re.findall(r'class="(.*?)"', found.body) == [
        "actspec_robot_2_leg_v1_legs_1",
        "actspec_robot_2_leg_v1_legs_1_2",
        "actspec_robot_2_leg_v1_group",
    ]


# -- declined ----------------------------------------------------------------------------------

DECLINED = {
    "canonical": (
        {"canonical": True},
        "MJC009 robot.model: `--canonical` writes MuJoCo's own form of a model, and the spec has `model: none`",
    ),
    "unlimited-dcmotor": (
        {"actuators": MOTOR + "    effort_limit: unknown\n", "joints": "[hip]", "unmanaged": "[]"},
        "MJC019 robot.model: a dcmotor without effort_limit takes the force range of the including model's main "
        "default class, which is not known here: hip",
    ),
    "control-character": (
        {"actuators": LEG.replace("hip", "h.p"), "joints": JOINTS.replace("hip", '"h\\x01p"')},
        "MJC024 robot.joints: the fragment cannot be written: XML cannot hold 'h\\x01p'",
    ),
    "unknown-gain": (
        {"actuators": LEG.replace("kp: 40\n", "kp: unknown\n")},
        "MJC001 actuators.legs.kp: hip, knee: kp is unknown, and MuJoCo needs a number: the file has no servo to keep",
    ),
}


@pytest.mark.parametrize(("given", "expected"), DECLINED.values(), ids=DECLINED.keys())
def test_declined(given: dict[str, Any], expected: str) -> None:
    """What no fragment can be is an error with its reason."""
    with pytest.raises(EmitError) as caught:
        compiled(**given)
    assert [
        f"{d.code} {d.where}: {d.message}" for d in caught.value.diagnostics if d.severity is Severity.ERROR
    ] == [expected]


SEEDED = {
    "unit": ('frictionloss="0.2"', 'frictionloss="11.46"', "dof_frictionloss"),
    "twice": ('damping="0.03 0 0"', 'damping="1.03 0 0"', "dof_damping"),
    "class": (
        '<joint name="hip" type="hinge" class="actspec_leg_legs"/>',
        '<joint name="hip"/>',
        "dof_armature",
    ),
    "class-of-another": (
        'hinge" class="actspec_leg_legs"',
        'hinge" class="actspec_leg_foot"',
        "dof_armature",
    ),
    "gain": ('biasprm="0 -40 -1', 'biasprm="0 -40 1', "actuator_biasprm"),
    "joint": ('name="hip" joint="hip"', 'name="hip" joint="tail"', "actuator_trnid"),
    "limit": ('forcerange="-12 12"', 'forcerange="-12 13"', "actuator_forcerange"),
    "joint-limit": ('actuatorfrcrange="-12 12"', 'actuatorfrcrange="-1 1"', "jnt_actfrcrange"),
    "kind": ('type="slide"', 'type="hinge"', "dof_M0"),
    "timestep": ('timestep="0.005"', 'timestep="0.002"', "opt.timestep"),
}
"""What stands in bench or fragment, a slip of the compiler in its place, and a field that tells."""


@pytest.mark.parametrize(("right", "wrong", "field"), SEEDED.values(), ids=SEEDED.keys())
def test_check_catches_a_slip(right: str, wrong: str, field: str) -> None:
    """The bench that includes the fragment must be the plan, in every field: each slip is an error."""
    found = compiled(version=installed())
    names = [file.path for file in found.emission.files]
    files = (
        ModelFile(names[0], "", found.emission.files[0].data),
        ModelFile(names[1], names[1], found.emission.files[1].data),
    )
    planned = mujoco.MjModel.from_xml_string(
        found.bench.replace('<include file="leg_actuators.xml"/>', inner(found.text))
    )
    check_written(files, planned, found.actuators, Collector())
    slipped = tuple(replace(file, data=file.data.replace(right.encode(), wrong.encode())) for file in files)
    assert slipped != files
    with pytest.raises(EmitError) as caught:
        check_written(slipped, planned, found.actuators, Collector())
    (item,) = caught.value.diagnostics
    assert item.code == "MJC091"
    assert field in item.message


# -- compiled ----------------------------------------------------------------------------------

HOST = """<mujoco>
  <compiler autolimits="false" angle="degree"/>
  <option timestep="0.001" integrator="implicitfast"/>
  <default>
    <joint damping="5 1 1" armature="3" frictionloss="4" stiffness="7" actuatorfrcrange="-1 1"
      actuatorfrclimited="true"/>
    <position kp="7" kv="3" timeconst=".2" forcerange="-2 2" forcelimited="true" gear="4" ctrlrange="-1 1"
      ctrllimited="true"/>
  </default>
  <worldbody>
    <body><joint name="tail" axis="0 0 1"/><geom size=".1"/>
      <body><joint name="foot" class="actspec_leg_foot" type="slide" axis="1 0 0"/><geom size=".1"/>
        <body><joint name="knee" class="actspec_leg_legs_2" axis="0 1 0"/><geom size=".1"/>
          <body><joint name="hip" class="actspec_leg_legs" axis="0 1 0"/><geom size=".1"/></body>
        </body>
      </body>
    </body>
  </worldbody>
  FRAGMENT
</mujoco>
"""
"""Another order, and defaults that leak into whatever does not state its number."""


def test_numbers_in_a_strangers_model() -> None:
    """Stated numbers win over the model's main class, unknown ones are the model's, others' joints stay."""
    model = compiled(version=installed()).model(HOST)
    rows = {model.joint(i).name: model.jnt_dofadr[i] for i in range(model.njnt)}
    found = {
        name: (model.dof_damping[dof], model.dof_armature[dof], model.dof_frictionloss[dof])
        for name, dof in rows.items()
    }
    assert found == {
        "tail": (5.0, 3.0, 4.0),
        "foot": (5.0, 3.0, 0.0),
        "knee": (0.03, 0.02, 0.2),
        "hip": (0.03, 0.01, 0.2),
    }
    assert model.dof_dampingpoly[rows["hip"]].tolist() == [0.0, 0.0]
    assert model.jnt_actfrcrange[:, 1].tolist() == [1.0, 50.0, 12.0, 12.0]
    assert model.opt.timestep == 0.005
    assert [model.actuator(i).name for i in range(model.nu)] == ["hip", "knee", "foot"]
    assert model.actuator_ctrllimited.tolist() == [0, 0, 0]
    # The slider of the knee ends 12/40 = 0.3 rad beyond its range.
    assert model.actuator_ctrlrange.tolist() == [[0.0, 0.0], [-1.3, 2.3], [-0.125, 0.135]]


def test_torque_in_a_strangers_model_is_the_law() -> None:
    """Over commands, positions and speeds, each joint's torque is its law's to 1e-9."""
    text = LEG.replace(
        "level: ideal_pd\n    kp: 40\n    kd: 1\n    effort_limit: 12",
        "level: dc_motor\n    motor: line\n    kp: 40\n    kd: 1",
    )
    found = compiled(text, installed())
    model = found.model(HOST)
    data = mujoco.MjData(model)
    rng = np.random.default_rng(5)
    worst = 0.0
    for _ in range(400):
        data.ctrl[:] = rng.uniform(-2, 2, 3)
        data.qpos[:] = rng.uniform(-1, 1, 4)
        data.qvel[:] = rng.uniform(-70, 70, 4)
        mujoco.mj_forward(model, data)
        for index, joint in enumerate(found.actuators.joints):
            at = int(model.joint(joint.joint).qposadr[0])
            dof = int(model.joint(joint.joint).dofadr[0])
            expected = law_of(joint).torque(data.ctrl[index], data.qpos[at], data.qvel[dof])
            worst = max(worst, abs(float(data.qfrc_actuator[dof]) - float(expected)))
    assert worst <= 1e-9


def written(found: Listed, folder: Path) -> Any:
    """The bench, loaded from where both files were written."""
    for file in found.emission.files:
        (folder / file.path).write_bytes(file.data)
    return mujoco.MjModel.from_xml_path(str(folder / found.emission.files[0].path))


def test_reset_recipe(tmp_path: Path) -> None:
    """By hand as the head says it, or with the runtime, filter and delay start where the joint is."""
    found = of_hip(PATH, installed())
    assert found.steps.endswith(
        "5. A bare reset starts filters and delay lines at 0, and the robot jumps. Reset with\n"
        "actspec.runtime.reset(model, data, keyframe)\n"
        "or by hand, with i the actuator's index and u the position of its joint (0 for a velocity or a torque):\n"
        "data.ctrl[i] = u\n"
        "data.act[model.actuator_actadr[i]] = u    at hip\n"
        "mujoco.mj_initCtrlHistory(model, data, i, None, numpy.full(3, u))    at hip\n"
    )
    model = written(found, tmp_path)
    model.qpos0[0] = 0.3
    by_hand, by_runtime, bare = (mujoco.MjData(model) for _ in range(3))
    mujoco.mj_resetData(model, by_hand)
    by_hand.ctrl[0] = 0.3
    by_hand.act[model.actuator_actadr[0]] = 0.3
    mujoco.mj_initCtrlHistory(model, by_hand, 0, None, np.full(3, 0.3))
    reset(model, by_runtime)
    mujoco.mj_resetData(model, bare)
    bare.ctrl[0] = 0.3
    forces: list[list[float]] = []
    for data in (by_hand, by_runtime, bare):
        mujoco.mj_step(model, data)
        forces.append([float(data.actuator_force[0])])
    # 40 N*m/rad x 0.3 rad: the bare reset pulls to 0.
    assert forces == [[0.0], [0.0], [-12.0]]


def test_a_robot_in_another_folder_includes_it(tmp_path: Path) -> None:
    """The include is a path from the model, and a second fragment fits into the same scene."""
    spec = "actspec: 1\nrobot: {{name: {0}, model: none, joints: [{0}_hip]}}\n"
    spec += "actuators: {{legs: {{joints: ['.*'], level: ideal_pd, kp: 4, kd: 1, effort_limit: {1}}}}}\n"
    for name, limit in (("cat", 3), ("dog", 5)):
        path = tmp_path / f"{name}.yaml"
        path.write_text(spec.format(name, limit))
        result = api.compile(path, targets=[f"mujoco=={installed()}"], output=str(tmp_path / name))
        output.write(output.outputs(result))
        (info,) = [item for item in result.diagnostics if item.code == "MJC023"]
        assert info.message == (
            f"the spec has `model: none`: {name}_actuators.xml is no model but a fragment to include in one; "
            "its head says how"
        )
    bodies = "".join(
        f'<body><joint name="{name}_hip" class="actspec_{name}_legs"/><geom size=".1"/></body>'
        for name in ("cat", "dog")
    )
    includes = "".join(f'<include file="../{name}/mujoco/{name}_actuators.xml"/>' for name in ("cat", "dog"))
    scene = tmp_path / "scenes" / "both.xml"
    scene.parent.mkdir()
    scene.write_text(f"<mujoco><worldbody>{bodies}</worldbody>{includes}</mujoco>")
    model = mujoco.MjModel.from_xml_path(str(scene))
    assert model.jnt_actfrcrange[:, 1].tolist() == [3.0, 5.0]
    assert model.actuator_forcerange[:, 1].tolist() == [3.0, 5.0]


def test_every_target_but_urdf_takes_a_robot_without_a_model(tmp_path: Path) -> None:
    """One spec with `model: none` compiles to all that need no model; Newton needs to be told the prims."""
    text = f"""actspec: 1
robot: {{name: leg, model: none, joints: {JOINTS}, unmanaged: [tail]}}
timing: {{physics_dt: 5 ms, decimation: 4}}
actuators:{LEG}    armature: 0.1 kg
    randomize: {{kp: {{scale: [0.8, 1.2]}}}}
targets:
  mujoco: {{version: "{installed()}"}}
  isaaclab: {{version: "2.3"}}
  mjlab: {{version: "1.6"}}
  deploy: {{joint_order: [foot, knee, null, hip]}}
  randomization: {{for: [isaaclab, mjlab, playground, json]}}
  newton: {{version: "1.8", joint_paths: {{".*": "joints/{{joint}}"}}}}
"""
    path = tmp_path / "leg.yaml"
    path.write_text(text)
    result = api.compile(path, output=str(tmp_path))
    assert [
        (options.name, len(emission.files))
        for options, emission in zip(result.targets, result.emissions, strict=True)
    ] == [
        ("mujoco", 2),
        ("isaaclab", 1),
        ("mjlab", 1),
        ("deploy", 1),
        ("randomization", 4),
        ("newton", 1),
    ]
    for kind, message in (
        ("urdf", r"URD001 robot.model: the URDF target edits a URDF, and the spec's model is none"),
        ("newton", r"NWT009 targets.newton.joint_paths: the spec names no model"),
    ):
        path.write_text(text[: text.index("targets:")])
        with pytest.raises(EmitError, match=message):
            api.compile(path, targets=[kind], output=os.fspath(tmp_path))
