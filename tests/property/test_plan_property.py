"""Random specs on random robots: the edited text is the edited MjSpec, and does what the spec says.

`emit` itself refuses a text that is another model than its MjSpec (MJC091) and an edit that reaches
beyond its plan (MJC090); here it has no reason to. The written file is then stepped against the laws.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from actspec.ir import Command
from actspec.laws import law_of
from tests.compiling import Compiled, compile_text
from tests.fitting import drawn_numbers

INSTALLED = tuple(int(part) for part in mujoco.__version__.split(".")[:2])
VERSION = f"{INSTALLED[0]}.{INSTALLED[1]}"

EXACT = 1e-9
"""N*m and N, of the drive."""
PASSIVE = 1e-9
"""Relative: linear, quadratic and cubic terms are added in another order."""


@dataclass(frozen=True, slots=True)
class Robot:
    """A random robot.

    Attributes:
        text: Its MJCF.
        includes: Included texts by name.
        joints: Name to `hinge` or `slide`.
    """

    text: str
    includes: dict[str, str]
    joints: dict[str, str]


def maybe(strategy: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    return st.none() | strategy


def attribute(name: str, value: object) -> str:
    return "" if value is None else f' {name}="{value}"'


NUMBERS = st.sampled_from(["0", ".01", "0.3", "1", "2.5", "1e1", "33.333333333333336"])
POSITIVE = st.sampled_from([".02", "0.3", "1", "2.5", "7", "1e1"])
GEARS = st.sampled_from(["1", "2", "-1", "3 0 0 0 0 0", ".5"])
SYMMETRIC = st.sampled_from(["-1 1", "-2.5 2.5", "-.1 40", "-100 100"])


@st.composite
def joint_attributes(draw: st.DrawFn) -> str:
    """Passive values of a joint, or of a class; each is stated or not."""
    text = attribute("damping", draw(maybe(st.sampled_from(["0", ".4", "2", ".5 .1", ".5 0 .02", ".3 0"]))))
    text += attribute("armature", draw(maybe(NUMBERS)))
    text += attribute("frictionloss", draw(maybe(NUMBERS)))
    text += attribute("stiffness", draw(maybe(st.sampled_from(["0", "3"]))))
    text += attribute("actuatorfrcrange", draw(maybe(SYMMETRIC)))
    return text


@st.composite
def actuator_attributes(draw: st.DrawFn, tag: str, *, main: bool = False) -> str:
    """Attributes of an actuator or of a class's."""
    text = ""
    if tag == "position":
        text += attribute("kp", draw(POSITIVE)) + attribute("kv", draw(maybe(NUMBERS)))
        text += attribute("timeconst", draw(maybe(st.sampled_from([".01", ".1"]))))
    elif tag in ("velocity", "intvelocity", "damper"):
        text += attribute("kv", draw(POSITIVE))
        text += attribute("kp", draw(POSITIVE)) if tag == "intvelocity" else ""
        text += ' actrange="-1 1"' if tag == "intvelocity" else ""
    elif tag == "pid":
        text += attribute("kp", draw(POSITIVE)) + attribute("ki", draw(POSITIVE))
        text += attribute("input", draw(maybe(st.sampled_from(["pos", "pos vel"]))))
    elif tag == "dcmotor":
        text += ' nominal="24 30 20"'
    elif tag == "general":
        kp, kd = draw(POSITIVE), draw(NUMBERS)
        text += f' gainprm="{kp}" biastype="affine" biasprm="0 -{kp} -{kd}"'
        text += attribute("dyntype", draw(maybe(st.sampled_from(["none", "filter", "filterexact"]))))
        text += attribute("dynprm", draw(maybe(POSITIVE)))
    text += attribute("gear", draw(maybe(GEARS)))
    if tag != "dcmotor":
        text += attribute("forcerange", draw(maybe(SYMMETRIC)))
    control = "0 3" if tag == "damper" else draw(maybe(SYMMETRIC))
    text += attribute("ctrlrange", control if tag != "pid" else None)
    text += attribute("group", draw(maybe(st.integers(0, 3))))
    if not main:
        text += attribute("user", draw(maybe(st.sampled_from(["1", "1 2.5"]))))
        if tag != "pid" and draw(st.booleans()):
            text += ' delay=".004" nsample="2"'
    # A dcmotor corrects its constant for a damping of its own, which is another thing.
    if tag != "dcmotor":
        text += attribute("damping", draw(maybe(st.sampled_from(["0", ".2", ".2 .1"]))))
    text += attribute("armature", draw(maybe(NUMBERS)))
    return text


TAGS = ["position", "position", "motor", "velocity", "general", "dcmotor", "intvelocity", "damper"]
TAGS += ["pid"] if INSTALLED >= (3, 12) else []


@st.composite
def robots(draw: st.DrawFn) -> Robot:
    """A tree of one to six hinges and slides with classes, actuators, sensors, keyframes and an include."""
    count = draw(st.integers(1, 6))
    degrees = draw(st.booleans())
    names = [f"j{i}" for i in range(count)]
    kinds = [draw(st.sampled_from(["hinge", "hinge", "slide"])) for _ in names]

    class_tag = draw(st.sampled_from(["position", "general", "motor"]))
    main_tag = draw(maybe(st.sampled_from(["position", "general", "motor"])))
    default = "<default>"
    default += f"<joint{draw(joint_attributes())}/>" if draw(st.booleans()) else ""
    default += f"<{main_tag}{draw(actuator_attributes(main_tag, main=True))}/>" if main_tag else ""
    default += f'<default class="c"><joint{draw(joint_attributes())}/>'
    default += f"<{class_tag}{draw(actuator_attributes(class_tag, main=True))}/></default></default>"

    # Parents before children; the bodies are written from the last to the first.
    parents = [draw(st.integers(-1, i - 1)) for i in range(count)]
    bodies = [""] * count
    for i in reversed(range(count)):
        ends = "-60 90" if degrees and kinds[i] == "hinge" else "-1 1.5"
        joint = f'<joint name="{names[i]}"' + (' type="slide"' if kinds[i] == "slide" else "")
        joint += ' axis="0 1 0"' if i % 2 else ' axis="1 0 0"'
        joint += attribute("class", draw(maybe(st.just("c"))))
        joint += attribute("range", ends) if draw(st.booleans()) else ""
        joint += draw(joint_attributes())
        joint += ' springdamper=".1 1"' if draw(st.integers(0, 5)) == 0 else ""
        inner = joint + f'/><geom size=".1" mass="{i + 1}"/>'
        inner += f'<site name="site{i}"/>' + "".join(
            bodies[child] for child in range(i + 1, count) if parents[child] == i
        )
        # `joint` must come before anything else of its body, but may stand in a frame.
        bodies[i] = f'<body pos=".3 0 0"><!-- b{i} -->{inner}</body>'
        if draw(st.integers(0, 4)) == 0:
            bodies[i] = f'<frame pos="0 .1 0">{bodies[i]}</frame>'
    world = "".join(bodies[i] for i in range(count) if parents[i] == -1)

    actuators: list[str] = []
    named: list[str] = []
    for name in names:
        for copy in range(draw(st.sampled_from([0, 1, 1, 1, 2]))):
            tag = draw(st.sampled_from(TAGS))
            label = draw(st.sampled_from([f"{name}_drive{copy}", f"{name}_drive{copy}", None]))
            if label:
                named.append(label)
            place = draw(st.sampled_from(["joint", "joint", "joint", "jointinparent"]))
            text = f"<{tag}" + attribute("name", label) + f' {place}="{name}"'
            # One default of an actuator exists in a class: another kind of shortcut would mix with it.
            same = tag == class_tag and draw(st.booleans())
            text += ' class="c"' if same else ""
            actuators.append(text + draw(actuator_attributes(tag)) + "/>")
    tendon = ""
    if draw(st.booleans()):
        tendon = f'<tendon><fixed name="t"><joint joint="{names[0]}" coef="2"/></fixed></tendon>'
        spare = [
            '<motor name="pull" tendon="t" gear="2"/>',
            '<motor name="push" site="site0" armature="0" damping="0 0 0"/>',
        ]
        for text in spare:
            actuators.insert(draw(st.integers(0, len(actuators))), text)
        named += ["pull", "push"]
    order = draw(st.permutations(actuators))
    section = "<actuator>\n  " + "\n  ".join(order) + "\n</actuator>" if order else ""

    sensor = "".join(
        f'<{draw(st.sampled_from(["actuatorfrc", "actuatorpos", "actuatorvel"]))} actuator="{label}"/>'
        for label in named
        if draw(st.booleans())
    )
    # With a pid among them the number of controls is MuJoCo's business.
    single = not any(text.startswith("<pid") for text in order)
    keys = ""
    for _ in range(draw(st.integers(0, 2))):
        keys += "<key" + attribute("qpos", " ".join(draw(POSITIVE) for _ in names))
        if single and order and draw(st.booleans()):
            keys += attribute("ctrl", " ".join(draw(POSITIVE) for _ in order))
        keys += "/>"
    included = bool(order) and draw(st.booleans())
    option = draw(st.sampled_from(["", '<option timestep=".002"/>', '<option integrator="implicitfast"/>']))
    text = f"""<mujoco model="random">
  <compiler angle="{"degree" if degrees else "radian"}"/>
  {option}
  {default}
  <worldbody>{world}</worldbody>
  {tendon}
  {'<include file="drives.xml"/>' if included else section}
  <sensor>{sensor}</sensor>
  <keyframe>{keys}</keyframe>
</mujoco>
"""
    includes = {"drives.xml": f"<mujocoinclude>{section}</mujocoinclude>\n"} if included else {}
    return Robot(text, includes, dict(zip(names, kinds, strict=True)))


@st.composite
def groups(draw: st.DrawFn, robot: Robot) -> tuple[str, list[str]]:
    """A group for some of the joints, one a joint, and the names of the others."""
    text, unmanaged = "", []
    for name, kind in robot.joints.items():
        if (text or name != list(robot.joints)[-1]) and draw(st.integers(0, 3)) == 0:
            unmanaged.append(name)
            continue
        level = draw(st.sampled_from(["ideal_pd", "ideal_pd", "dc_motor"]))
        command = draw(st.sampled_from(["position", "position", "position", "velocity", "effort"]))
        fields = [f"joints: [{name}]", f"level: {level}", f"command: {command}"]
        if level == "dc_motor":
            fields.append(f"motor: {'line' if kind == 'hinge' else 'line_s'}")
        if command == "position":
            fields.append(f"kp: {draw(st.sampled_from([3, 25.5, 400]))}")
        if command != "effort":
            fields.append(f"kd: {draw(st.sampled_from([0.25, 2, 40]))}")
        fields.append(f"effort_limit: {draw(st.sampled_from([4, 24.5, 180]))}")
        if draw(st.booleans()):
            fields.append(f"armature: {draw(st.sampled_from([0, 0.013, 0.5]))}")
        friction = [
            f"{part}: {draw(st.sampled_from([0, 0.07, 1.9]))}"
            for part in ("coulomb", "viscous")
            if draw(st.booleans())
        ]
        if friction:
            fields.append(f"friction: {{{', '.join(friction)}}}")
        if draw(st.booleans()):
            fields.append(f"command_filter: {draw(st.sampled_from(['none', '{cutoff: 20 Hz}']))}")
        if draw(st.booleans()):
            fields.append(f"delay: {draw(st.sampled_from(['0 s', '4 ms', '10 ms']))}")
        if command == "position" and draw(st.integers(0, 3)) == 0:
            fields.append(f"encoder_bias: 0.05 {'rad' if kind == 'hinge' else 'm'}")
        text += f"  g_{name}:\n" + "".join(f"    {field}\n" for field in fields)
    return text, unmanaged


@pytest.mark.slow
@settings(
    max_examples=50,
    derandomize=True,
    deadline=None,
    database=None,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
@given(st.data())
def test_random_spec_on_random_robot(data: st.DataObject) -> None:
    """Text and MjSpec agree, nothing else moves, and the written drives and joints are the spec's."""
    robot = data.draw(robots(), label="robot")
    text, unmanaged = data.draw(groups(robot), label="groups")
    timing = data.draw(st.sampled_from(["{}", "{physics_dt: 2 ms}", "{physics_dt: 5 ms}"]), label="timing")
    compiled = compile_text(
        text,
        robot.text,
        VERSION,
        robot=f"unmanaged: [{', '.join(unmanaged)}]",
        timing=f"{timing}\naccept: {json.dumps(drawn_numbers())}",
        includes=robot.includes,
    )
    before, after = compiled_pair(robot, compiled)
    check_drives(compiled, after)
    check_joints(compiled, before, after)
    check_kept(compiled, before, after, set(unmanaged))


def compiled_pair(robot: Robot, compiled: Compiled) -> tuple[Any, Any]:
    """The model before and after, by the engine's own reader; a file not written stays where it was."""
    before = mujoco.MjModel.from_xml_string(robot.text, {k: v.encode() for k, v in robot.includes.items()})
    files = {**robot.includes, **compiled.files}
    main = files.pop("robot.xml").replace("../drives.xml", "drives.xml")
    return before, mujoco.MjModel.from_xml_string(main, {k: v.encode() for k, v in files.items()})


def dof(model: Any, name: str) -> int:
    return int(model.jnt_dofadr[model.joint(name).id])


def check_drives(compiled: Compiled, model: Any) -> None:
    """The one actuator of each managed joint gives the law's torque at 20 random states."""
    rng = np.random.default_rng(5)
    lost = {(loss.joint, loss.field) for loss in compiled.emission.approximations}
    data = mujoco.MjData(model)
    for actuator in compiled.actuators.joints:
        joint = model.joint(actuator.joint)
        driving = [
            i
            for i in range(len(model.actuator_trntype))
            if model.actuator_trntype[i] == int(mujoco.mjtTrn.mjTRN_JOINT)
            and model.actuator_trnid[i, 0] == joint.id
        ]
        assert len(driving) == 1
        index = driving[0]
        law = law_of(actuator)
        if (actuator.joint, "torque_speed_curve") in lost or (actuator.joint, "encoder_bias") in lost:
            continue
        for _ in range(20):
            mujoco.mj_resetData(model, data)
            q, w = rng.uniform(-1, 1), rng.uniform(-60, 60)
            u = rng.uniform(-1, 1) * (3 if actuator.command is Command.POSITION else 60)
            data.qpos[joint.qposadr[0]], data.qvel[joint.dofadr[0]] = q, w
            address = int(getattr(model, "actuator_ctrladr", np.arange(model.nu))[index])
            data.ctrl[address] = u
            if model.actuator_actnum[index]:
                data.act[model.actuator_actadr[index]] = u
            samples = int(model.actuator_history[index, 0])
            if samples:
                mujoco.mj_initCtrlHistory(model, data, index, None, np.full(samples, u))
            mujoco.mj_forward(model, data)
            expected = float(law.torque(u, q, w))
            found = float(data.actuator_force[index]) * float(model.actuator_gear[index, 0])
            assert abs(found - expected) <= EXACT
            assert abs(float(data.qfrc_actuator[joint.dofadr[0]]) - expected) <= EXACT
        delay = actuator.delay.nominal.value if actuator.delay is not None else None
        step = model.opt.timestep
        assert model.actuator_history[index, 0] == math.floor((delay or 0.0) / step + 0.5 + 1e-9)
        cutoff = actuator.filter_cutoff.value if actuator.filter_cutoff is not None else None
        filtered = cutoff is not None and (actuator.joint, "command_filter") not in lost
        assert bool(model.actuator_actnum[index]) == filtered
        if filtered and cutoff is not None:
            assert math.isclose(model.actuator_dynprm[index, 0], 1 / (2 * math.pi * cutoff), rel_tol=1e-15)


def check_joints(compiled: Compiled, before: Any, after: Any) -> None:
    """Passive forces, friction and armature are the spec's where it states them, else as they were."""
    old, new = mujoco.MjData(before), mujoco.MjData(after)
    managed = set(managed_in_order(compiled))
    # A springdamper that stays in force follows the inertia, which the armature of other joints changes.
    steady = [dof(before, j.name) for j in compiled.robot.joints if j.name in managed or not j.springdamper]
    for speed in (-7.0, 0.4, 3.0):
        for model, data in ((before, old), (after, new)):
            mujoco.mj_resetData(model, data)
            data.qpos[:], data.qvel[:] = 0.3, speed
            mujoco.mj_forward(model, data)
        expected = old.qfrc_passive.copy()
        for actuator in compiled.actuators.joints:
            joint = compiled.robot.joint(actuator.joint)
            assert joint is not None
            own = [a for a in compiled.robot.actuators if a.target == joint.name]
            linear = joint.damping + sum(a.gear**2 * a.damping[0] for a in own)
            viscous = actuator.friction_viscous.require()
            expected[dof(before, joint.name)] += (linear - viscous) * speed
        found = new.qfrc_passive[steady]
        np.testing.assert_allclose(found, expected[steady], rtol=PASSIVE, atol=PASSIVE)
    for actuator in compiled.actuators.joints:
        at = dof(after, actuator.joint)
        assert after.dof_frictionloss[at] == actuator.friction_coulomb.require()
        assert math.isclose(after.dof_armature[at], actuator.armature.require(), rel_tol=1e-15)


def check_kept(compiled: Compiled, before: Any, after: Any, unmanaged: set[str]) -> None:
    """Rows of unmanaged joints and of their actuators are as they were; so are names and their order."""
    for name in unmanaged:
        for field in ("dof_damping", "dof_armature", "dof_frictionloss"):
            at = dof(before, name)
            joint = compiled.robot.joint(name)
            assert joint is not None
            if not joint.springdamper:
                np.testing.assert_array_equal(getattr(before, field)[at], getattr(after, field)[at])
    managed = {actuator.joint for actuator in compiled.actuators.joints}
    names: list[str] = []
    seen: set[str] = set()
    for view in compiled.robot.actuators:
        on_managed = view.transmission in ("joint", "jointinparent") and view.target in managed
        if on_managed and view.target in seen:
            continue
        if on_managed:
            seen.add(view.target)
            own = [a for a in compiled.robot.actuators if a.target == view.target]
            names.append(next((a.name for a in own if a.name), ""))
        else:
            names.append(view.name)
    names += [joint for joint in managed_in_order(compiled) if joint not in seen]
    found = [
        mujoco.mj_id2name(after, mujoco.mjtObj.mjOBJ_ACTUATOR, i) or ""
        for i in range(len(after.actuator_trntype))
    ]
    assert found == names
    for view in compiled.robot.actuators:
        if view.transmission in ("joint", "jointinparent") and view.target in managed:
            continue
        new = names.index(view.name) if view.name else None
        if new is None:
            continue
        for field in ("gainprm", "biasprm", "gear", "forcerange", "delay", "group", "damping", "armature"):
            rows = [getattr(model, f"actuator_{field}") for model in (before, after)]
            np.testing.assert_array_equal(rows[0][view.index], rows[1][new])


def managed_in_order(compiled: Compiled) -> list[str]:
    return [actuator.joint for actuator in compiled.actuators.joints]
