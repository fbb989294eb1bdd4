"""Any spec of one to three groups, its module read back, and what each class loses, once more in numpy.

The laws are those of the design and each class's own formula; nothing of `actspec.targets.kit.sizes` is in it.
"""

from __future__ import annotations

import ast
import json
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

from actspec.ir import ActuatorSet
from actspec.resolution import resolve
from actspec.robot.load import listed_robot
from actspec.robot.view import RobotView
from actspec.spec.document import document_from_text
from actspec.spec.validate import validate
from actspec.targets.base import Approximation, Emission
from actspec.targets.choose import emitter
from tests.compiling import target_options
from tests.fitting import drawn_numbers

Array = NDArray[np.float64]

STEP = 0.005
NAMES = (
    "a_hip",
    "b.hip",
    "c[0]",
    "d+",
    "e(x|y)",
    'f"g',
    "h'i",
    "j\\d",
    "left hip",
    "k#l",
    "ünï",
    "{{m}}",
    "n\no",
)
"""Joint names that end literals, comments, templates and patterns."""

SIZE = st.floats(0.01, 100.0).map(lambda x: float(f"{x:.3g}"))
MAYBE = st.none() | SIZE

DIALECTS = [
    ("2.1", None, None, "coefficient"),
    ("2.2", "4.5", None, "coefficient"),
    ("2.2", "5.0", None, "dead"),
    ("2.3", "5.1", None, "effort"),
    ("3.0", None, None, "effort"),
    ("3.0", None, "newton", "one"),
    ("3.0", None, "ovphysx", "ovphysx"),
]
"""Isaac Lab, Isaac Sim, backend, and what friction means there."""


@dataclass(frozen=True)
class Drive:
    """One group of the spec, whose joints are alike; SI, None: not stated."""

    joints: tuple[str, ...]
    slide: bool
    command: str
    kp: float
    kd: float
    limit: float
    line: tuple[float, float] | None
    curve: tuple[float, float, float, float] | None
    velocity_limit: float | None
    armature: float | None
    coulomb: float | None
    static: float | None
    viscous: float | None
    stribeck: float | None
    cutoff: float | None
    bias: float | None
    range: tuple[float, float] | None
    delay: tuple[int | None, int, int, str] | None
    """Nominal and ends [ms], and when it is drawn."""

    @property
    def level(self) -> str:
        """Model level."""
        return "dc_motor" if self.line or self.curve else "ideal_pd"

    @property
    def speed(self) -> float | None:
        """w0, or the speed at which kd takes the limit; None: neither."""
        if self.curve:
            return self.curve[3]
        if self.line:
            return self.line[1]
        return None if self.command == "effort" else self.limit / self.kd

    def spec(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """The group and its motor, as the spec has them."""
        torque, angle = ("N", "m") if self.slide else ("N*m", "rad")
        gain = "N*s/m" if self.slide else "N*m*s/rad"
        command = {"position": angle, "velocity": f"{angle}/s", "effort": torque}[self.command]
        friction = {"coulomb": (self.coulomb, torque), "static": (self.static, torque),
                    "viscous": (self.viscous, gain), "stribeck_velocity": (self.stribeck, f"{angle}/s")}  # fmt: skip
        group: dict[str, Any] = {
            "joints": [re.escape(name) for name in self.joints],
            "level": self.level,
            "command": self.command,
            "effort_limit": f"{self.limit} {torque}",
            "friction": {key: f"{value} {unit}" for key, (value, unit) in friction.items() if value is not None},
        }  # fmt: skip
        if self.command == "position":
            group["kp"] = f"{self.kp} N{'/m' if self.slide else '*m/rad'}"
        if self.command != "effort":
            group["kd"] = f"{self.kd} {gain}"
        for key, value, unit in (
            ("velocity_limit", self.velocity_limit, f"{angle}/s"),
            ("armature", self.armature, "kg" if self.slide else "kg*m^2"),
            ("encoder_bias", self.bias, angle),
        ):
            if value is not None:
                group[key] = f"{value} {unit}"
        if self.cutoff is not None:
            group["command_filter"] = {"cutoff": f"{self.cutoff} Hz"}
        if self.range is not None:
            group["command_range"] = [f"{end} {command}" for end in self.range]
        if self.delay is not None:
            nominal, low, high, drawn = self.delay
            group["delay"] = {"nominal": "unknown" if nominal is None else f"{nominal} ms",
                              "range": [f"{low} ms", f"{high} ms"], "sampling": drawn}  # fmt: skip
        motor: dict[str, Any] = {"side": "joint"}
        if self.curve:
            names = ("drive_torque", "brake_torque", "knee_speed", "no_load_speed")
            units = (torque, torque, f"{angle}/s", f"{angle}/s")
            motor["curve"] = {n: f"{v} {u}" for n, v, u in zip(names, self.curve, units, strict=True)}
        elif self.line:
            motor |= {
                "stall_torque": f"{self.line[0]} {torque}",
                "no_load_speed": f"{self.line[1]} {angle}/s",
            }
        return group, motor


@st.composite
def drives(draw: st.DrawFn, joints: tuple[str, ...]) -> Drive:
    """Any group."""
    limit = draw(SIZE)
    speed = draw(st.floats(1.0, 50.0).map(lambda x: float(f"{x:.3g}")))
    shape = draw(st.sampled_from(["pd", "line", "curve"]))
    torques = st.floats(0.3, 3.0).map(lambda share: float(f"{share * limit:.3g}"))
    knee = float(f"{speed * draw(st.just(0.0) | st.floats(0.01, 0.95)):.3g}")
    ends = draw(st.lists(st.integers(0, 30), min_size=3, max_size=3).map(sorted))
    nominal = draw(st.sampled_from([None, ends[1]]))
    coulomb = draw(MAYBE)
    above = draw(st.none() | st.sampled_from([0.0, 0.5]))
    return Drive(
        joints=joints,
        slide=draw(st.booleans()),
        command=draw(st.sampled_from(["position", "velocity", "effort"])),
        kp=draw(SIZE),
        kd=draw(SIZE),
        limit=limit,
        line=(draw(torques), speed) if shape == "line" else None,
        curve=(draw(torques), draw(torques), knee, speed) if shape == "curve" else None,
        velocity_limit=draw(MAYBE),
        armature=draw(MAYBE),
        coulomb=coulomb,
        static=None if above is None or coulomb is None else round(coulomb + above, 6),
        viscous=draw(st.none() | st.just(0.0) | SIZE),
        stribeck=draw(MAYBE),
        cutoff=draw(MAYBE),
        bias=draw(st.none() | st.sampled_from([0.0, -0.07, 0.2])),
        range=draw(st.none() | st.just((-0.6 * limit, 0.4 * limit)) | st.just((-0.3, 0.2))),
        delay=draw(
            st.none() | st.just((nominal, ends[0], ends[2], draw(st.sampled_from(["episode", "step"]))))
        ),
    )


@st.composite
def robots(draw: st.DrawFn) -> list[Drive]:
    """One to three groups of one or two joints."""
    names = iter(draw(st.permutations(NAMES)))
    sizes = draw(st.lists(st.integers(1, 2), min_size=1, max_size=3))
    return [draw(drives(tuple(next(names) for _ in range(size)))) for size in sizes]


def resolved(
    groups: list[Drive],
    *,
    randomize: dict[str, Any] | None = None,
    robot: dict[str, Any] | None = None,
    timing: dict[str, Any] | None = None,
    actuators: dict[str, Any] | None = None,
    view: RobotView | None = None,
) -> tuple[ActuatorSet, RobotView]:
    """The groups on a robot that the spec lists or on `view`, all with the same ranges and `actuators` fields."""
    specs = {f"g{i}": drive.spec() for i, drive in enumerate(groups)}
    joints = [
        {"name": name, "kind": "slide" if drive.slide else "hinge"}
        for drive in groups
        for name in drive.joints
    ]
    document = {
        "actspec": 1,
        "robot": {
            "name": "bot",
            **({"model": "none", "joints": joints} if view is None else {"model": "bot.urdf"}),
            **(robot or {}),
        },
        "timing": {"physics_dt": "5 ms", **(timing or {})},
        "accept": drawn_numbers(),
        "motors": {f"m{key}": motor for key, (_, motor) in specs.items()},
        "actuators": {
            key: {**group, "motor": f"m{key}", "randomize": randomize or {}, **(actuators or {})}
            for key, (group, _) in specs.items()
        },
    }
    spec = validate(document_from_text(json.dumps(document), "s.yaml"))
    found = view or listed_robot(spec)
    return resolve(spec, found), found


def emitted(actuators: ActuatorSet, robot: RobotView, **options: Any) -> Emission:
    """A robot's actuators, compiled for a kind of target at a version."""
    kind = options.pop("kind")
    return emitter(kind)(actuators, robot, target_options(kind, options.pop("version"), **options))


def compiled(groups: list[Drive], *, randomize: dict[str, Any] | None = None, **options: Any) -> Emission:
    """The groups, compiled, all with the same ranges."""
    return emitted(*resolved(groups, randomize=randomize), **options)


# --- the text -----------------------------------------------------------------------------------------------


def cfgs(text: str, key: str) -> Iterator[dict[str, Any]]:
    """Every actuator cfg of a module: its class and keywords."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Call) and any(k.arg == key for k in node.keywords):
            assert isinstance(node.func, ast.Name)
            # `10**9` is no literal.
            given = {k.arg: k.value for k in node.keywords if not isinstance(k.value, ast.BinOp)}
            yield {"class": node.func.id, **{str(k): ast.literal_eval(v) for k, v in given.items()}}


def by_joint(found: Iterator[dict[str, Any]], key: str, names: list[str]) -> dict[str, dict[str, Any]]:
    """Numbers of each joint; each joint in one cfg, and in a dict by one key."""
    numbers: dict[str, dict[str, Any]] = {}
    for cfg in found:
        patterns = cfg.pop(key)
        mine = [name for name in names if any(re.fullmatch(p, name) for p in patterns)]
        assert all(any(re.fullmatch(p, name) for name in names) for p in patterns)
        for name in mine:
            assert name not in numbers
            numbers[name] = {}
            for field, value in cfg.items():
                if isinstance(value, dict):
                    (value,) = (v for p, v in value.items() if re.fullmatch(p, name))
                numbers[name][field] = value
    return numbers


def sizes_of(losses: tuple[Approximation, ...]) -> dict[str, dict[str, float | None]]:
    """Size by joint and field, of a torque-speed line up to twice its no-load speed; a field is lost once."""
    found: dict[str, dict[str, float | None]] = {}
    for loss in losses:
        mine = found.setdefault(loss.joint, {})
        assert loss.field not in mine, loss
        mine[loss.field] = (
            loss.max_torque_error if loss.beyond is None else max(loss.max_torque_error or 0.0, loss.beyond)
        )
    return found


# --- the oracle ---------------------------------------------------------------------------------------------


def raw(d: Drive, a: Array, q: float, w: Array, bias: float) -> Array:
    """Torque before the clamp."""
    if d.command == "position":
        return d.kp * (a - q - bias) - d.kd * w
    return d.kd * (a - w) if d.command == "velocity" else a


def dc(tau: Array, w: Array, stall: float, w0: float, limit: float) -> Array:
    """Four quadrants."""
    v = np.clip(w, -w0 * (1 + limit / stall), w0 * (1 + limit / stall)) / w0
    return np.clip(tau, np.maximum(-limit, stall * (-1 - v)), np.minimum(limit, stall * (1 - v)))


def dc_two(tau: Array, w: Array, stall: float, w0: float, limit: float) -> Array:
    """Two quadrants, as Isaac Lab 2.1."""
    return np.clip(tau, np.clip(stall * (-1 - w / w0), -limit, 0), np.clip(stall * (1 - w / w0), 0, limit))


def clamp(d: Drive, tau: Array, w: Array) -> Array:
    """The spec's clamp."""
    if d.curve:
        drive, brake, knee, w0 = d.curve
        left = np.where(np.abs(w) >= knee, np.maximum(0, 1 - (np.abs(w) - knee) / (w0 - knee)), 1.0)
        bound = np.minimum(np.where(tau * w > 0, drive, brake) * left, d.limit)
        return np.clip(tau, -bound, bound)
    return dc(tau, w, *d.line, d.limit) if d.line else np.clip(tau, -d.limit, d.limit)


class Oracle:
    """Sizes of one drive's losses: torques asked for up to 2 L, speeds up to 2 w0, 81 of each."""

    def __init__(self, d: Drive) -> None:
        self.d = d
        self.bias = (d.bias or 0.0) if d.command == "position" else 0.0
        self.wide = 2.0 * d.speed if d.speed is not None else d.velocity_limit
        parts = np.arange(-40, 41) / 40
        tau, self.w = np.meshgrid(parts * 2 * d.limit, parts * (self.wide or 1.0))
        self.tau, self.a = tau, tau
        if d.command == "position":
            self.a = self.bias + (tau + d.kd * self.w) / d.kp
        elif d.command == "velocity":
            self.a = tau / d.kd + self.w
        self.whole = clamp(d, tau, self.w)
        self.half = abs(float(clamp(d, np.array(0.5 * d.limit), np.array(0.0))))

    def against(self, torque: Array) -> float:
        """Largest difference from the law."""
        return float(np.abs(self.whole - torque).max())

    def unbiased(self) -> float:
        """Without the encoder's bias."""
        return self.against(clamp(self.d, raw(self.d, self.a, 0.0, self.w, 0.0), self.w))

    def summed(self, viscous: float) -> float | None:
        """Viscous friction inside the clamp."""
        if self.wide is None:
            return None
        friction = viscous * self.w
        return float(np.abs(self.whole - friction - clamp(self.d, self.tau - friction, self.w)).max())

    def unclamped_command(self) -> float:
        """Without the clamp of the command, the joint at either end of it."""
        assert self.d.range is not None
        worst = 0.0
        for q in self.d.range if self.d.command == "position" else (0.0,):
            clipped = raw(self.d, np.clip(self.a + q, *self.d.range), q, self.w, self.bias)
            worst = max(worst, self.against(clamp(self.d, clipped, self.w)))
        return worst

    def late(self, seconds: float, filtered: bool) -> float:
        """A step that comes too late, behind a filter or not."""
        if filtered and self.d.cutoff is not None:
            return self.half * -math.expm1(-2 * math.pi * self.d.cutoff * seconds)
        return self.half


def one_line(d: Drive) -> tuple[float, float, float]:
    """Stall torque, no-load speed and limit where a class has one line."""
    if d.curve:
        drive, _, knee, w0 = d.curve
        return drive / (1 - knee / w0), w0, min(d.limit, drive)
    assert d.line is not None
    return (*d.line, d.limit)


def steps(ms: int) -> int:
    """Physics steps, half up."""
    return math.floor(ms / 1e3 / STEP + 0.5 + 1e-9)


def off(ms: int) -> float:
    """What the rounding of a delay loses [s]."""
    return abs(steps(ms) * STEP - ms / 1e3)


def path_losses(d: Drive, o: Oracle, *, whole: bool) -> dict[str, float | None]:
    """Filter, bias and clamp of the command, where a class has none of them."""
    lost: dict[str, float | None] = {}
    if whole:
        return lost
    if d.cutoff is not None:
        lost["command_filter"] = o.half
    if o.bias:
        lost["encoder_bias"] = o.unbiased()
    if d.range is not None:
        lost["command_range"] = o.unclamped_command()
    return lost


def stuck(d: Drive) -> bool:
    """Whether static friction is above the sliding one."""
    return d.static is not None and d.static > (d.coulomb or 0.0)


def isaaclab_losses(d: Drive, o: Oracle, version: str, friction: str, cls: str) -> dict[str, float | None]:
    """What an Isaac Lab class loses."""
    lost = path_losses(d, o, whole=cls == "custom")
    line = d.line is not None or d.curve is not None
    if cls == "implicit":
        if line:
            box = o.tau if d.command == "effort" else np.clip(o.tau, -d.limit, d.limit)
            lost["torque_speed_curve"] = o.against(box)
        if d.command == "effort":
            lost["effort_limit"] = d.limit
    elif cls == "auto" and (d.curve or (line and version == "2.1")):
        lost["torque_speed_curve"] = o.against((dc_two if version == "2.1" else dc)(o.tau, o.w, *one_line(d)))
    if friction in ("coefficient", "dead") and d.viscous:
        left_out = None if o.wide is None else d.viscous * o.wide
        lost["friction.viscous"] = left_out if d.command == "velocity" else o.summed(d.viscous)
    dry = {"friction.coulomb": d.coulomb, "friction.static": d.static if stuck(d) else None}
    if friction in ("coefficient", "dead", "ovphysx"):
        lost |= {field: torque for field, torque in dry.items() if torque}
    elif friction == "one" and stuck(d):
        lost["friction.static"] = (d.static or 0.0) - (d.coulomb or 0.0)
    if stuck(d) and d.stribeck is not None:
        lost["friction.stribeck_velocity"] = (d.static or 0.0) - (d.coulomb or 0.0)
    return lost | isaaclab_delay(
        d, o, version, delays=cls == "custom" or (cls == "auto" and not line), cls=cls
    )


def isaaclab_delay(d: Drive, o: Oracle, version: str, *, delays: bool, cls: str) -> dict[str, float | None]:
    """What becomes of a delay: lags drawn at reset in 2.x, one lag in 3.0."""
    nominal, low, high, drawn = d.delay or (None, 0, 0, "")
    if not high:
        return {}
    if not delays:
        return {"delay": o.half}
    filtered, lost = cls == "custom", dict[str, float | None]()
    if low != high and version != "3.0":
        if (worst := max(off(low), off(high))) > 1e-9:
            lost["delay.range"] = o.late(worst, filtered)
        if drawn == "step" and steps(low) != steps(high):
            lost["delay.sampling"] = o.late((high - low) / 1e3, filtered)
        return lost
    if low == high:
        nominal = low
    if nominal is not None and off(nominal) > 1e-9:
        lost["delay"] = o.late(off(nominal), filtered)
    if low != high:
        lag = 0.0 if nominal is None else steps(nominal) * STEP
        lost["delay.range"] = o.late(max(abs(lag - low / 1e3), abs(lag - high / 1e3)), filtered)
    return lost
