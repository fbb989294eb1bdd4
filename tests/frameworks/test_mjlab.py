"""The emitted mjlab text in mjlab itself: torque, passive numbers and lags equal what the spec asks for."""

from __future__ import annotations

import base64
import json
import sysconfig
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from actspec.api import load, load_robot, resolve
from actspec.ir import Level
from actspec.laws import initial_command_state, law_of, step_command
from actspec.targets.base import TargetOptions
from actspec.targets.mjlab.emit import emit
from tests.frameworks.prepare import Frameworks, ProbeAnswer
from tests.targets.mjlab.emitting import Written, written

PROBE = Path(__file__).with_name("mjlab_probe.py")
ROOT = Path(__file__).parents[2]

RTOL = 1e-5
"""mjlab computes in single precision: 24 bits, a few roundings deep."""

Array = NDArray[np.float64]

STEP = 0.005
ENVS = 32


@dataclass(frozen=True)
class Job:
    """One module to run.

    Attributes:
        written: It, with its spec and robot.
        model: The robot's text.
        grid: Errors and speeds to compute torques for, (error, speed); empty: none.
        sequence: Commands of each step, for delays; empty: none.
        mutation: Text to replace in the module, and what by.
    """

    written: Written
    model: str
    grid: tuple[Array, Array] | None = None
    sequence: tuple[float, ...] = ()
    mutation: tuple[str, str] | None = None

    @property
    def joints(self) -> list[str]:
        """Managed joints in the robot's order: the columns of every array."""
        return [actuator.joint for actuator in self.written.actuators.joints]

    def request(self) -> dict[str, Any]:
        """For the probe."""
        first, *rest = self.written.emission.files
        data = first.data
        if self.mutation is not None:
            old, new = (text.encode() for text in self.mutation)
            assert data.count(old) >= 1, old
            data = data.replace(old, new)
        files = {first.path: data, **{file.path: file.data for file in rest}}
        return {
            "files": {path: base64.b64encode(held).decode() for path, held in files.items()},
            "module": first.path,
            "model": self.model,
            "step": STEP,
            "joints": self.joints,
            "command": {a.joint: a.command.value for a in self.written.actuators.joints},
            "envs": ENVS,
        }

    def points(self) -> dict[str, Array]:
        """States and commands, (n_point, n_joint): each joint is asked for -3 to 3 times its limit."""
        if self.grid is None:
            return {}
        shares, speeds = (axis.ravel() for axis in np.meshgrid(*self.grid))
        q = 0.05 * np.cos(np.arange(len(shares)))
        columns = []
        for actuator in self.written.actuators.joints:
            law = self.law(actuator.joint)
            limit = law.effort_limit if np.isfinite(law.effort_limit) else 10.0
            scale = law.no_load_speed or (limit / law.kd if law.kd else 1.0)
            qd = scale * speeds
            asked = limit * shares
            command = {
                "position": q + (asked + law.kd * qd) / (law.kp or 1.0),
                "velocity": qd + asked / (law.kd or 1.0),
                "effort": asked,
            }[actuator.command.value]
            columns.append((q, qd, command))
        return {
            name: np.stack([column[k] for column in columns], axis=1)
            for k, name in enumerate(("q", "qd", "command"))
        }

    def law(self, joint: str) -> Any:
        """The law that mjlab is held to: what is a recorded approximation is out of it."""
        actuator = self.written.actuators.joint(joint)
        assert actuator is not None
        return replace(law_of(actuator), encoder_bias=0.0, filter_cutoff=None, command_range=None)


def faults(job: Job, said: Mapping[str, Any], arrays: Mapping[str, Array]) -> list[str]:
    """Everything in which mjlab differs from the spec; empty: nothing."""
    if "error" in said:
        return [said["error"]]
    found = []
    actuators = job.written.actuators.joints
    if sorted(set(said["actuators"]) - {"kept"}) != sorted(job.joints):
        return [f"actuators {said['actuators']} are not {job.joints}"]
    for key, name in (
        ("armature", "armature"),
        ("frictionloss", "friction_coulomb"),
        ("damping", "friction_viscous"),
    ):
        for actuator, value in zip(actuators, arrays[key], strict=True):
            asked = getattr(actuator, name).value
            if asked is not None and not np.isclose(value, asked, rtol=RTOL, atol=0.0):
                found.append(f"{actuator.joint}: {name} {value:g} is not {asked:g}")
    for actuator, limits, limited in zip(
        actuators, arrays["forcerange"], arrays["forcelimited"], strict=True
    ):
        asked = actuator.effort_limit.value
        if (asked is not None) != bool(limited) or (asked and not np.allclose(limits, (-asked, asked))):
            found.append(f"{actuator.joint}: forcerange {limits} is not -+{asked}")
    if job.grid is not None:
        points = job.points()
        for column, actuator in enumerate(actuators):
            law = job.law(actuator.joint)
            q, qd, command = (points[name][:, column] for name in ("q", "qd", "command"))
            # What the probe's arrays become there is what the law gets too.
            q, qd, command = (x.astype(np.float32).astype(np.float64) for x in (q, qd, command))
            asked = law.torque(command, q, qd)
            error = np.abs(arrays["force"][:, column] - asked) / np.abs(asked).max()
            if not error.max() <= RTOL:
                found.append(f"{actuator.joint}: torque differs by {error.max():.1e}")
    return found


def expected_line(job: Job, joint: str, steps: int) -> Array:
    """Torque of the law at each step of the sequence, the joint held at 0, behind a delay of `steps`."""
    law = job.law(joint)
    state = initial_command_state(job.sequence[0], steps)
    torques = []
    for command in job.sequence:
        effective, state = step_command(state, command, steps=steps, alpha=None)
        torques.append(float(law.torque(np.float64(effective), np.float64(0.0), np.float64(0.0))))
    return np.array(torques)


# -- the robots ------------------------------------------------------------------------------------

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


@dataclass
class Run:
    """All modules, run."""

    answer: ProbeAnswer
    jobs: dict[str, Job] = field(default_factory=dict)

    def said(self, name: str) -> dict[str, Any]:
        """What was said of one module."""
        found: dict[str, Any] = self.answer.said[name]
        return found

    def arrays(self, name: str) -> dict[str, Array]:
        """Its arrays."""
        head = f"{name}."
        return {k.removeprefix(head): v for k, v in self.answer.arrays.items() if k.startswith(head)}

    def faults(self, name: str) -> list[str]:
        """In what it differs."""
        return faults(self.jobs[name], self.said(name), self.arrays(name))


def probed(frameworks: Frameworks, jobs: dict[str, Job]) -> Run:
    """Run modules in mjlab, all in one process."""
    arrays: dict[str, Array] = {}
    for name, one in jobs.items():
        arrays |= {f"{name}.{key}": value for key, value in one.points().items()}
        if one.sequence:
            arrays[f"{name}.sequence"] = np.tile(np.array(one.sequence)[:, None], (1, len(one.joints)))
    return Run(frameworks.run_probe(PROBE, {n: j.request() for n, j in jobs.items()}, arrays), jobs)


@pytest.fixture(scope="module")
def ran(frameworks: Frameworks) -> Run:
    """Every module of this file, in one process."""
    return probed(frameworks, {**JOBS, **SEEDED})


# -- the tests -------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["a1", "rich"])
def test_torque_and_passive_numbers(name: str, ran: Run) -> None:
    """Over a grid of torque asked for and speed, mjlab's torque is the law's; the joint's numbers are the spec's."""
    assert ran.faults(name) == []
    assert ran.arrays(name)["force"].shape == (13 * 23, len(JOBS[name].joints))


def test_the_models_own_actuators_go(ran: Run) -> None:
    """The model's servo and filter on driven joints are gone, the tendon's motor stays, and no limit is narrower."""
    assert sorted(ran.said("rich")["actuators"]) == sorted([*JOBS["rich"].joints, "kept"])
    narrow = JOBS["rich"].joints.index("narrow")
    assert ran.arrays("rich")["actfrcrange"][narrow].tolist() == [-11.0, 11.0]


def expected(name: str, steps: int) -> Array:
    return expected_line(JOBS[name], "hip", steps)


@pytest.mark.parametrize("name", ["fixed", "fixed_dc"])
def test_fixed_delay(name: str, ran: Run) -> None:
    """10 ms are two steps of 5 ms, in every environment and in a second episode too."""
    lagged = ran.arrays(name)["lagged"][..., 0]
    assert lagged.shape == (2, len(RAMP), ENVS)
    # kp x (0.01, 0.01, 0.01, 0.02, 0.03, ...): the line is full of the first command.
    assert expected(name, 2)[:5] == pytest.approx([0.25, 0.25, 0.25, 0.5, 0.75])
    np.testing.assert_allclose(lagged, np.broadcast_to(expected(name, 2)[:, None], lagged.shape), rtol=RTOL)


@pytest.mark.parametrize("name", ["episode", "episode_dc"])
def test_delay_of_an_episode(name: str, ran: Run) -> None:
    """Each environment draws 0, 1 or 2 steps at a reset and keeps them; every lag occurs, and a reset draws anew."""
    lagged = ran.arrays(name)["lagged"][..., 0]
    table = np.stack([expected(name, steps) for steps in range(3)])
    lags = np.full((2, ENVS), -1)
    for episode in range(2):
        for env in range(ENVS):
            same = [k for k in range(3) if np.allclose(lagged[episode, :, env], table[k], rtol=RTOL)]
            assert len(same) == 1, lagged[episode, :, env]
            lags[episode, env] = same[0]
    assert set(lags.ravel().tolist()) == {0, 1, 2}
    assert (lags[0] != lags[1]).any()


def test_delay_of_each_step(ran: Run) -> None:
    """Drawn at every step: a torque is that of the last three commands, and an environment does not keep one lag."""
    lagged = ran.arrays("each")["lagged"][..., 0]
    table = np.stack([expected("each", steps) for steps in range(3)])
    near = np.isclose(lagged[None], table[:, None, :, None], rtol=RTOL)
    assert near.any(axis=0).all()
    # After the line has filled, each row fits one lag only.
    drawn = near[:, :, 3:].argmax(axis=0)
    assert (drawn.max(axis=1) > drawn.min(axis=1)).all()


def test_curve_is_as_far_off_as_recorded(ran: Run) -> None:
    """The line in place of an asymmetric curve differs by no more than its approximation says, and by nearly that."""
    one = JOBS["curve"]
    points = one.points()
    asked = one.law("hip").torque(*(points[name][:, 0] for name in ("command", "q", "qd")))
    error = float(np.abs(ran.arrays("curve")["force"][:, 0] - asked).max())
    said = one.written.lost("torque_speed_curve").max_torque_error
    assert said is not None
    assert 0.9 * said <= error <= said * (1 + RTOL)


def test_dc_motor_anchors(frameworks: Frameworks) -> None:
    """The golden table of DESIGN 5: 23.5, 11.75, 0, -11.75, -23.5, -23.5 N*m at 0, 15, 30, 45, 60, 70 rad/s."""
    spec = f"  leg: {{joints: [hip], level: dc_motor, motor: anchor, {PD}, effort_limit: 23.5 N*m}}"
    one = job(spec)
    speeds = np.array([[0.0], [15.0], [30.0], [45.0], [60.0], [70.0]])
    still = np.zeros_like(speeds)
    arrays = {"anchor.q": still, "anchor.qd": speeds, "anchor.command": still + 10.0}
    found = frameworks.run_probe(PROBE, {"anchor": one.request()}, arrays).arrays["anchor.force"][:, 0]
    assert found == pytest.approx([23.5, 11.75, 0.0, -11.75, -23.5, -23.5], abs=1e-5)


def test_network(frameworks: Frameworks, tmp_path: Path) -> None:
    """Order, sign, scales and taps of a network arrive, and its torque is clipped at effort_limit."""
    weight = [1.0, 10.0, 100.0, 0.0, 0.0, 0.0]
    made = frameworks.run_probe(PROBE, {"net": {"weights": {"weight": weight, "bias": 0.5}}})
    (tmp_path / "net.pt").write_bytes(made.arrays["net.network"].tobytes())
    manifest = {
        "format": "actspec-network/1",
        "kind": "mlp",
        "inputs": "position_velocity",
        "taps": [0, 1, 2],
        "tap_period": "5 ms",
        "position_scale": -2.0,
        "velocity_scale": 3.0,
        "torque_scale": 4.0,
        "initial_history": "first_sample",
    }
    (tmp_path / "net.json").write_text(json.dumps(manifest), encoding="utf-8")
    spec = (
        "  leg: {joints: [hip], level: actuator_net, effort_limit: 12 N*m,"
        " network: {file: net.pt, manifest: net.json}}"
    )
    one = job(spec, path=str(tmp_path / "spec.yaml"), sequence=(0.001, 0.002, 0.004, 0.008, 0.016))
    assert one.written.actuators.joints[0].level is Level.ACTUATOR_NET
    lagged = probed(frameworks, {"net": one}).arrays("net")["lagged"]
    # tau = 4 (0.5 - 2 (e_k + 10 e_k-1 + 100 e_k-2)), e the commands with the joint at 0, clipped at 12:
    # 2 - 8 x 0.111 = 1.112; 2 - 8 x 0.112; 2 - 8 (0.004 + 0.02 + 0.1); 2 - 8 x 0.248; 2 - 8 x 0.496.
    assert lagged[0, :, 0, 0] == pytest.approx([1.112, 1.104, 1.008, 0.016, -1.968], abs=1e-5)


@pytest.mark.parametrize("name", [name for name in SEEDED if name != "lag-one-off"])
def test_seeded_mistakes_are_found(name: str, ran: Run) -> None:
    """A module with one mistake in it does not pass the checks above."""
    assert ran.faults(name)


def test_seeded_lag_is_found(ran: Run) -> None:
    """A lag that is one step off does not give the expected sequence."""
    one = SEEDED["lag-one-off"]
    lagged = ran.arrays("lag-one-off")["lagged"][..., 0]
    assert not np.allclose(lagged, expected_line(one, "hip", 2)[:, None], rtol=RTOL)


def test_live_articulation(frameworks: Frameworks) -> None:
    """`actspec.mjlab.articulation` is mjlab's own object with the spec's numbers."""
    paths = [str(ROOT), sysconfig.get_paths()["purelib"]]
    job = {"live": {"live": str(ROOT / "robots" / "a1.yaml"), "paths": paths}}
    found = frameworks.run_probe(PROBE, job).said["live"]
    assert found["class"] == "EntityArticulationInfoCfg"
    ((kind, fields),) = found["actuators"]
    assert kind == "DcMotorActuatorCfg"
    expected = {
        "stiffness": 25.0,
        "damping": 0.5,
        "effort_limit": 33.5,
        "velocity_limit": 21.0,
        "armature": 0.01,
    }
    assert fields | expected == fields
