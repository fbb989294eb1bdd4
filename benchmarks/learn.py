"""How near networks from logs come to a drive, beside the spec's DC motor and a fitted one: learn.md.

    python benchmarks/learn.py --write            # 5 minutes of 12 joints; writes the page
    python benchmarks/learn.py --short            # a minute, small networks, printed
    python benchmarks/learn.py --known            # without the fit
    python benchmarks/learn.py --logs DIR         # keeps logs, fit and networks there, and takes those that are there
    python benchmarks/learn.py --hard --write     # the page's section on drives at their limits alone

By the commands of docs/networks.md: experiments of `sysid design`, a virtual A1 of `sysid simulate` and what its
sensors make of it, `sysid fit` for friction and armature of the bench, `net train`. Judged on random sines and on what
a policy does: 50 Hz targets of a gait with noise. Times are processor times where the machine is shared. Exit code 1:
a goal is missed.
"""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import io
import json
import math
import os
import platform
import shutil
import sys
import tempfile
import time as clock
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT)]

from actspec import api  # noqa: E402
from actspec.cli.main import main as actspec  # noqa: E402
from actspec.diagnostics import Collector  # noqa: E402
from actspec.ir import JointActuator  # noqa: E402
from actspec.learn.closed_loop import HORIZON, Bench, baseline_laws, network_drive  # noqa: E402
from actspec.learn.evaluate import network_of, predicted  # noqa: E402
from actspec.learn.labels import inferred  # noqa: E402
from actspec.learn.recurrent import TAPS  # noqa: E402
from actspec.learn.windows import Dataset, dataset  # noqa: E402
from actspec.logs import JointLog, Log, Sidecar, load_log, write_log  # noqa: E402
from actspec.sysid.figures import Bounds  # noqa: E402
from actspec.sysid.virtual import Flaws, sensed  # noqa: E402

Array = np.ndarray[Any, Any]

PAGE = Path(__file__).with_suffix(".md")
RATE = 200.0
FIT_KINDS, FIT = ("steps", "multisine"), 6.0
"""What is fitted, the first part of each [s]."""
PART = 20.0
"""Of a designed experiment [s]."""
EXPERIMENTS = {"chirp": 4, "steps": 4, "multisine": 4, "targets": 3}
"""What is trained on, and how often each is repeated."""
TESTS = ("random", "policy")
HOLD, JUMPS = 0.02, 0.08
"""Time for which a policy's target holds [s], and the noise in those that are trained on [rad]."""
TRUE = {
    "coulomb: {value: 0.2 N*m, source: a1_urdf}": "coulomb: 0.4 N*m\n      static: 0.6 N*m\n"
    "      stribeck_velocity: 0.2 rad/s",
    "viscous: {value: 0.01 N*m*s/rad, source: a1_urdf}": "viscous: 0.03 N*m*s/rad",
    "    # Not published for the A1, so": "    delay: 7 ms\n    # Not published for the A1, so",
}
"""What the virtual robot has in place of lines of its spec."""
SAG = "20 %"
SENSORS = Flaws(position_noise=2e-4, velocity_noise=0.02, torque_noise=0.01)
"""Of logs that are trained on; a test's torque is the true one."""
ROBOTS = {"published": 0.22, "half": 0.5}
"""Play of the virtual robots, from end to end [deg]; they move alike, and their encoders read otherwise. Sources of all
figures: README.md."""
FITTED = {
    "    kp: {value: 25 N*m/rad, source: isaaclab_a1}": "    identified: fit.yaml\n    kp: identified",
    "    kd: {value: 0.5 N*m*s/rad, source: isaaclab_a1}": "    kd: identified\n    delay: identified",
}
BENCH = {
    "    effort_limit: {value: 33.5 N*m": "    identified: fit.yaml\n    effort_limit: {value: 33.5 N*m",
    "armature: {value: 0.01 kg*m^2, source: menagerie_a1}": "armature: identified",
    "coulomb: {value: 0.2 N*m, source: a1_urdf}": "coulomb: identified",
    "viscous: {value: 0.01 N*m*s/rad, source: a1_urdf}": "viscous: identified",
}
"""Lines of the spec that ask for what was fitted: of the drive, and of the joint, which all of them move."""
KNOWN = {
    "coulomb: {value: 0.2 N*m, source: a1_urdf}": "coulomb: 0.4 N*m",
    "viscous: {value: 0.01 N*m*s/rad, source: a1_urdf}": "viscous: 0.03 N*m*s/rad",
}
"""The robot's own figures, as the best of fits would have them; Stribeck is left out, as in MuJoCo."""
DELAY = {key: value for key, value in TRUE.items() if "delay" in value}
KINDS = {
    "measured": ("--torque-of", "drive"),
    "inferred": ("--torque", "inferred", "--base", "fixed"),
    "lstm": ("--torque-of", "drive", "--kind", "lstm"),
}
"""Network to its options."""
TRAINED = {"published": tuple(KINDS), "half": ("measured",)}
"""Networks of each robot."""
HARD = {"steps_hard": 100.0, "policy_hard": 20.0}
"""What drives at their limits are trained and tested on, and for how long [s]."""
LEVELS, HELD = 0.6, (0.06, 0.25)
"""Share of a joint's range within which it is sent there, and for how long at a time [s]."""
LAST = "## Drives at their limits"
"""Heading of the section that `--hard` makes."""
MISSED = "## What is missed, and why"
"""Heading of what is written by hand, and kept."""
SAMPLES = (1, 6, 20, 100)
"""Of histories from which the play is told."""
GOALS = {
    "of the DC motor's": 0.2,
    "of the fitted DC motor's": 0.4,
    "closed loop, of the DC motor's": 0.25,
    "inferred, of the measured: torque": 1.2,
    "inferred, of the measured: closed loop": 1.2,
    "training [s]": 120.0,
}


def run(*arguments: str) -> tuple[str, float, float]:
    """A command's output, its processor time and its time [s]; ends the program where it fails."""
    stream = io.StringIO()
    cpu, begun = sum(os.times()[:4]), clock.perf_counter()
    with contextlib.redirect_stdout(stream):
        code = actspec(list(arguments))
    cpu, begun = sum(os.times()[:4]) - cpu, clock.perf_counter() - begun
    print(f"  actspec {' '.join(arguments)[:100]}: {cpu:.1f} s of a processor", file=sys.stderr, flush=True)
    if code not in (0, 1):
        raise SystemExit(f"exit code {code}")
    return stream.getvalue(), cpu, begun


def policy(path: str, centre: Log, seconds: float, seed: int) -> None:
    """Commands of a trot at 50 Hz whose size comes and goes, with noise in each target."""
    random = np.random.default_rng(seed)
    rows, hold = round(seconds * RATE), round(RATE / 50.0)
    time = np.arange(rows // hold + 1) * 0.02
    joints = {}
    for name, joint in centre.joints.items():
        assert joint.command is not None
        size = {"hip": 0.12, "thigh": 0.3, "calf": 0.35}[name.split("_")[1]]
        phase = math.pi * (name[:2] in ("FL", "RR")) + 0.5 * math.pi * ("calf" in name)
        swell = 0.5 + 0.5 * np.sin(2 * np.pi * 0.1 * time + random.uniform(0, 6))
        step = np.sin(2 * np.pi * random.uniform(1.6, 2.4) * time + phase)
        target = np.median(joint.command) + size * (swell * step + 0.25 * random.standard_normal(len(time)))
        joints[name] = JointLog(name, joint.linear, command=np.repeat(target, hold)[:rows])
    write_log(Log(path, "", np.arange(rows) / RATE, joints, Sidecar()), force=True)


def specs(known: bool) -> None:
    """The spec, the virtual robot's, and those with fitted figures, beside copies of the model."""
    text = (ROOT / "robots" / "a1.yaml").read_text("utf-8")
    text = text.replace("model: a1/a1.xml", f"model: {ROOT / 'robots' / 'a1' / 'a1.xml'}")
    bench, fitted = (KNOWN, KNOWN | DELAY) if known else (BENCH, BENCH | FITTED)
    for name, changes in {"spec": {}, "true": TRUE, "bench": bench, "fitted": fitted}.items():
        found = text
        for old, new in changes.items():
            assert old in found, old
            if name == "fitted" and old == "    effort_limit: {value: 33.5 N*m":
                continue
            found = found.replace(old, new)
        Path(f"{name}.yaml").write_text(found, "utf-8")


def repeated(given: str, path: str, times: int, seed: int) -> None:
    """Commands again and again, each joint's begun elsewhere each time, so that no two moments are alike."""
    log, random = load_log(given), np.random.default_rng(seed)
    joints = {}
    for name, joint in log.joints.items():
        assert joint.command is not None
        turns = [0, *random.integers(0, len(log.time), times - 1)]
        parts = [np.roll(joint.command, turn) for turn in turns]
        joints[name] = JointLog(name, joint.linear, command=np.concatenate(parts))
    rows = times * len(log.time)
    write_log(Log(path, "", np.arange(rows) / RATE, joints, log.sidecar), force=True)


def held(given: str, path: str, seed: int) -> None:
    """Commands as a policy sends them: held for a while, with noise in each."""
    log, random = load_log(given), np.random.default_rng(seed)
    hold = round(HOLD * RATE)
    rows = np.arange(len(log.time)) // hold * hold
    joints = {}
    for name, joint in log.joints.items():
        assert joint.command is not None
        jump = np.repeat(random.standard_normal(len(rows) // hold + 1), hold)[: len(rows)]
        joints[name] = JointLog(name, joint.linear, command=joint.command[rows] + JUMPS * jump)
    write_log(Log(path, "", log.time, joints, log.sidecar), force=True)


def commands(short: bool) -> None:
    """What is sent in each log; none is made that is there."""
    for k, kind in enumerate(("chirp", "steps", "multisine", "random")):
        given = ("--experiment", kind, "--duration", f"{PART:g} s", "--rate", f"{RATE:g} Hz", "--together")
        if not Path(f"design_{kind}.npz").exists():
            run("sysid", "design", "spec.yaml", "-o", f"design_{kind}.npz", *given, "--seed", str(k))
        if kind in EXPERIMENTS:
            repeated(f"design_{kind}.npz", f"command_{kind}.npz", 1 if short else EXPERIMENTS[kind], k)
    repeated("design_random.npz", "command_random.npz", 1, 3)
    repeated("design_multisine.npz", "command_targets.npz", 1 if short else EXPERIMENTS["targets"], 4)
    held("command_targets.npz", "command_targets.npz", 5)
    policy("command_policy.npz", load_log("command_random.npz"), PART, 3)


def moved(kinds: Sequence[str] = (*EXPERIMENTS, *TESTS)) -> None:
    """The true motion in each log; none is made that is there."""
    for k, kind in enumerate(kinds):
        if not Path(f"{kind}.npz").exists():
            more = ("--command", f"command_{kind}.npz", "-o", f"{kind}.npz", "--seed", str(k))
            run("sysid", "simulate", "true.yaml", *more, "--sag", SAG)


def read(folder: Path, play: float, kinds: Sequence[str] = (*EXPERIMENTS, *TESTS)) -> None:
    """What the sensors of a robot with so much play [deg] make of that; `fit_` are first parts."""
    actuators = resolved("true")
    for k, kind in enumerate(kinds):
        log = load_log(f"{kind}.npz")
        assert list(log.joints) == [actuator.joint for actuator in actuators]
        q, qd, torque = (
            np.stack([getattr(joint, name) for joint in log.joints.values()], axis=1)
            for name in ("position", "velocity", "torque")
        )
        flaws = dataclasses.replace(SENSORS, play=math.radians(play))
        if kind in (*TESTS, "policy_hard"):
            flaws = dataclasses.replace(flaws, torque_noise=0.0)
        path, random = str(folder / f"{kind}.npz"), np.random.default_rng(10 + k)
        told = sensed(log, actuators, q, qd, torque, path, flaws, random)
        write_log(told, force=True)
        if kind in FIT_KINDS:
            keep = slice(0, round(FIT * RATE))
            names = ("command", "position", "velocity", "torque")
            joints = {
                name: dataclasses.replace(joint, **{n: getattr(joint, n)[keep] for n in names})
                for name, joint in told.joints.items()
            }
            path = str(folder / f"fit_{kind}.npz")
            write_log(dataclasses.replace(told, path=path, time=told.time[keep], joints=joints), force=True)


def jumps(path: str, seconds: float, seed: int) -> None:
    """Commands that jump within the joints' ranges, each held for a while: what brings drives to their limits."""
    random, rows, joints = np.random.default_rng(seed), round(seconds * RATE), {}
    for actuator in resolved("spec"):
        assert actuator.position_range is not None
        low, high = actuator.position_range
        command = np.empty(0)
        while len(command) < rows:
            level = 0.5 * (low + high) + 0.5 * LEVELS * (high - low) * random.uniform(-1, 1)
            command = np.append(command, np.full(round(random.uniform(*HELD) * RATE), level))
        joints[actuator.joint] = JointLog(actuator.joint, False, command=command[:rows])
    write_log(Log(path, "", np.arange(rows) / RATE, joints, Sidecar()), force=True)


def hard(where: Path) -> str:
    """The page's section on drives at their limits, where the torque-speed line sags."""
    specs(True)
    play = ROBOTS["published"]
    for k, (kind, seconds) in enumerate(HARD.items()):
        jumps(f"command_{kind}.npz", seconds, 20 + k)
    moved(tuple(HARD))
    folder = where / "hard"
    folder.mkdir(exist_ok=True)
    read(folder, play, tuple(HARD))
    os.chdir(folder)
    specs(True)
    train, test = HARD
    run("net", "train", "bench.yaml", f"{train}.npz", "-o", "nets/hard", *KINDS["measured"], "--force")
    bed = Test(test, play)
    held_down = []
    for actuator, track in zip(bed.bench.actuators, bed.data.tracks, strict=True):
        laws = baseline_laws(actuator)
        seen = [values[track.rows] for values in (track.in_force, track.position, track.velocity)]
        held_down.append(laws["ideal_pd"].torque(*seen) != laws["dc_motor"].torque(*seen))
    rows = {
        "DC motor of the spec": bed.motor("spec"),
        "DC motor with the robot's own delay and friction": bed.motor("fitted", math.ceil),
        "network, measured": bed.network("nets/hard.json"),
    }
    motor, fit, network = rows.values()
    lines = [
        LAST,
        "",
        f"Written by `python benchmarks/learn.py --hard --write`. The robot with {play:g}° of play, {HARD[train]:g} s "
        f"to train on and {HARD[test]:g} s of another seed to test: commands that jump within {LEVELS * 1e2:.0f} % of "
        f"each joint's range, held for {HELD[0] * 1e3:g} to {HELD[1] * 1e3:g} ms. RMS torque {bed.size:.3g} N·m; the "
        f"torque-speed line holds it down in {1e2 * np.mean(np.concatenate(held_down)):.0f} % of the rows, and sags by "
        f"{SAG} at full torque, which no law of the spec has. Delay, friction, kp and kd of the second law are the "
        "robot's own, as the best of fits would have them; its delay is in the steps that come nearer in motion.",
        "",
        f"| | RMSE [N·m] | position RMSE of {HORIZON:g} s in MuJoCo [mrad] |",
        "|---|---:|---:|",
        *(f"| {name} | {torque:.3g} | {motion * 1e3:.3g} |" for name, (torque, motion) in rows.items()),
        "",
        f"The network's RMSE is {network[0] / motor[0]:.2f} of the DC motor's (goal 0.2), {network[0] / fit[0]:.2f} of "
        f"the fitted one's (goal 0.4); in motion {network[1] / motor[1]:.2f} and {network[1] / fit[1]:.2f}.",
    ]
    return "\n".join(lines) + "\n"


def resolved(name: str) -> list[JointActuator]:
    """The joints of a spec."""
    spec = api.load(f"{name}.yaml")
    return list(api.resolve(spec, api.load_robot(spec)).joints)


def rms(parts: Sequence[Array]) -> float:
    """Root mean square of all."""
    return float(np.sqrt(np.mean(np.concatenate([part.ravel() for part in parts]) ** 2)))


class Test:
    """A log to judge on: torque errors at the rows that every law can tell, positions of rollouts."""

    def __init__(self, kind: str, play: float) -> None:
        self.play = math.radians(play)
        spec = api.load("bench.yaml")
        self.robot = api.load_robot(spec)
        self.actuators = api.resolve(spec, self.robot)
        out = Collector()
        self.data: Dataset = dataset(
            self.actuators, [load_log(f"{kind}.npz")], out, taps=TAPS, torque_of="drive"
        )
        self.step = self.actuators.physics_dt.require()
        self.bench = Bench(self.robot, self.data, self.data.tracks, self.step)
        torque = [t.torque[t.rows] for t in self.data.tracks]
        self.size, self.spread = rms(torque), float(np.std(np.concatenate(torque)))

    def torque(self, found: Sequence[Array]) -> float:
        """RMSE [N*m]."""
        return rms([part - t.torque[t.rows] for part, t in zip(found, self.data.tracks, strict=True)])

    def motion(self, drive: Callable[..., Array]) -> float:
        """RMSE of positions [rad]."""
        return rms([self.bench.rolled(self.bench.starts(), drive, None)])

    def network(self, manifest: str) -> tuple[float, float]:
        """Both, of a network."""
        law, _ = network_of(manifest, self.actuators.joints, self.bench.step)
        taps = self.data.taps if law.layers.recurrent else law.taps
        tracks = [dataclasses.replace(track, taps=taps) for track in self.data.tracks]
        bounds = [Bounds.of(actuator) for actuator in self.bench.actuators]
        found = [predicted(law, [t], bound)[0] for t, bound in zip(tracks, bounds, strict=True)]
        return self.torque(found), self.motion(network_drive(self.bench, law))

    def from_samples(self, count: int) -> float:
        """Torque RMSE of the virtual robot's own law where its play is told from so many samples [N*m].

        The encoder is at one end of the play as the joint moves, at first by the mean speed; then the joint goes on
        by its speeds, and takes the encoder along where it must.
        """
        half = 0.5 * self.play
        actuators = {a.joint: a for a in resolved("true")}
        found = []
        for t in self.data.tracks:
            actuator = actuators[t.joint]
            late = math.ceil((actuator.delay.nominal.require() if actuator.delay else 0.0) * RATE - 1e-9)
            rows = t.rows[t.rows >= count]
            speed = np.mean([t.velocity[rows - k] for k in range(count)], axis=0)
            q = t.position[rows - count + 1] + half * np.sign(speed)
            for k in range(count - 1, 0, -1):
                now = rows - k + 1
                q = q + 0.5 / RATE * (t.velocity[now - 1] + t.velocity[now])
                q = np.clip(q, t.position[now] - half, t.position[now] + half)
            law = baseline_laws(actuator)["dc_motor"]
            found.append(law.torque(t.command[rows - late], q, t.velocity[rows]) - t.torque[rows])
        return rms(found)

    def inferred(self, kind: str) -> float:
        """RMSE of torques that the model needs for the test's own motion, where joints slide [N*m]."""
        log = load_log(f"{kind}.npz")
        silent = dataset(self.actuators, [log], Collector(), taps=TAPS, measured=False)
        silent = inferred(silent, self.robot, [log], "fixed", Collector())
        found = []
        for known, told in zip(self.data.tracks, silent.tracks, strict=True):
            rows = np.intersect1d(known.rows, told.rows)
            if told.slack is not None:
                rows = rows[told.slack[rows] == 0.0]
            found.append(told.torque[rows] - known.torque[rows])
        return rms(found)

    def stribeck(self) -> float:
        """RMS of the virtual robot's friction beyond Coulomb's and viscous [N*m]."""
        (friction,) = {
            (a.friction_static.require(), a.friction_coulomb.require(), a.stribeck_velocity.require())
            for a in resolved("true")
            if a.friction_static is not None and a.stribeck_velocity is not None
        }
        static, coulomb, speed = friction
        return rms(
            [(static - coulomb) * np.exp(-((t.velocity[t.rows] / speed) ** 2)) for t in self.data.tracks]
        )

    def motor(self, name: str, late: Callable[[float], int] = round) -> tuple[float, float]:
        """Both, of a spec's DC motor, with its delay; in motion in whole steps, `late` of a broken number of them."""
        actuators = {a.joint: a for a in resolved(name)}
        mine = [actuators[track.joint] for track in self.data.tracks]
        laws = [baseline_laws(a)["dc_motor"] for a in mine]
        delay = [(a.delay.nominal.value or 0.0) if a.delay is not None else 0.0 for a in mine]
        bias = [a.encoder_bias.value or 0.0 for a in mine]
        found = []
        for law, wait, off, t in zip(laws, delay, bias, self.data.tracks, strict=True):
            # What has come when the row is read, before its own command is sent.
            sent = np.maximum(np.searchsorted(t.time, t.time[t.rows] - wait - 1e-9) - 1, 0)
            found.append(law.torque(t.command[sent], t.position[t.rows] - off, t.velocity[t.rows]))
        steps = [late(wait / self.step) for wait in delay]

        def drive(starts: Array, step: int, command: Array, q: Array, qd: Array) -> Array:
            # Each acts on what the encoder reads, by its own bias: the bench has the fitted one.
            parts = [
                law.torque(self.bench.command[np.maximum(starts + step - k, 0), j], q[:, j] - off, qd[:, j])
                for j, (law, k, off) in enumerate(zip(laws, steps, bias, strict=True))
            ]
            return np.stack(parts, axis=1)

        return self.torque(found), self.motion(drive)


def trained(name: str, short: bool) -> tuple[float, float]:
    """Processor time and time [s] of a network's training, as its log has it where it is there already."""
    times = Path(f"nets/{name}.times")
    if times.exists():
        cpu, wall = json.loads(times.read_text("utf-8"))
        return cpu, wall
    size = ("--hidden", "16" if name == "lstm" else "32,32", "--epochs", "10") if short else ()
    # The last one is held out, and the jumps of targets are what no other log has.
    logs = [f"{kind}.npz" for kind in ("targets", *(kind for kind in EXPERIMENTS if kind != "targets"))]
    command = ("net", "train", "bench.yaml", *logs, "-o", f"nets/{name}")
    text, cpu, wall = run(*command, *KINDS[name], *size, "--force", "--output-format", "json")
    print(f"  {name}: {json.loads(text)['validation']['rmse']:.4g} held out", file=sys.stderr)
    times.write_text(json.dumps([cpu, wall]), "utf-8")
    return cpu, wall


def fitted() -> str:
    """Fit the robot's figures, unless they are there; how long it took."""
    times = Path("fit.times")
    if not times.exists():
        _, cpu, wall = run(
            "sysid", "fit", "spec.yaml", *(f"fit_{kind}.npz" for kind in FIT_KINDS), "-o", "fit.yaml"
        )
        times.write_text(json.dumps([cpu, wall]), "utf-8")
    cpu, wall = json.loads(times.read_text("utf-8"))
    found = {}
    for name, of in {"delay": "delay", "Coulomb": "friction_coulomb", "viscous": "friction_viscous"}.items():
        values = [getattr(joint, of) for joint in resolved("fitted")]
        figures = [(v.nominal if of == "delay" else v).require() for v in values]
        found[name] = f"{min(figures):.4g}…{max(figures):.4g}"
    return (
        f"`sysid fit` on {FIT:g} s each of {' and '.join(FIT_KINDS)} found a delay of {found['delay']} s, Coulomb "
        f"friction of {found['Coulomb']} N·m and viscous of {found['viscous']} N·m·s/rad, in {cpu:.0f} s of a "
        "processor."
    )


def judged(kind: str, play: float, kinds: Sequence[str], ratios: dict[str, list[float]]) -> list[str]:
    """A test's part of the page."""
    bed = Test(kind, play)
    rows = {
        "DC motor of the spec": bed.motor("spec"),
        "fitted DC motor, with delay": bed.motor("fitted"),
        "the robot's own law, delay in whole steps": bed.motor("true", math.ceil),
    }
    nets = {name: bed.network(f"nets/{name}.json") for name in kinds}
    for name, both in nets.items():
        rows[f"network, {name}"] = both
    motor, fit, network = rows["DC motor of the spec"], rows["fitted DC motor, with delay"], nets["measured"]
    lines = [
        "",
        f"### Test: {kind}",
        "",
        f"RMS torque {bed.size:.3g} N·m.",
        "",
        f"| | RMSE [N·m] | R² | position RMSE of {HORIZON:g} s in MuJoCo [mrad] |",
        "|---|---:|---:|---:|",
    ]
    for name, (torque, motion) in rows.items():
        r2 = 1.0 - (torque / bed.spread) ** 2
        lines.append(f"| {name} | {torque:.3g} | {r2:.4f} | {motion * 1e3:.3g} |")
    told = {count: bed.from_samples(count) for count in SAMPLES}
    lines += [
        "",
        "The own law sees the joint behind its play. Where it tells the play from a history, by its own rule, it errs "
        "by "
        + ", ".join(f"{error:.3g} from {count}" for count, error in told.items())
        + f" samples [N·m]: {told[6] / fit[0]:.2f} of the fitted DC motor's from 6. What is inferred from this test's "
        f"own motion differs from its torque by {bed.inferred(kind):.3g} N·m where joints slide; the Stribeck part of "
        f"the friction, which MuJoCo's model has not, is {bed.stribeck():.3g} N·m.",
    ]
    ratios["of the DC motor's"].append(network[0] / motor[0])
    ratios["of the fitted DC motor's"].append(network[0] / fit[0])
    ratios["closed loop, of the DC motor's"].append(network[1] / motor[1])
    for k, what in enumerate(("torque", "closed loop")):
        inferred = nets.get("inferred", (math.nan, math.nan))
        ratios[f"inferred, of the measured: {what}"].append(inferred[k] / network[k])
    return lines


def measured(options: argparse.Namespace, where: Path) -> tuple[str, bool]:
    """All, as a page, and whether every goal is met by the robot with the published play."""
    specs(options.known)
    commands(options.short)
    moved()
    seconds = {kind: float(load_log(f"{kind}.npz").time[-1]) for kind in EXPERIMENTS}
    lines = [
        "# Networks of virtual robots",
        "",
        f"Written by `python benchmarks/learn.py --{'short' if options.short else 'write'}"
        f"{' --known' * options.known}`. robots/a1.yaml, 12 joints, {RATE:g} Hz, {sum(seconds.values()):.0f} s to "
        f"train on, all joints at once: {', '.join(f'{s:.0f} s of {kind}' for kind, s in seconds.items())}. Those of "
        f"`sysid design` are {PART:g} s again and again, the joints moved against each other in time; the targets are "
        f"its multisine as a policy would send it, held for {HOLD * 1e3:g} ms, with noise of {JUMPS:g} rad. Tests, "
        f"{PART:g} s each: random sines, and the targets of a gait at 50 Hz with noise. The torque is the drive's; "
        "networks have "
        f"{'12-32-32-1' if options.short else '12-128-128-1'}. "
        + (
            "Friction of the bench, and delay of the fitted DC motor, are the robot's own, as the best of fits would "
            "have them, but for Stribeck."
            if options.known
            else "Friction and armature of the bench, and the fitted DC motor, are those of one `sysid fit`."
        ),
        "",
        f"Python {platform.python_version()}, numpy {np.__version__}, {os.cpu_count()} cores, load "
        f"{os.getloadavg()[0]:.1f}.",
    ]
    ratios: dict[str, list[float]] = {name: [] for name in GOALS}
    for robot, play in ROBOTS.items():
        folder = where / robot
        folder.mkdir(exist_ok=True)
        read(folder, play)
        os.chdir(folder)
        specs(options.known)
        lines += ["", f"## {play:g}° of play"]
        if robot == "published" and not options.known:
            lines += ["", fitted()]
        elif not options.known:
            shutil.copy(where / "published" / "fit.yaml", ".")
        kinds = [name for name in KINDS if name in TRAINED[robot]]
        times = {name: trained(name, options.short) for name in kinds}
        for kind in TESTS:
            lines += judged(kind, play, kinds, ratios)
        lines += ["", "| training | processor [s] | time [s] |", "|---|---:|---:|"]
        lines += [f"| {name} | {cpu:.0f} | {wall:.0f} |" for name, (cpu, wall) in times.items()]
        ratios["training [s]"].append(times["measured"][0])
        os.chdir(where)
    heads = [f"{play:g}°, {kind}" for play in ROBOTS.values() for kind in TESTS]
    lines += ["", "## Goals", "", f"| network's RMSE | {' | '.join(heads)} | goal |"]
    lines.append("|---|" + "---:|" * (len(heads) + 1))
    for name, goal in GOALS.items():
        if name != "training [s]":
            shown = " | ".join("" if math.isnan(ratio) else f"{ratio:.2f}" for ratio in ratios[name])
            lines.append(f"| {name} | {shown} | ≤ {goal:g} |")
    lines += [
        "",
        f"Training: {' and '.join(f'{t:.0f}' for t in ratios['training [s]'])} s of a processor for the measured one, "
        f"with reading, checks and writing; goal {GOALS['training [s]']:g} s.",
    ]
    met = all(r <= goal for name, goal in GOALS.items() for r in ratios[name][: len(TESTS)])
    return "\n".join(lines) + "\n", met


def main() -> int:
    """Print the page; write it where asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--short", action="store_true")
    parser.add_argument("--known", action="store_true", help="no fit: the robot's own figures in its place")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--hard", action="store_true", help="the section on drives at their limits alone")
    parser.add_argument("--logs", help="folder of what is kept")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        where = Path(options.logs or folder).resolve()
        where.mkdir(parents=True, exist_ok=True)
        os.chdir(where)
        before, heading, by_hand = PAGE.read_text("utf-8").partition(MISSED)
        page, met = before.partition(LAST)[0], True
        if not options.hard:
            page, met = measured(options, where)
            os.chdir(where)
        page = f"{page.rstrip()}\n\n{hard(where)}\n{heading}{by_hand}"
    print(page)
    if options.write:
        PAGE.write_text(page, "utf-8")
    return int(not met)


if __name__ == "__main__":
    raise SystemExit(main())
