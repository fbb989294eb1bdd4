"""The fragment of a robot without a model, in a stranger's model, in every MuJoCo release against the laws.

The including model's main default class holds what would leak into whatever the fragment does not write.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from actspec.ir import ActuatorSet
from actspec.laws import law_of
from actspec.resolution import resolve
from actspec.robot.load import listed_robot
from actspec.spec.document import document_from_text
from actspec.spec.validate import validate
from actspec.targets.mujoco.emit import emit
from tests.agree.engines import Engine, grid, time
from tests.agree.test_mujoco_target import (
    EXACT,
    GRIDS,
    HELD,
    HINGE,
    MAIN_DEFAULTS,
    SLIDE,
    STEPS,
    UNDER_DEFAULTS,
    effective,
    groups,
    held_by,
    leaks,
    states,
    step_commands,
)
from tests.compiling import MOTORS, options

HOST = """<mujoco>
  <option timestep="0.001"/>
  <default>
    <joint damping="1.5" armature=".2" frictionloss=".7" actuatorfrcrange="-1 1"/>
    {default}
  </default>
  <worldbody>
    <body>
      <joint name="slide" type="slide" axis="0 0 1"{slide_class}/><geom size=".1"/>
    </body>
    <body pos="2 0 0">
      <joint name="hinge" axis="0 0 1" class="actspec_probe_h"/><geom size=".1"/>
    </body>
  </worldbody>
  <include file="{fragment}"/>
</mujoco>
"""
"""The joints in another order than the spec's, another timestep, and defaults that are all wrong."""


def hosted(folder: Path, hinge: str, slide: str, version: str, default: str = "") -> tuple[Path, ActuatorSet]:
    """The including model's file, with the fragment beside it, and what the spec means."""
    robot = "name: probe, model: none, joints: [hinge, {name: slide, kind: slide}]"
    if not slide:
        robot += ", unmanaged: [slide]"
    text = f"actspec: 1\nrobot: {{{robot}}}\ntiming: {{physics_dt: 5 ms}}\n"
    spec = validate(document_from_text(f"{text}motors:{MOTORS}\nactuators:\n{groups(hinge, slide)}\n"))
    view = listed_robot(spec)
    resolved = resolve(spec, view)
    _, fragment = emit(resolved, view, options(version)).files
    folder.mkdir()
    (folder / fragment.path).write_bytes(fragment.data)
    slide_class = ' class="actspec_probe_s"' if slide else ""
    host = folder / "host.xml"
    host.write_text(HOST.format(default=default, slide_class=slide_class, fragment=fragment.path))
    return host, resolved


def release(engine: Engine) -> str:
    """Its version as a spec writes it."""
    return ".".join(engine.version.split(".")[:2])


def test_fragment_is_the_law(engine: Engine, tmp_path: Path) -> None:
    """Every drive that a release holds gives its law's torque, and the joints have the spec's passive numbers."""
    names = [name for name in GRIDS if held_by(name, engine.number)]
    jobs, laws = [], []
    for name in names:
        host, resolved = hosted(tmp_path / name, *GRIDS[name], release(engine))
        own = tuple(law_of(joint) for joint in resolved.joints)
        q, qd, ctrl = (np.stack(columns, axis=1) for columns in zip(*map(states, own), strict=True))
        jobs.append(grid(host, joints=[HINGE, SLIDE], q=q, qd=qd, ctrl=ctrl))
        laws.append(own)
    for name, job, own, answer in zip(names, jobs, laws, engine.run(jobs), strict=True):
        for column, law in enumerate(own):
            command = job.inputs["ctrl"][:, column]
            if law.command_range is not None:
                command = np.clip(command, *law.command_range)
            expected = law.torque(command, job.inputs["q"][:, column], job.inputs["qd"][:, column])
            np.testing.assert_allclose(answer.torque[:, column], expected, rtol=0, atol=EXACT, err_msg=name)
        for joint in (HINGE, SLIDE):
            passive = [
                answer.joint(joint, f"dof_{field}") for field in ("damping", "armature", "frictionloss")
            ]
            assert passive == [0.043, 0.037, 0.31]
        assert answer.info["actuators"] == [HINGE, SLIDE]
        assert answer.info["timestep"] == 0.005


def test_nothing_leaks_from_the_main_class(engine: Engine, tmp_path: Path) -> None:
    """Whatever actuator the including model's main class holds, the drives are the law, over states and steps."""
    jobs, laws = [], []
    for default, name in leaks(engine):
        if not held_by(name, engine.number):
            continue
        folder = tmp_path / f"{default}-{name}"
        host, resolved = hosted(folder, UNDER_DEFAULTS[name], "", release(engine), MAIN_DEFAULTS[default])
        law = law_of(resolved.joints[0])
        q, qd, ctrl = (column[::2, None] for column in states(law))
        jobs.append(grid(host, joints=[HINGE], q=q, qd=qd, ctrl=ctrl))
        commands = step_commands(law)
        jobs.append(time(host, joints=[HINGE], ctrl=commands[:, None], q=[HELD], start=[commands[0]]))
        laws.append(law)
    said = engine.run(jobs)
    for index, law in enumerate(laws):
        over, steps = jobs[2 * index].inputs, jobs[2 * index + 1].inputs
        expected = law.torque(over["ctrl"], over["q"], over["qd"])
        np.testing.assert_allclose(said[2 * index].torque, expected, rtol=0, atol=EXACT)
        expected = law.torque(effective(law, steps["ctrl"][:, 0], 0.005), HELD, 0.0)
        np.testing.assert_allclose(said[2 * index + 1].torque[:, 0], expected, rtol=0, atol=EXACT)


def test_fragment_holds_delay_and_filter(engine: Engine, tmp_path: Path) -> None:
    """Step by step after the reset recipe, delayed and filtered drives are the law from 3.5 on."""
    names = [name for name in STEPS if name != "pd-rounded" and not name.startswith("dc")]
    if engine.number < (3, 5):
        for name in names:
            _, resolved = hosted(tmp_path / name, STEPS[name], "", release(engine))
            text = (tmp_path / name / "probe_actuators.xml").read_text()
            assert "delay: 15 ms -> none" in text
            assert 'delay="' not in text
        return
    jobs, expected = [], []
    for name in names:
        host, resolved = hosted(tmp_path / name, STEPS[name], "", release(engine))
        law = law_of(resolved.joints[0])
        commands = step_commands(law)
        jobs.append(time(host, joints=[HINGE], ctrl=commands[:, None], q=[HELD], start=[commands[0]]))
        expected.append(law.torque(effective(law, commands, 0.005), HELD, 0.0))
    for answer, torque in zip(engine.run(jobs), expected, strict=True):
        np.testing.assert_allclose(answer.torque[:, 0], torque, rtol=0, atol=EXACT)
