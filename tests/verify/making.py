"""A spec with every kind of number, compiled once, and verified after somebody edits a file of it."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from actspec import api
from actspec.verify.agreement import Agreement, TargetFiles
from actspec.verify.run import lay_out, verify

MODEL = """<mujoco model="rich">
  <option timestep="0.002" integrator="implicitfast"/>
  <worldbody>
    <body name="a"><joint name="left_hip" range="-60 60" damping="0.3"/><geom size="0.1"/>
      <body name="b" pos="0.02 0 0"><joint name="left_knee" range="-120 5" armature="0.02"/><geom size="0.1"/></body>
    </body>
    <body name="c" pos="0 2 0"><joint name="right_hip" range="-60 60"/><geom size="0.1"/>
      <body name="d" pos="0.02 0 0"><joint name="right_knee" range="-120 5"/><geom size="0.1"/>
        <body name="e" pos="0.02 0 0"><joint name="lift" type="slide" axis="1 0 0" range="-0.1 0.3"/>
          <geom size="0.1"/></body>
      </body>
    </body>
    <body name="f" pos="0 5 0"><joint name="gripper" range="-60 60"/><geom size="0.1"/></body>
  </worldbody>
  <actuator><motor name="own" joint="left_hip"/><motor name="kept" joint="gripper"/></actuator>
</mujoco>
"""
"""Hips, knees, a slide, and a joint that the spec leaves alone; on short arms, so that they answer soon."""

SPEC = """actspec: 1
robot:
  name: rich
  model: rich.xml
  unmanaged: [gripper]
  default_pose: {".*_knee": -0.8 rad, left_hip: 0.1 rad, right_hip: -0.1 rad}
timing: {physics_dt: 5 ms, decimation: 4}
motors:
  drive:
    side: motor
    gear_ratio: 9
    stall_torque: 4 N*m
    no_load_speed: 270 rad/s
    peak_torque: 2.5 N*m
    rotor_inertia: 0.0001 kg*m^2
actuators:
  hips:
    joints: [".*_hip"]
    motor: drive
    level: dc_motor
    kp: 40
    kd: 1.5
    delay: 10 ms
    friction: {coulomb: 0.3, viscous: 0.05}
    velocity_limit: 25 rad/s
    action_scale: 0.3
    randomize:
      kp: {scale: [0.8, 1.2], when: reset, per: joint}
      armature: {scale: [0.9, 1.1], when: startup, per: joint}
  knees:
    joints: [".*_knee"]
    motor: drive
    reduction: 1.5
    level: ideal_pd
    kp: 60
    kd: 2
    encoder_bias: 0.02 rad
    delay: {nominal: 10 ms, range: [5 ms, 15 ms], sampling: episode}
    command_filter: {cutoff: 20 Hz}
    command_range: [-1.9 rad, 0 rad]
    friction: {coulomb: 0.2, viscous: 0.04}
    overrides: {right_knee: {kp: 61}}
  lift:
    joints: [lift]
    level: ideal_pd
    command: velocity
    kd: 300
    effort_limit: 150 N
    armature: 0.3 kg
    friction: {coulomb: 3 N, viscous: 5 N*s/m}
targets:
  mujoco: {version: "3.12"}
  isaaclab: {version: "2.3", isaac_sim: "5.1"}
  custom: {target: isaaclab, version: "2.3", class: custom}
  implicit: {target: isaaclab, version: "2.3", class: implicit}
  il45: {target: isaaclab, version: "2.2", isaac_sim: "4.5"}
  il3: {target: isaaclab, version: "3.0"}
  mjlab: {version: "1.6"}
  deploy: {}
  randomization: {for: [isaaclab, mjlab, json]}
"""
"""Hips at the joint: L 2.5 x 9 = 22.5, stall 4 x 9 = 36 N*m, no load 270 / 9 = 30 rad/s, armature 1e-4 x 81 = 0.0081.
Knees: L 2.5 x 9 x 1.5 = 33.75 N*m, armature 1e-4 x 81 x 2.25 = 0.018225 kg*m^2."""

URDF = """<robot name="leg">
  <link name="base"/>
  <link name="thigh"><inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="shank"><inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="hip" type="revolute"><parent link="base"/><child link="thigh"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="knee" type="revolute"><parent link="thigh"/><child link="shank"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>
"""

URDF_SPEC = """actspec: 1
robot: {name: leg, model: leg.urdf}
timing: {physics_dt: 5 ms}
motors:
  drive: {side: motor, gear_ratio: 9, peak_torque: 2.5 N*m, rotor_inertia: 0.0001 kg*m^2}
actuators:
  leg:
    joints: [hip, knee]
    motor: drive
    level: ideal_pd
    kp: 40
    kd: 1.5
    velocity_limit: 25 rad/s
    friction: {coulomb: 0.3, viscous: 0.05}
targets: {urdf: {}}
"""

Edit = Callable[[str], str]


def replaced(old: str, new: str, count: int = 1) -> Edit:
    """Replace a text that is there, the first time or `count` times (0: everywhere)."""

    def edit(text: str) -> str:
        assert old in text, old
        return text.replace(old, new, count or -1)

    return edit


def matched(pattern: str, new: str) -> Edit:
    """Replace what a regular expression finds first."""

    def edit(text: str) -> str:
        found, count = re.subn(pattern, new, text, count=1, flags=re.DOTALL)
        assert count, pattern
        return found

    return edit


def swapped(one: str, other: str) -> Edit:
    """Exchange two texts, each wherever it stands."""

    def edit(text: str) -> str:
        assert one in text and other in text, (one, other)
        return text.replace(one, "\0").replace(other, one).replace("\0", other)

    return edit


def both(*edits: Edit) -> Edit:
    """One edit after the other."""

    def edit(text: str) -> str:
        for part in edits:
            text = part(text)
        return text

    return edit


@dataclass(frozen=True)
class Built:
    """A spec with its compiled files.

    Attributes:
        compilation: The spec, compiled.
        targets: What it compiled to, written.
        folder: Where copies can be made.
    """

    compilation: api.Compilation
    targets: dict[str, TargetFiles]
    folder: Path

    def verified(
        self,
        name: str,
        edit: Edit | None = None,
        *,
        file: str = "",
        engines: bool = False,
        run_edited: bool = True,
    ) -> Agreement:
        """Verify a target, one of its files edited.

        Args:
            name: The target.
            edit: What is done to a file of it.
            file: End of that file's name; default: the main one.
            engines: Whether its engine is asked too.
            run_edited: Whether it may execute the edited file, which is ours.
        """
        target = self.targets[name]
        if edit is not None:
            copy = self.folder / "edited"
            shutil.rmtree(copy, ignore_errors=True)
            shutil.copytree(target.folder, copy)
            path = next(copy / f for f in target.files if f.endswith(file))
            path.write_text(edit(path.read_text("utf-8")), "utf-8")
            target = replace(target, folder=str(copy))
        done = self.compilation
        return verify(
            done.actuators, done.robot, [target], spec="spec.yaml", engines=engines, run_edited=run_edited
        )


def build(folder: Path, spec: str = SPEC, model: str = MODEL, name: str = "rich.xml") -> Built:
    """Compile a spec into a folder."""
    (folder / name).write_text(model, "utf-8")
    (folder / "spec.yaml").write_text(spec, "utf-8")
    done = api.compile(folder / "spec.yaml", output=str(folder / "out"))
    found = lay_out(list(zip(done.targets, done.emissions, strict=True)), None)
    return Built(done, {target.name: target for target in found}, folder)
