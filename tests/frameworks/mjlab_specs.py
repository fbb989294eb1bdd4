"""The modules that are run in mjlab: every class and command, delays, and modules with one mistake in them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from actspec.api import load, load_robot, resolve
from actspec.targets.base import TargetOptions
from actspec.targets.mjlab.emit import emit
from tests.frameworks.mjlab_asking import Job
from tests.targets.mjlab.emitting import Written, written

ROOT = Path(__file__).parents[2]

GRID = (np.linspace(-3.0, 3.0, 13), np.linspace(-2.2, 2.2, 23))

RICH = """<mujoco>
  <compiler angle="radian"/>
  <default><joint damping="0.7" armature="0.02" frictionloss="0.3"/></default>
  <worldbody>
    <body><freejoint/><geom size="0.1"/>
      {bodies}
    </body>
  </worldbody>
  <tendon><fixed name="pull"><joint joint="rest" coef="1"/></fixed></tendon>
  <actuator>
    <position name="old" joint="pd" kp="77" kv="3"/>
    <motor name="kept" tendon="pull"/>
    <general name="filtered" joint="dc" dyntype="filter" gainprm="1" biastype="none"/>
  </actuator>
  <sensor><actuatorfrc actuator="old"/><jointpos joint="pd"/></sensor>
  <keyframe><key name="home" ctrl="1 2 3" act="0"/></keyframe>
</mujoco>"""

HINGES = ("pd", "free", "vel", "eff", "nokp", "dc", "dcvel", "dceff", "narrow", "rest")
NARROW = 'actuatorfrcrange="-3 3"'
BODIES = "".join(
    f'<body pos="{i} 0 0"><joint name="{name}" {NARROW if name == "narrow" else ""}/><geom size="0.1"/></body>'
    for i, name in enumerate(HINGES)
)
RICH = RICH.format(bodies=BODIES + '<body><joint name="rod" type="slide"/><geom size="0.1"/></body>')

PD = "kp: 25 N*m/rad, kd: 0.5 N*m*s/rad"
PASSIVE = "armature: 0.01 kg*m^2, friction: {coulomb: 0.2 N*m, viscous: 0.04 N*m*s/rad}"
GROUPS = f"""
  pd: {{joints: [pd], level: ideal_pd, {PD}, effort_limit: 24 N*m, {PASSIVE}}}
  free: {{joints: [free], level: ideal_pd, {PD}, effort_limit: unknown}}
  vel: {{joints: [vel], level: ideal_pd, command: velocity, kd: 0.8 N*m*s/rad, effort_limit: 9 N*m}}
  eff: {{joints: [eff], level: ideal_pd, command: effort, effort_limit: 7 N*m}}
  nokp: {{joints: [nokp], level: ideal_pd, kp: 0 N*m/rad, kd: 2 N*m*s/rad, effort_limit: 5 N*m}}
  dc: {{joints: [dc], level: dc_motor, motor: line, {PD}, effort_limit: 24 N*m, {PASSIVE}}}
  dcvel: {{joints: [dcvel], level: dc_motor, motor: line, command: velocity, kd: 2 N*m*s/rad, effort_limit: 20 N*m}}
  dceff: {{joints: [dceff], level: dc_motor, motor: line, command: effort, effort_limit: 30 N*m}}
  narrow: {{joints: [narrow], level: ideal_pd, {PD}, effort_limit: 11 N*m}}
  rod: {{joints: [rod], level: dc_motor, motor: line_s, kp: 900 N/m, kd: 40 N*s/m, effort_limit: 150 N}}
"""

ONE = "<mujoco><worldbody><body><joint name='hip'/><geom size='0.1'/></body></worldbody></mujoco>"


def job(groups: str, model: str = ONE, *, robot: str = "", path: str = "spec.yaml", **more: Any) -> Job:
    """A spec against a model."""
    return Job(written(groups, model, robot=robot, path=path, motors=MOTORS), model, **more)


MOTORS = """
  line: {side: joint, stall_torque: 45 N*m, no_load_speed: 30 rad/s}
  line_s: {side: joint, stall_torque: 300 N, no_load_speed: 2 m/s}
  anchor: {side: joint, stall_torque: 23.5 N*m, no_load_speed: 30 rad/s}
  curve:
    side: joint
    curve: {drive_torque: 20 N*m, brake_torque: 25 N*m, knee_speed: 14 rad/s, no_load_speed: 30 rad/s}
"""


def a1() -> Job:
    """The A1 of this repository."""
    spec = load(ROOT / "robots" / "a1.yaml")
    robot = load_robot(spec)
    actuators = resolve(spec, robot)
    options = TargetOptions("mjlab", "mjlab", "1.6", None, "out")
    model = robot.files[0].data.decode("utf-8")
    return Job(Written(actuators, robot, emit(actuators, robot, options)), model, GRID)


RAMP = tuple(0.01 * k for k in range(1, 13))
LINE_PD = f"  leg: {{joints: [hip], level: dc_motor, motor: line, {PD}, effort_limit: 24 N*m, delay: %s}}"
PLAIN_PD = f"  leg: {{joints: [hip], level: ideal_pd, {PD}, effort_limit: 24 N*m, delay: %s}}"
EPISODE = "{nominal: 5 ms, range: [0 ms, 10 ms], sampling: episode}"
EACH = "{nominal: 5 ms, range: [0 ms, 10 ms], sampling: step}"
STIFF = f"  leg: {{joints: [hip], level: dc_motor, motor: line, {PD}, effort_limit: 24 N*m, {PASSIVE}}}"

JOBS: dict[str, Job] = {
    "a1": a1(),
    "rich": job(GROUPS, RICH, robot='unmanaged: ["rest"]', grid=GRID),
    "fixed": job(PLAIN_PD % "10 ms", sequence=RAMP),
    "fixed_dc": job(LINE_PD % "10 ms", sequence=RAMP),
    "episode": job(PLAIN_PD % EPISODE, sequence=RAMP),
    "episode_dc": job(LINE_PD % EPISODE, sequence=RAMP),
    "each": job(PLAIN_PD % EACH, sequence=RAMP),
    "curve": job(
        f"  leg: {{joints: [hip], level: dc_motor, motor: curve, {PD}, effort_limit: 24 N*m}}", grid=GRID
    ),
}

SEEDED: dict[str, Job] = {
    # 0.5 + 0.04: the passive friction counted once more.
    "viscous-in-kd": job(STIFF, grid=GRID, mutation=("damping=0.5", "damping=0.54")),
    "saturation-for-limit": job(STIFF, grid=GRID, mutation=("effort_limit=24.0", "effort_limit=45.0")),
    "no-armature": job(STIFF, grid=GRID, mutation=("armature=0.01", "armature=0.0")),
    "pattern-misses": replace(JOBS["a1"], mutation=('".*_calf_joint"', '"F._calf_joint"')),
    "own-servo-stays": job(
        GROUPS,
        RICH,
        robot='unmanaged: ["rest"]',
        mutation=("  for actuator in own:\n    spec.delete(actuator)\n", ""),
    ),
    "lag-one-off": job(
        PLAIN_PD % "10 ms",
        sequence=RAMP,
        mutation=("_lag=2,", "_lag=1,"),
    ),
}
