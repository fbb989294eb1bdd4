"""How near `actspec sysid fit` comes to the figures of virtual joints, and whether its intervals hold: sysid.md.

    python benchmarks/sysid.py                    # 100 joints, 10 legs, peers; writes the page
    python benchmarks/sysid.py --joints 8         # a short run, printed, and nothing is written
    python benchmarks/sysid.py --case lab --joints 8 --jobs 2

The joints are those of tests/sysid/truth.py, the leg that of sysid_leg.py beside this: programs of their own, in steps
of 0.1 ms. Times are those of one processor.
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import argparse  # noqa: E402
import math  # noqa: E402
import platform  # noqa: E402
import sys  # noqa: E402
import tempfile  # noqa: E402
import time as clock  # noqa: E402
from collections.abc import Iterable, Sequence  # noqa: E402
from concurrent.futures import ProcessPoolExecutor  # noqa: E402
from dataclasses import dataclass  # noqa: E402
from pathlib import Path  # noqa: E402
from typing import Any  # noqa: E402

import numpy as np  # noqa: E402

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "benchmarks")]

from sysid_leg import LEG_JOINTS, leg_model, leg_truth  # noqa: E402
from sysid_peers import mujoco_sysid, textbook  # noqa: E402

from actspec import api  # noqa: E402
from actspec.diagnostics import ActspecError  # noqa: E402
from actspec.logs import JointLog, Log, Sidecar  # noqa: E402
from actspec.sysid.design import design  # noqa: E402
from actspec.sysid.fit import fit_logs  # noqa: E402
from actspec.sysid.work import FitOptions  # noqa: E402
from tests.sysid.truth import truth  # noqa: E402

Array = np.ndarray[Any, Any]

PAGE = Path(__file__).with_suffix(".md")
RATE = 500.0
KINDS = ("chirp", "multisine", "steps")
"""Experiments of a joint, 20 s each."""
PART = 20.0
RANGES = {
    "kp": (10.0, 200.0), "kd": (0.2, 5.0), "armature": (0.002, 0.05), "link": (0.01, 0.3), "tc": (0.05, 1.0),
    "b": (0.01, 0.3), "delay": (0.0, 0.015), "bias": (-0.02, 0.02), "mgl": (0.6, 3.0),
}  # fmt: skip
"""Least and largest; logarithmic but for delay and bias."""
DAMPING = (0.1, 2.0)
"""Damping ratios of what a leg has; others are drawn again."""
LIMIT, SPEED = 40.0, 20.0
"""Effort limit [N*m] and velocity limit [rad/s] of all."""
NOISE = {"position": 5e-4, "velocity": 0.05, "torque": 0.02}
"""[rad], [rad/s], share of the torque's root mean square."""
OFF = 0.3
"""Standard deviation of the logarithm of a spec's error, of each figure that is fitted."""
BITS, LOW_PASS, JITTER = 14, 40.0, 0.15
"""Of a lab log: encoder, cutoff of the velocity's low-pass [Hz], standard deviation of a row's time in rows."""

FIGURES = {
    "kp": "kp",
    "kd": "kd",
    "armature": "armature",
    "friction.coulomb": "tc",
    "friction.viscous": "b",
    "delay": "delay",
    "encoder_bias": "bias",
}
"""Field to its name in the truth."""
ABSOLUTE = {"delay": ("ms", 1e3), "encoder_bias": ("mrad", 1e3)}
"""Fields whose error is no share of the figure."""


@dataclass(frozen=True, slots=True)
class Case:
    """What is logged, and what of it should come out.

    Attributes:
        name: For the command line.
        words: For the page.
        goals: Field to its median error: a share of the figure, or SI.
        hold: Least share of the intervals that should hold.
    """

    name: str
    words: str
    goals: dict[str, float]
    hold: float


_FRICTION = {"armature": 2e-3, "friction.coulomb": 2e-3}
_OTHERS = {"friction.viscous": 15e-3, "delay": 2e-5, "encoder_bias": 5e-4}
CASES = (
    Case("torque", "torque logged", {"kp": 5e-4, "kd": 5e-4, **_FRICTION, **_OTHERS}, 0.88),
    Case("stated", "no torque, gains stated", {**_FRICTION, **_OTHERS}, 0.88),
    Case(
        "free",
        "no torque, gains free, gravity",
        {"kp": 5e-3, "armature": 5e-3, "kd+friction.viscous": 5e-3, "delay": 2e-5, "encoder_bias": 5e-4},
        0.88,
    ),
    Case(
        "lab",
        "torque logged; 14 bit, velocity at 40 Hz, jitter 15 %",
        {"kp": 1e-3, "armature": 5e-3, "friction.coulomb": 1e-2},
        0.8,
    ),
    Case(
        "leg",
        "torque logged; three joints at once, 20 s",
        {"kp": 3e-3, "armature": 1e-2, "friction.viscous": 4e-2, "delay": 1e-4},
        0.88,
    ),
)


@dataclass(frozen=True, slots=True)
class Bench:
    """A joint, or a leg of them.

    Attributes:
        model: MJCF.
        spec: YAML, with figures that are off.
        joints: Names.
        true: Joint to its figures by the truth's names.
    """

    model: str
    spec: str
    joints: tuple[str, ...]
    true: dict[str, dict[str, float]]


@dataclass(frozen=True, slots=True)
class Task:
    """One fit."""

    case: str
    bench: Bench
    time: Array
    columns: dict[str, dict[str, Array]]
    stated: bool
    free: frozenset[str]


OUTLIER = 3.0
"""Error in halves of its interval from which on a figure is named."""
SLOW = 10.0
"""Time of a joint's fit from which on it is named [s]."""


@dataclass(frozen=True, slots=True)
class Figure:
    """A figure that came out; value None: it was not told. `number` is that of the joint, or of its leg, from 1."""

    case: str
    number: int
    joint: str
    field: str
    true: float
    value: float | None
    low: float
    high: float
    seconds: float

    @property
    def halves(self) -> float:
        """Its error in halves of the interval, on the truth's side."""
        assert self.value is not None
        half = self.high - self.value if self.true > self.value else self.value - self.low
        return abs(self.value - self.true) / max(half, 1e-300)

    @property
    def owner(self) -> str:
        return f"leg {self.number}, {self.joint}" if self.case == "leg" else f"joint {self.number}"


def drawn(count: int, seed: int) -> dict[str, Array]:
    """Figures of so many joints, by the truth's names, `link` and `armature` apart."""
    random = np.random.default_rng(seed)
    rows: list[dict[str, float]] = []
    while len(rows) < count:
        row = {}
        for name, (low, high) in RANGES.items():
            even = name in ("delay", "bias")
            row[name] = (
                random.uniform(low, high) if even else math.exp(random.uniform(math.log(low), math.log(high)))
            )
        inertia = row["link"] + row["armature"]
        if DAMPING[0] < (row["kd"] + row["b"]) / (2.0 * math.sqrt(row["kp"] * inertia)) < DAMPING[1]:
            rows.append({**row, "J": inertia, "limit": LIMIT})
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def spec_text(names: Sequence[str], true: Sequence[dict[str, float]], random: np.random.Generator) -> str:
    """A spec whose figures are off."""
    lines = ["actspec: 1", "robot: {name: bench, model: bench.xml}", "actuators:"]
    for name, one in zip(names, true, strict=True):
        guess = {
            k: one[k] * math.exp(OFF * random.standard_normal()) for k in ("kp", "kd", "armature", "tc", "b")
        }
        lines += [
            f"  {name}:",
            f"    joints: [{name}]",
            "    level: ideal_pd",
            f"    kp: {guess['kp']:.6g} N*m/rad",
            f"    kd: {guess['kd']:.6g} N*m*s/rad",
            f"    effort_limit: {LIMIT:g} N*m",
            f"    velocity_limit: {SPEED:g} rad/s",
            f"    armature: {guess['armature']:.6g} kg*m^2",
            f"    friction: {{coulomb: {guess['tc']:.6g} N*m, viscous: {guess['b']:.6g} N*m*s/rad}}",
            "    delay: 4 ms",
        ]
    return "\n".join(lines) + "\n"


def bench_of(one: dict[str, float], seed: int) -> Bench:
    """A pendulum of this inertia and gravity; a stiff joint has less range, as its limit would be reached at once."""
    length = 0.5 * one["link"] * 9.81 / one["mgl"]
    mass, own = one["mgl"] / (9.81 * length), 0.5 * one["link"]
    reach = min(max(LIMIT / one["kp"], 0.3), 1.5)
    model = f"""<mujoco model="bench">
  <compiler angle="radian"/>
  <worldbody>
    <body name="arm">
      <joint name="hip" axis="0 1 0" range="{-reach!r} {reach!r}"/>
      <inertial pos="0 0 {-length!r}" mass="{mass!r}" diaginertia="{own!r} {own!r} {own!r}"/>
    </body>
  </worldbody>
</mujoco>
"""
    return Bench(model, spec_text(["hip"], [one], np.random.default_rng(seed)), ("hip",), {"hip": one})


def loaded(bench: Bench, folder: str) -> tuple[Any, Any]:
    """Spec and robot, resolved."""
    Path(folder, "bench.xml").write_text(bench.model)
    Path(folder, "spec.yaml").write_text(bench.spec)
    spec = api.load(Path(folder, "spec.yaml"))
    robot = api.load_robot(spec)
    return api.resolve(spec, robot), robot


def commanded(bench: Bench, kinds: Iterable[str], together: bool) -> Array:
    """Commands as `actspec sysid design` makes them, one experiment after the other; shape (n_row, n_joint)."""
    parts = []
    with tempfile.TemporaryDirectory() as folder:
        actuators, robot = loaded(bench, folder)
        for kind in kinds:
            made = design(
                robot, actuators.joints, kind, path="log", duration=PART, rate=RATE, together=together, seed=1
            )
            parts.append(np.stack([_given(made.log.joints[name].command) for name in bench.joints], axis=1))
    found: Array = np.concatenate(parts)
    return found


def _given(values: Array | None) -> Array:
    assert values is not None
    return values


def sensed(read: tuple[Array, ...], random: np.random.Generator, bits: int = 0) -> dict[str, Array]:
    """What sensors make of a joint."""
    q, v, torque = read
    q = q + NOISE["position"] * random.standard_normal(len(q))
    if bits:
        one = 2.0 * math.pi / 2**bits
        q = one * np.round(q / one)
    rms = math.sqrt(float(np.mean(torque**2)))
    return {
        "position": q,
        "velocity": v + NOISE["velocity"] * random.standard_normal(len(q)),
        "torque": torque + NOISE["torque"] * rms * random.standard_normal(len(q)),
    }


def fitted(task: Task, number: int) -> list[Figure]:
    """One fit, of the joint or leg with this number, and what came out."""
    sidecar = Sidecar()
    if task.stated:
        gains = {name: {"kp": one["kp"], "kd": one["kd"]} for name, one in task.bench.true.items()}
        sidecar = Sidecar.model_validate({"gains": gains})
    joints = {name: JointLog(name, False, **columns) for name, columns in task.columns.items()}
    log = Log("log.csv", "0" * 64, task.time, joints, sidecar)
    with tempfile.TemporaryDirectory() as folder:
        actuators, robot = loaded(task.bench, folder)
        begun = clock.process_time()
        try:
            found = fit_logs(actuators, robot, [log], FitOptions(free=task.free))
        except ActspecError as err:
            print(f"{task.case}: {err.diagnostics[0]}", file=sys.stderr)
            return []
        seconds = (clock.process_time() - begun) / len(task.bench.joints)
    figures = []
    for joint in found.joints:
        true = task.bench.true[joint.joint]
        for parameter in joint.parameters:
            if parameter.state.value == "held" or parameter.field not in FIGURES:
                continue
            nan = math.nan
            low, high = parameter.low, parameter.high
            figures.append(
                Figure(
                    task.case, number, joint.joint, parameter.field, true[FIGURES[parameter.field]], parameter.value,
                    nan if low is None else low, nan if high is None else high, seconds,
                )
            )  # fmt: skip
        for both in joint.combinations:
            if both.name == "kd+friction.viscous":
                wide = 1.96 * both.std
                figures.append(
                    Figure(
                        task.case, number, joint.joint, both.name, true["kd"] + true["b"], both.value,
                        both.value - wide, both.value + wide, seconds,
                    )
                )  # fmt: skip
    return figures


def benches(count: int, seed: int) -> tuple[list[Bench], dict[str, Array]]:
    """Joints on a bench, and their figures together."""
    figures = drawn(count, seed)
    ones = [{name: float(values[i]) for name, values in figures.items()} for i in range(count)]
    return [bench_of(one, seed + i) for i, one in enumerate(ones)], figures


def bench_tasks(cases: Sequence[str], count: int, seed: int, pool: ProcessPoolExecutor) -> list[Task]:
    """Fits of single joints: the logs are made here, all joints at once."""
    made, figures = benches(count, seed)
    command = np.concatenate(list(pool.map(_bench_command, made)), axis=1)
    tasks: list[Task] = []
    even = np.arange(len(command)) / RATE
    random = np.random.default_rng(seed + 1)
    late = even + JITTER / RATE * np.clip(random.standard_normal(len(even)), -3.0, 3.0)
    plain = [case for case in cases if case not in ("lab", "leg")]
    runs = {"plain": (even, math.inf, 0)} if plain else {}
    runs |= {"lab": (late, LOW_PASS, BITS)} if "lab" in cases else {}
    for name, (time, low_pass, bits) in runs.items():
        print(f"{count} joints, {name}: moving", file=sys.stderr, flush=True)
        read = truth(figures, command, time, low_pass=low_pass)
        for i, bench in enumerate(made):
            own = (read[0][:, i], read[1][:, i], read[2][:, i])
            columns = {"command": command[:, i], **sensed(own, np.random.default_rng([seed, i]), bits)}
            tasks += [_task(case, bench, time, columns) for case in (plain if name == "plain" else ["lab"])]
    return tasks


def _bench_command(bench: Bench) -> Array:
    return commanded(bench, KINDS, together=False)


def _task(case: str, bench: Bench, time: Array, columns: dict[str, Array]) -> Task:
    kept = {name: values for name, values in columns.items() if name != "torque" or case in ("torque", "lab")}
    free = frozenset({"kp", "kd"}) if case == "free" else frozenset[str]()
    return Task(case, bench, time, {"hip": kept}, case == "stated", free)


def leg_task(number: int, seed: int) -> Task:
    """A leg whose joints move together."""
    random = np.random.default_rng([seed, number])
    figures = drawn(len(LEG_JOINTS), int(random.integers(2**31)))
    model = leg_model(np.array([0.7, 1.0, 0.25]) * np.exp(0.2 * random.standard_normal(3)))
    ones = [{k: float(v[i]) for k, v in figures.items()} for i in range(len(LEG_JOINTS))]
    spec = spec_text(LEG_JOINTS, ones, random)
    bench = Bench(model, spec, LEG_JOINTS, dict(zip(LEG_JOINTS, ones, strict=True)))
    command = commanded(bench, ("multisine",), together=True)
    read = leg_truth(model, figures, command, 1.0 / RATE)
    columns = {
        name: {"command": command[:, i], **sensed((read[0][:, i], read[1][:, i], read[2][:, i]), random)}
        for i, name in enumerate(LEG_JOINTS)
    }
    return Task("leg", bench, np.arange(len(command)) / RATE, columns, False, frozenset())


@dataclass(frozen=True, slots=True)
class Line:
    """What came of one field in one case.

    Attributes:
        field: Its name.
        goal: Median error that is wanted; None: none is stated.
        told: Figures that came out.
        asked: Of so many.
        median: Error, a share of the figure or SI.
        within: Share of those told that are within five times the goal.
        hold: Share of their intervals that hold.
        worst: Largest error, in halves of the interval.
    """

    field: str
    goal: float | None
    told: int
    asked: int
    median: float
    within: float
    hold: float
    worst: float


def judged(case: Case, figures: Sequence[Figure]) -> list[Line]:
    """A case's lines, by field."""
    lines = []
    for field in dict.fromkeys(figure.field for figure in figures):
        mine = [figure for figure in figures if figure.field == field]
        told = [figure for figure in mine if figure.value is not None]
        if not told:
            continue
        value, true = np.array([f.value for f in told], dtype=float), np.array([f.true for f in told])
        low, high = np.array([f.low for f in told]), np.array([f.high for f in told])
        error = np.abs(value - true) / (1.0 if field in ABSOLUTE else np.abs(true))
        goal = case.goals.get(field)
        lines.append(
            Line(
                field,
                goal,
                len(told),
                len(mine),
                float(np.median(error)),
                math.nan if goal is None else float(np.mean(error <= 5 * goal)),
                float(np.mean((low <= true) & (true <= high))),
                float(np.max([figure.halves for figure in told])),
            )
        )
    return lines


def table(case: Case, figures: Sequence[Figure]) -> list[str]:
    """A case as a table of the page."""
    seconds = [figure.seconds for figure in figures]
    joints = len({f.owner for f in figures})
    rows = judged(case, figures)
    held = [
        f.low <= f.true <= f.high
        for f in figures
        if f.value is not None and not math.isnan(f.low)
    ]  # fmt: skip
    return [
        f"## {case.words[0].upper()}{case.words[1:]}",
        "",
        f"{joints} joints, {np.median(seconds):.1f} s of one processor a joint, at most {max(seconds):.1f} s; "
        f"{np.mean(held):.0%} of all intervals hold (goal {case.hold:.0%}).",
        "",
        "| | told | median error | goal | within 5 × goal | intervals that hold | worst error, in half intervals |",
        "|---|---:|---:|---:|---:|---:|---:|",
        *(
            f"| {line.field} | {line.told} of {line.asked} | {_error(line.field, line.median)} "
            f"| {'' if line.goal is None else _error(line.field, line.goal)} "
            f"| {'' if line.goal is None else f'{line.within:.0%}'} | {line.hold:.0%} | {line.worst:.1f} |"
            for line in rows
        ),
        "",
        *_named(figures),
    ]


def _named(figures: Sequence[Figure]) -> list[str]:
    """Which joints to look at: far off, or slow."""
    off = [
        f"{f.owner}: {f.field} ({f.halves:.1f})"
        for f in figures
        if f.value is not None and f.halves > OUTLIER
    ]
    slow = {f.owner: f.seconds for f in figures if f.seconds > SLOW}
    late = [f"{owner} ({seconds:.1f} s)" for owner, seconds in slow.items()]
    lines = [(f"Off by more than {OUTLIER:g} half intervals", off), (f"Over {SLOW:g} s a joint", late)]
    return [line for words, named in lines if named for line in (f"{words}: {'; '.join(named)}.", "")]


def _error(field: str, value: float) -> str:
    if field in ABSOLUTE:
        unit, factor = ABSOLUTE[field]
        return f"{value * factor:.2g} {unit}"
    return f"{value * 100:.2g} %"


def main() -> int:
    """Run, print, and write the page where all of it was run."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--joints", type=int, default=0, help="single joints; default 100")
    parser.add_argument(
        "--legs", type=int, default=-1, help="legs of three joints; default a tenth of the joints"
    )
    parser.add_argument(
        "--case", action="append", choices=[case.name for case in CASES], help="only this one"
    )
    parser.add_argument("--peers", type=int, default=-1, help="joints that the peers fit; default 4")
    parser.add_argument(
        "--python",
        default=sys.executable,
        help="interpreter with mujoco[sysid], for the peer; default this one",
    )
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes; default one a core")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--keep", type=Path, help="file of the virtual logs: used if it is there, else written"
    )
    arguments = parser.parse_args()
    count = arguments.joints or 100
    legs = arguments.legs if arguments.legs >= 0 else max(count // 10, 1)
    cases = arguments.case or [case.name for case in CASES]
    begun = clock.time()
    with ProcessPoolExecutor(arguments.jobs) as pool:
        tasks = _tasks(arguments, cases, count, legs, pool)
        figures: dict[str, list[Figure]] = {case.name: [] for case in CASES}
        results = []
        numbers = [[other.case for other in tasks[:i]].count(task.case) + 1 for i, task in enumerate(tasks)]
        for done, found in enumerate(pool.map(fitted, tasks, numbers), 1):
            results.append(found)
            for figure in found:
                figures[figure.case].append(figure)
            print(f"\r{done} of {len(tasks)} fits", end="", file=sys.stderr, flush=True)
        peers = arguments.peers if arguments.peers >= 0 else 4
        peer_tasks = [task for task in tasks if task.case == "torque"][:peers]
        asked = list(pool.map(peered, peer_tasks, [arguments.python] * len(peer_tasks)))
    text = [*_head(arguments, count, legs, cases)]
    for case in CASES:
        if figures[case.name]:
            text += table(case, figures[case.name])
    if peer_tasks:
        ours = [found for task, found in zip(tasks, results, strict=True) if task.case == "torque"]
        text += peer_table(peer_tasks, asked, ours)
    page = "\n".join(text).rstrip() + "\n"
    if arguments.joints or arguments.case:
        print(page)
    else:
        PAGE.write_text(page, encoding="utf-8")
    print(f"\r{clock.time() - begun:.0f} s", file=sys.stderr)
    return 0


def _head(arguments: argparse.Namespace, count: int, legs: int, cases: Sequence[str]) -> list[str]:
    import mujoco
    import scipy

    versions = f"Python {platform.python_version()}, numpy {np.__version__}, scipy {scipy.__version__}"
    kinds = f"{', '.join(KINDS)}, {PART:g} s each"
    ranges = ", ".join(f"{name} {low:g} to {high:g}" for name, (low, high) in RANGES.items())
    return [
        "# Identification of virtual joints",
        "",
        "Written by `python benchmarks/sysid.py`. The joints, and the legs of three, are moved by programs of their "
        "own in steps of 0.1 ms with exact stick-slip (tests/sysid/truth.py, sysid_leg.py). Commands are those of "
        f"`actspec sysid design`: {kinds}, {RATE:g} Hz. Noise: 0.5 mrad, 0.05 rad/s, 2 % of the torque's root mean "
        "square. The specs with which a fit begins are off by 30 % (standard deviation of the logarithm).",
        "",
        f"{count} joints, {legs if 'leg' in cases else 0} legs. {versions}, mujoco {mujoco.__version__}. "
        f"Figures drawn, in SI: {ranges}; damping ratio "
        f"{DAMPING[0]:g} to {DAMPING[1]:g}. Seed {arguments.seed}.",
        "",
        "Errors are medians, as a share of the figure itself; times are processor times of one fit over its joints. "
        "*Told*: the fit gave a value; a figure that a log cannot tell has none.",
        "",
    ]


def peered(task: Task, python: str) -> tuple[dict[str, Any] | str, dict[str, float]]:
    """What `mujoco.sysid` and the textbook make of a joint's log."""
    with tempfile.TemporaryDirectory() as folder:
        joint = loaded(task.bench, folder)[0].joints[0]
    start = {
        "kp": joint.kp, "kd": joint.kd, "armature": joint.armature, "tc": joint.friction_coulomb,
        "b": joint.friction_viscous,
    }  # fmt: skip
    columns = task.columns["hip"]
    figures = {name: float(quantity.value) for name, quantity in start.items()} | {
        "delay": 0.004,
        "bias": 0.0,
    }
    theirs = mujoco_sysid(python, task.bench.model, columns, task.time, LIMIT, figures)
    last = round(PART * RATE)
    return theirs, textbook(columns["command"][-last:], columns["position"][-last:], task.time[-last:])


def peer_table(
    tasks: Sequence[Task],
    asked: Sequence[tuple[dict[str, Any] | str, dict[str, float]]],
    ours: Sequence[Sequence[Figure]],
) -> list[str]:
    """The peers on the same logs as the first joints with torque."""
    lines = [
        "## Peers",
        "",
        f"The first {len(tasks)} logs with torque. `mujoco.sysid` as its own tests use it: a position drive of MuJoCo "
        "at the log's step, implicitfast, all seven figures free, from the same spec; delay by a shifted prediction, "
        "one rollout over the log. The textbook: natural frequency 1.8 over the rise time of the steps, an inertia of "
        "0.01 kg·m² as known.",
        "",
        "| joint | | truth | actspec, error | mujoco.sysid, error | its 95 % interval | textbook, error |",
        "|---:|---|---:|---:|---:|---:|---:|",
    ]
    times = []
    reasons = {theirs for theirs, _ in asked if isinstance(theirs, str)}
    for number, (task, (theirs, book), own_figures) in enumerate(zip(tasks, asked, ours, strict=False), 1):
        true = task.bench.true["hip"]
        mine = {f.field: f for f in own_figures}
        if isinstance(theirs, dict):
            times.append(theirs["seconds"])
        for field, name in FIGURES.items():
            own = mine.get(field)
            cells = ["left out", ""]
            if isinstance(theirs, dict):
                cells = [
                    _off(field, theirs["values"][name], true[name]),
                    f"±{_off(field, true[name] + theirs['half'][name], true[name])}",
                ]
            first = "" if own is None or own.value is None else _off(field, own.value, true[name])
            other = _off(field, book[name], true[name]) if name in book else ""
            lines.append(
                f"| {number} | {field} | {true[name]:.4g} | {first} | {cells[0]} | {cells[1]} | {other} |"
            )
    if times:
        lines += ["", f"`mujoco.sysid` took {np.median(times):.0f} s of a processor a joint (median)."]
    lines += [f"\n`mujoco.sysid` left out: {reason}" for reason in sorted(reasons)]
    return lines


def _off(field: str, value: float, true: float) -> str:
    if math.isnan(value):
        return "none"
    return _error(field, abs(value - true) / (1.0 if field in ABSOLUTE else abs(true)))


def _tasks(
    arguments: argparse.Namespace, cases: Sequence[str], count: int, legs: int, pool: ProcessPoolExecutor
) -> list[Task]:
    keep: Path | None = arguments.keep
    if keep is not None and keep.exists():
        import pickle

        found: list[Task] = [task for task in pickle.loads(keep.read_bytes()) if task.case in cases]
        return found
    tasks = []
    later = (
        [pool.submit(leg_task, number, arguments.seed) for number in range(legs)] if "leg" in cases else []
    )
    if set(cases) - {"leg"}:
        tasks = bench_tasks(cases, count, arguments.seed, pool)
    tasks += [task.result() for task in later]
    if keep is not None:
        import pickle

        keep.write_bytes(pickle.dumps(tasks))
    return tasks


if __name__ == "__main__":
    sys.exit(main())
