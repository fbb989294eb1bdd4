"""The overlays that are run in Newton: every drive, clamp and command, robots, random specs, and seeded mistakes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from actspec.api import load, load_robot, resolve
from actspec.ir import Source
from tests.frameworks.newton_asking import Job
from tests.frameworks.newton_stage import stage_of
from tests.targets.leg import LEG, REST
from tests.targets.newton.emitting import emitted, written

ROOT = Path(__file__).parents[2]

GRID = (np.linspace(-3.0, 3.0, 13), np.linspace(-2.2, 2.2, 23))

HINGES = ("pd", "free", "vel", "eff", "nokp", "dc", "dcvel", "dceff", "biased")
SLIDES = ("rod", "rod_pd")


def chain(hinges: tuple[str, ...], slides: tuple[str, ...], *, actuators: str = "") -> str:
    """A floating chain of bodies, each with one joint, whose numbers are those of no spec."""
    opened = ""
    for name in hinges:
        opened += (
            f'<body name="b_{name}" pos="0.1 0 0"><joint name="{name}" damping="0.9"/><geom size="0.1"/>'
        )
    for name in slides:
        opened += f'<body name="b_{name}" pos="0.1 0 0"><joint name="{name}" type="slide"/><geom size="0.1"/>'
    closed = "</body>" * (len(hinges) + len(slides))
    return (
        '<mujoco model="probe"><compiler angle="radian"/><worldbody><body name="trunk"><freejoint/>'
        f'<geom size="0.1"/>{opened}{closed}</body></worldbody><actuator>{actuators}</actuator></mujoco>'
    )


RICH = chain(HINGES, SLIDES, actuators='<position name="old" joint="pd" kp="77" kv="3"/>')

PD = "kp: 25 N*m/rad, kd: 0.5 N*m*s/rad"
PASSIVE = (
    "armature: 0.01 kg*m^2, friction: {coulomb: 0.2 N*m, viscous: 0.04 N*m*s/rad}, velocity_limit: 20 rad/s"
)
SLIDING = "armature: 0.3 kg, friction: {coulomb: 2 N, viscous: 5 N*s/m}, velocity_limit: 3 m/s"
GROUPS = f"""
  pd: {{joints: [pd], level: ideal_pd, {PD}, effort_limit: 24 N*m, {PASSIVE}}}
  free: {{joints: [free], level: ideal_pd, {PD}, effort_limit: unknown}}
  vel: {{joints: [vel], level: ideal_pd, command: velocity, kd: 0.8 N*m*s/rad, effort_limit: 9 N*m}}
  eff: {{joints: [eff], level: ideal_pd, command: effort, effort_limit: 7 N*m}}
  nokp: {{joints: [nokp], level: ideal_pd, kp: 0 N*m/rad, kd: 2 N*m*s/rad, effort_limit: 5 N*m}}
  dc: {{joints: [dc], level: dc_motor, motor: line, {PD}, effort_limit: 24 N*m, {PASSIVE}}}
  dcvel: {{joints: [dcvel], level: dc_motor, motor: line, command: velocity, kd: 2 N*m*s/rad, effort_limit: 20 N*m}}
  dceff: {{joints: [dceff], level: dc_motor, motor: line, command: effort, effort_limit: 30 N*m}}
  biased: {{joints: [biased], level: ideal_pd, {PD}, effort_limit: 11 N*m, encoder_bias: 0.07 rad}}
  rod: {{joints: [rod], level: dc_motor, motor: line_s, kp: 900 N/m, kd: 40 N*s/m, effort_limit: 150 N, {SLIDING}}}
  rod_pd: {{joints: [rod_pd], level: ideal_pd, kp: 700 N/m, kd: 30 N*s/m, effort_limit: 90 N}}
"""

MOTORS = """
  line: {side: joint, stall_torque: 45 N*m, no_load_speed: 30 rad/s}
  line_s: {side: joint, stall_torque: 300 N, no_load_speed: 2 m/s}
  anchor: {side: joint, stall_torque: 23.5 N*m, no_load_speed: 30 rad/s}
  curve:
    side: joint
    curve: {drive_torque: 20 N*m, brake_torque: 25 N*m, knee_speed: 14 rad/s, no_load_speed: 30 rad/s}
"""


def job(groups: str, model: str = LEG, *, robot: str = REST, **more: Any) -> Job:
    """A spec against a model, on the stage of that model."""
    import mujoco

    ours = {key: more.pop(key) for key in ("version", "path", "motors") if key in more}
    made = written(groups, model, robot=robot, **{"motors": MOTORS, **ours})
    compiled = mujoco.MjModel.from_xml_string(model)
    return Job(made, stage_of(compiled, made.robot.name), paths(compiled, made), **more)


def paths(model: Any, made: Any) -> tuple[str, ...]:
    """Where the stage has the managed joints, from the compiled model's bodies."""
    found = []
    for actuator in made.actuators.joints:
        body, names = int(model.joint(actuator.joint).bodyid[0]), [actuator.joint]
        while body:
            names.insert(0, model.body(body).name)
            body = int(model.body_parentid[body])
        found.append("/".join(["", made.robot.name, "Geometry", *names]))
    return tuple(found)


def of_robot(name: str) -> Job:
    """A robot of this repository."""
    import mujoco

    from actspec.robot.mjspec import open_spec

    spec = load(ROOT / "robots" / f"{name}.yaml")
    robot = load_robot(spec)
    made = emitted(resolve(spec, robot), robot)
    # Of somebody else's model the meshes are left out: stand-ins take their place.
    compiled = open_spec(robot.files, format=robot.format).compile()
    assert isinstance(compiled, mujoco.MjModel)
    return Job(made, stage_of(compiled, robot.name), paths(compiled, made), GRID)


def random_job(seed: int) -> Job:
    """A spec of ten joints, each with numbers and a kind of drive of its own."""
    rng = np.random.default_rng(seed)

    def draw(low: float, high: float) -> str:
        """Four digits, evenly in the logarithm."""
        return f"{float(np.exp(rng.uniform(np.log(low), np.log(high)))):.4g}"

    hinges, slides = tuple(f"h{k}" for k in range(7)), tuple(f"s{k}" for k in range(3))
    groups, motors = "", ""
    for name in (*hinges, *slides):
        hinge = name in hinges
        torque, angle, inertia = ("N*m", "rad", "kg*m^2") if hinge else ("N", "m", "kg")
        command = rng.choice(["position", "position", "velocity", "effort"])
        level = rng.choice(["ideal_pd", "dc_motor"])
        fields = [f"joints: [{name}]", f"level: {level}", f"command: {command}"]
        if command == "position":
            fields.append(f"kp: {draw(5, 300)} {torque}/{angle}")
            fields.append(f"encoder_bias: {rng.uniform(-0.1, 0.1):.4f} {angle}")
        if command != "effort":
            fields.append(f"kd: {draw(0.2, 5)} {torque}*s/{angle}")
        if level == "dc_motor":
            motors += f"\n  m_{name}: {{side: joint, stall_torque: {draw(10, 90)} {torque}, "
            motors += f"no_load_speed: {draw(8, 40)} {angle}/s}}"
            fields.append(f"motor: m_{name}")
        fields.append(f"effort_limit: {draw(5, 120)} {torque}")
        if rng.random() < 0.7:
            fields.append(f"armature: {draw(1e-3, 0.1)} {inertia}")
            fields.append(f"velocity_limit: {draw(5, 60)} {angle}/s")
        if rng.random() < 0.7:
            viscous = f"{draw(1e-3, 2)} {torque}*s/{angle}"
            fields.append(f"friction: {{coulomb: {draw(1e-2, 2)} {torque}, viscous: {viscous}}}")
        groups += f"  g_{name}: {{{', '.join(fields)}}}\n"
    return job(groups, chain(hinges, slides), robot="", motors=motors, grid=GRID)


RAMP = tuple(0.01 * k for k in range(1, 13))
LINE_PD = f"  leg: {{joints: [hip], level: dc_motor, motor: line, {PD}, effort_limit: 24 N*m, delay: %s}}"
PLAIN_PD = f"  leg: {{joints: [hip], level: ideal_pd, {PD}, effort_limit: 24 N*m, delay: %s}}"
STIFF = f"  leg: {{joints: [hip], level: dc_motor, motor: line, {PD}, effort_limit: 24 N*m, {PASSIVE}}}"
CURVE = f"  leg: {{joints: [hip], level: dc_motor, motor: curve, {PD}, effort_limit: 24 N*m}}"
TWO_DELAYS = """
  hip: {joints: [hip], level: ideal_pd, kp: 25 N*m/rad, kd: 0.5 N*m*s/rad, effort_limit: 24 N*m, delay: 10 ms}
  calf: {joints: [calf], level: ideal_pd, kp: 40 N*m/rad, kd: 0.5 N*m*s/rad, effort_limit: 24 N*m, delay: 25 ms}
"""
NETWORK = """
  leg:
    joints: [hip]
    level: actuator_net
    effort_limit: 12 N*m
    network: {file: net.onnx, manifest: net.json}
"""

ARM = """<mujoco model="arm"><compiler angle="radian"/><worldbody><body name="upper">
  <joint name="hip" axis="0 1 0"/><geom size="0.1"/></body></worldbody>
  <actuator><motor name="old" joint="hip"/></actuator></mujoco>"""
"""One hinge on the world, of inertia 1 kg*m^2 in the stage."""
PUSHED = f"  leg: {{joints: [hip], level: ideal_pd, {PD}, effort_limit: 24 N*m, armature: 0.25 kg*m^2}}"


def hostile() -> Job:
    """An overlay whose words of strangers would end a comment, a string or a prim."""
    one = job(STIFF, grid=GRID)
    words = 'a\n}\ndef Scope "evil" {}\n#"""(\x00@</evil>'
    joints = tuple(
        replace(joint, group=words, kp=replace(joint.kp, source="x") if joint.kp else None)
        for joint in one.written.actuators.joints
    )
    actuators = replace(one.written.actuators, robot=words, joints=joints, sources=(Source("x", words),))
    return replace(one, written=emitted(actuators, one.written.robot))


JOBS: dict[str, Job] = {
    **{name: of_robot(name) for name in ("a1", "h1")},
    "rich": job(GROUPS, RICH, robot="", grid=GRID),
    "hostile": hostile(),
    "delayed": job(PLAIN_PD % "10 ms", sequence=RAMP),
    "delayed_dc": job(LINE_PD % "10 ms", sequence=RAMP),
    "two_delays": job(TWO_DELAYS, robot='unmanaged: ["rod"]', sequence=RAMP),
    "curve": job(CURVE, grid=GRID),
    "anchors": job(
        f"  leg: {{joints: [hip], level: dc_motor, motor: anchor, {PD}, effort_limit: 23.5 N*m}}",
        sequence=(10.0,) * 6,
        motion=((0.0,) * 6, (0.0, 15.0, 30.0, 45.0, 60.0, 70.0)),
    ),
    "pushed": job(PUSHED, ARM, robot="", solve=(0.1,)),
    **{f"random{seed}": random_job(seed) for seed in range(4)},
}

STIFF_JOB = job(STIFF, grid=GRID)
ARM_JOB = job(PUSHED, ARM, robot="", grid=GRID)


@dataclass(frozen=True)
class Seeded:
    """An overlay with one mistake in it.

    Attributes:
        job: It.
        fault: What must be said of it.
    """

    job: Job
    fault: str


def seeded(one: Job, old: str, new: str, fault: str) -> Seeded:
    """One text of an overlay, replaced."""
    return Seeded(replace(one, mutation=(old, new)), fault)


DRIVE = "float drive:angular:physics:"

SEEDED: dict[str, Seeded] = {
    # 0.04 + 0.5 N*m*s/rad, per degree: the drive's kd counted once more, outside of the clamp.
    "kd-in-damping": seeded(
        STIFF_JOB, "0.000698131700798", "0.00942477796077", "joint_damping 0.54 is not 0.04"
    ),
    "damping-per-radian": seeded(STIFF_JOB, "0.000698131700798", "0.04", "joint_damping 2.29183 is not 0.04"),
    "friction-per-degree": seeded(
        STIFF_JOB, "friction = 0.2", "friction = 0.00349065850399", "joint_friction 0.00349066 is not 0.2"
    ),
    "joint-speed-in-radians": seeded(
        STIFF_JOB, "= 1145.91559026", "= 20.0", "joint_velocity_limit 0.349066 is not 20"
    ),
    "no-load-in-degrees": seeded(
        STIFF_JOB, "velocityLimit = 30.0", "velocityLimit = 1718.87338539", "torque differs by"
    ),
    "viscous-in-kd": seeded(STIFF_JOB, "kd = 0.5", "kd = 0.54", "torque differs by"),
    "gains-per-degree": seeded(STIFF_JOB, "kp = 25.0", "kp = 0.436332312999", "torque differs by"),
    "stall-for-limit": seeded(
        STIFF_JOB, "maxMotorEffort = 24.0", "maxMotorEffort = 45.0", "torque differs by"
    ),
    "no-armature": seeded(STIFF_JOB, "armature = 0.01", "armature = 0.0", "joint_armature 0 is not 0.01"),
    "own-drive-stays": seeded(STIFF_JOB, f"{DRIVE}stiffness = 0.0", "", "the stage's own drive acts"),
    "force-limit-stays": seeded(
        STIFF_JOB, f"{DRIVE}maxForce = 24.0", "", "joint_effort_limit 0.25 is not 24"
    ),
    "own-actuator-stays": seeded(ARM_JOB, "active = false", "active = true", "['/arm/Physics/old']"),
    "other-joint": seeded(
        JOBS["a1"],
        "FR_hip/FR_thigh/FR_thigh_joint>",
        "FR_hip/FR_hip_joint>",
        "FR_thigh_joint: torque differs by",
    ),
    "clamp-lost": seeded(
        STIFF_JOB, '"NewtonDCMotorClampingAPI"', '"NewtonMaxEffortClampingAPI"', "torque differs by"
    ),
    "bias-turned": seeded(
        JOBS["rich"], "constEffort = -1.75", "constEffort = 1.75", "biased: torque differs by"
    ),
    "no-such-prim": seeded(STIFF_JOB, "thigh/hip>", "thigh/hop>", "does not exist on the stage"),
}
SEEDED_PUSH = replace(JOBS["pushed"], mutation=(f"{DRIVE}stiffness = 0.0", ""))
SEEDED_DELAY = replace(JOBS["delayed"], mutation=("delaySteps = 2", "delaySteps = 1"))
