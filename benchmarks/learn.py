"""How near networks from logs come to a drive, beside the spec's DC motor and a fitted one: learn.md.

    python benchmarks/learn.py --write            # 5 minutes of 12 joints; writes the page
    python benchmarks/learn.py --short            # a minute, small networks, printed
    python benchmarks/learn.py --known            # without the fit, the longest part
    python benchmarks/learn.py --logs DIR         # keeps logs, fit and networks there, and takes those that are there

All by the commands of docs/networks.md: experiments of `sysid design`, a virtual A1 of `sysid simulate`, `sysid fit`
for friction and armature of the bench, `net train`. Judged on random sines and on what a policy does: 50 Hz targets of
a gait with noise. Times are processor times where the machine is shared. Exit code 1: a goal is missed.
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
from actspec.learn.closed_loop import HORIZON, Bench, baseline_laws, law_drive, network_drive  # noqa: E402
from actspec.learn.evaluate import network_of, predicted  # noqa: E402
from actspec.learn.labels import inferred  # noqa: E402
from actspec.learn.recurrent import TAPS  # noqa: E402
from actspec.learn.windows import Dataset, dataset  # noqa: E402
from actspec.logs import JointLog, Log, Sidecar, load_log, write_log  # noqa: E402
from actspec.sysid.figures import Bounds  # noqa: E402

Array = np.ndarray[Any, Any]

PAGE = Path(__file__).with_suffix(".md")
RATE = 200.0
FIT_KINDS, FIT = ("steps", "multisine"), 6.0
"""What is fitted, the first part of each [s]."""
PART = 20.0
"""Of a designed experiment [s]."""
EXPERIMENTS = ("chirp", "steps", "multisine")
"""What is trained on, a third of the time each."""
TRUE = {
    "coulomb: {value: 0.2 N*m, source: a1_urdf}": "coulomb: 0.4 N*m\n      static: 0.6 N*m\n"
    "      stribeck_velocity: 0.2 rad/s",
    "viscous: {value: 0.01 N*m*s/rad, source: a1_urdf}": "viscous: 0.03 N*m*s/rad",
    "    # Not published for the A1, so": "    delay: 7 ms\n    # Not published for the A1, so",
}
"""What the virtual robot has in place of lines of its spec."""
FLAWS = {
    "--play": "0.5 deg",
    "--sag": "20 %",
    "--position-noise": "0.2 mrad",
    "--velocity-noise": "0.02 rad/s",
    "--torque-noise": "1 %",
}
FITTED = {
    "    kp: {value: 25 N*m/rad, source: isaaclab_a1}": "    identified: fit.yaml\n    kp: identified",
    "    kd: {value: 0.5 N*m*s/rad, source: isaaclab_a1}": "    kd: identified\n    delay: identified\n"
    "    encoder_bias: identified",
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
SAMPLES = (1, 6, 20, 100)
"""Of histories from which the play is told."""
GOALS = {
    "of the DC motor's": 0.2,
    "of the fitted DC motor's": 0.4,
    "closed loop, of the DC motor's": 0.25,
    "inferred, of the measured": 1.2,
    "training [s]": 120.0,
}


def run(*arguments: str) -> tuple[str, float, float]:
    """A command's output, its processor time and its time [s]; ends the program where it fails."""
    stream = io.StringIO()
    cpu, begun = clock.process_time(), clock.perf_counter()
    with contextlib.redirect_stdout(stream):
        code = actspec(list(arguments))
    cpu, begun = clock.process_time() - cpu, clock.perf_counter() - begun
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
    write_log(Log(path, "", np.arange(rows) / RATE, joints, Sidecar()))


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
    write_log(Log(path, "", np.arange(rows) / RATE, joints, log.sidecar))


def logs(times: int) -> None:
    """Those that are not there yet; `fit_` are the first part of what is trained on."""
    for k, kind in enumerate((*EXPERIMENTS, "random")):
        given = ("--experiment", kind, "--duration", f"{PART:g} s", "--rate", f"{RATE:g} Hz", "--together")
        if not Path(f"design_{kind}.npz").exists():
            run("sysid", "design", "spec.yaml", "-o", f"design_{kind}.npz", *given, "--seed", str(k))
        repeated(f"design_{kind}.npz", f"command_{kind}.npz", times if kind in EXPERIMENTS else 1, k)
    policy("command_policy.npz", load_log("command_random.npz"), PART, 3)
    for k, kind in enumerate((*EXPERIMENTS, "random", "policy")):
        if not Path(f"{kind}.npz").exists():
            flaws = [part for both in FLAWS.items() for part in both]
            more = ("--command", f"command_{kind}.npz", "-o", f"{kind}.npz", "--seed", str(10 + k))
            run("sysid", "simulate", "true.yaml", *more, *flaws)
        if kind in FIT_KINDS:
            log = load_log(f"{kind}.npz")
            keep = slice(0, round(FIT * RATE))
            names = ("command", "position", "velocity", "torque")
            joints = {
                name: dataclasses.replace(joint, **{n: getattr(joint, n)[keep] for n in names})
                for name, joint in log.joints.items()
            }
            write_log(dataclasses.replace(log, path=f"fit_{kind}.npz", time=log.time[keep], joints=joints))


def rms(parts: Sequence[Array]) -> float:
    """Root mean square of all."""
    return float(np.sqrt(np.mean(np.concatenate([part.ravel() for part in parts]) ** 2)))


class Test:
    """A log to judge on: torque errors at the rows that every law can tell, positions of rollouts."""

    def __init__(self, kind: str) -> None:
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
        law, _ = network_of(manifest, self.actuators.joints)
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
        half = 0.5 * math.radians(float(FLAWS["--play"].split()[0]))
        spec = api.load("true.yaml")
        actuators = {a.joint: a for a in api.resolve(spec, self.robot).joints}
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
        spec = api.load("true.yaml")
        (friction,) = {
            (a.friction_static.require(), a.friction_coulomb.require(), a.stribeck_velocity.require())
            for a in api.resolve(spec, self.robot).joints
            if a.friction_static is not None and a.stribeck_velocity is not None
        }
        static, coulomb, speed = friction
        return rms(
            [(static - coulomb) * np.exp(-((t.velocity[t.rows] / speed) ** 2)) for t in self.data.tracks]
        )

    def motor(self, name: str, late: Callable[[float], int] = round) -> tuple[float, float]:
        """Both, of a spec's DC motor, with its delay; in motion in whole steps, `late` of a broken number of them."""
        spec = api.load(f"{name}.yaml")
        actuators = {a.joint: a for a in api.resolve(spec, self.robot).joints}
        mine = [actuators[track.joint] for track in self.data.tracks]
        laws = [baseline_laws(a)["dc_motor"] for a in mine]
        delay = [(a.delay.nominal.value or 0.0) if a.delay is not None else 0.0 for a in mine]
        bias = [a.encoder_bias.value or 0.0 for a in mine]
        found = []
        for law, wait, off, t in zip(laws, delay, bias, self.data.tracks, strict=True):
            sent = t.rows
            if wait:
                # What has come when the row is read, before its own command is sent.
                sent = np.maximum(np.searchsorted(t.time, t.time[t.rows] - wait - 1e-9) - 1, 0)
            found.append(law.torque(t.command[sent], t.position[t.rows] - off, t.velocity[t.rows]))
        steps = [late(wait / self.step) for wait in delay]
        plain = law_drive(self.bench, laws)

        def drive(starts: Array, step: int, command: Array, q: Array, qd: Array) -> Array:
            rows = starts + step
            sent = [self.bench.command[np.maximum(rows - k, 0), j] for j, k in enumerate(steps)]
            return plain(starts, step, np.stack(sent, axis=1), q, qd)

        return self.torque(found), self.motion(drive)


def trained(name: str, short: bool) -> tuple[float, float]:
    """Processor time and time [s] of a network's training, as its log has it where it is there already."""
    times = Path(f"nets/{name}.times")
    if times.exists():
        cpu, wall = json.loads(times.read_text("utf-8"))
        return cpu, wall
    size = ("--hidden", "16" if name == "lstm" else "32,32", "--epochs", "10") if short else ()
    command = ("net", "train", "bench.yaml", *(f"{kind}.npz" for kind in EXPERIMENTS), "-o", f"nets/{name}")
    text, cpu, wall = run(*command, *KINDS[name], *size, "--force", "--output-format", "json")
    print(f"  {name}: {json.loads(text)['validation']['rmse']:.4g} held out", file=sys.stderr)
    times.write_text(json.dumps([cpu, wall]), "utf-8")
    return cpu, wall


def measured(options: argparse.Namespace) -> tuple[str, bool]:
    """All, as a page, and whether every goal is met."""
    times_over = 1 if options.short else 5
    seconds = len(EXPERIMENTS) * PART * times_over
    specs(options.known)
    logs(times_over)
    if not (options.known or Path("fit.yaml").exists()):
        run("sysid", "fit", "spec.yaml", *(f"fit_{kind}.npz" for kind in FIT_KINDS), "-o", "fit.yaml")
    times = {name: trained(name, options.short) for name in KINDS}
    lines = [
        "# Networks of a virtual robot",
        "",
        f"Written by `python benchmarks/learn.py --{'short' if options.short else 'write'}"
        f"{' --known' * options.known}`. robots/a1.yaml, "
        "12 joints, "
        f"{RATE:g} Hz, {seconds:g} s to train on: {', '.join(EXPERIMENTS)} of `sysid design`, all joints at once, "
        f"{PART:g} s repeated {times_over} times with the joints moved against each other in time. The "
        "virtual robot has 7 ms of delay, Coulomb friction of 0.4 N·m, static 0.6 (Stribeck, 0.2 rad/s), viscous "
        "0.03 N·m·s/rad; its sensors and motors "
        + ", ".join(f"{name[2:].replace('-', ' ')} {value}" for name, value in FLAWS.items())
        + ". The torque is the drive's. Tests: random sines, and 50 Hz targets of a gait with noise as a policy sends "
        f"them, {PART:g} s each. "
        + (
            "Friction of the bench, and delay of the fitted DC motor, are the robot's own, as the best of fits would "
            "have them, but for Stribeck."
            if options.known
            else "Friction and armature of the bench, and the fitted DC motor, are those of `sysid fit` on "
            f"{FIT:g} s each of {' and '.join(FIT_KINDS)}."
        ),
        "",
        f"Python {platform.python_version()}, numpy {np.__version__}, {os.cpu_count()} cores, load "
        f"{os.getloadavg()[0]:.1f}.",
    ]
    ratios: dict[str, list[float]] = {name: [] for name in GOALS}
    for kind in ("random", "policy"):
        bed = Test(kind)
        rows = {
            "DC motor of the spec": bed.motor("spec"),
            "fitted DC motor, with delay": bed.motor("fitted"),
            "network 12-128-128-1" if not options.short else "network 12-32-32-1": bed.network(
                "nets/measured.json"
            ),
            "the same, torque inferred": bed.network("nets/inferred.json"),
            "LSTM": bed.network("nets/lstm.json"),
            "the robot's own law, delay in whole steps": bed.motor("true", math.ceil),
        }
        motor, fitted, network, inferred, *_ = rows.values()
        lines += [
            "",
            f"## Test: {kind}",
            "",
            f"RMS torque {bed.size:.3g} N·m.",
            "",
            f"| | RMSE [N·m] | R² | position RMSE of {HORIZON:g} s in MuJoCo [mrad] |",
            "|---|---:|---:|---:|",
        ]
        for name, (torque, motion) in rows.items():
            r2 = 1.0 - (torque / bed.spread) ** 2
            lines.append(f"| {name} | {torque:.3g} | {r2:.4f} | {motion * 1e3:.3g} |")
        told = ", ".join(f"{bed.from_samples(k):.3g} from {k}" for k in SAMPLES)
        noise = 0.01 * float(FLAWS["--torque-noise"].split()[0]) * bed.size
        own = bed.inferred(kind)
        lines += [
            "",
            "The own law sees the joint behind its play. Where the play is told from a history, by its own rule, "
            f"the law errs by {told} samples [N·m]; {noise:.2g} of that is noise of the torque that it is judged by. "
            f"What is inferred from this test's own motion differs from its torque by {own:.3g} N·m where joints "
            "slide, and the Stribeck part of the friction, which MuJoCo's model has not, is "
            f"{bed.stribeck():.3g} N·m.",
        ]
        ratios["of the DC motor's"].append(network[0] / motor[0])
        ratios["of the fitted DC motor's"].append(network[0] / fitted[0])
        ratios["closed loop, of the DC motor's"].append(network[1] / motor[1])
        ratios["inferred, of the measured"].append(inferred[0] / network[0])
    ratios["training [s]"] = [times["measured"][0]]
    lines += ["", "## Goals", "", "| network's RMSE | random | policy | goal |", "|---|---:|---:|---:|"]
    for name, goal in GOALS.items():
        if name != "training [s]":
            one, other = ratios[name]
            lines.append(f"| {name} | {one:.2f} | {other:.2f} | ≤ {goal:g} |")
    lines += [
        "",
        "- Of the fitted DC motor's: nearly all of the error of both is the play, which six samples do not tell whole.",
        "- Closed loop: the model has no play. Nothing makes it stand where the encoder stood while the joint moved.",
        "- Inferred: the network holds what the model lacks, such as the Stribeck part of friction: against the "
        "measured torque, and for the motion. A policy's targets jump every 20 ms, and the torque with them between "
        "two rows: speeds tell such a jump over two to four rows. Motion is what such a network is for.",
    ]
    lines += ["", "| training | processor [s] | time [s] |", "|---|---:|---:|"]
    for name, (cpu, wall) in times.items():
        lines.append(f"| {name} | {cpu:.0f} | {wall:.0f} |")
    lines += [
        "",
        f"With reading, checks and writing. Goal: {GOALS['training [s]']:g} s of the first on 2 cores.",
    ]
    met = all(value <= goal for name, goal in GOALS.items() for value in ratios[name])
    return "\n".join(lines) + "\n", met


def main() -> int:
    """Print the page; write it where asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--short", action="store_true")
    parser.add_argument("--known", action="store_true", help="no fit: the robot's own figures in its place")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--logs", help="folder of what is kept")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        where = Path(options.logs or folder).resolve()
        where.mkdir(parents=True, exist_ok=True)
        os.chdir(where)
        page, met = measured(options)
    print(page)
    if options.write:
        PAGE.write_text(page, "utf-8")
    return int(not met)


if __name__ == "__main__":
    raise SystemExit(main())
