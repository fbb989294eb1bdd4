"""One motor with what it drives: its figures at the gearbox output, the limits of its joints, the gears on the way."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from actspec.diagnostics import Path
from actspec.spec.gears import KINDS_OF_STAGE, Stage
from actspec.spec.models import Motor
from actspec.spec.rules.motors import stage_ratio, stage_speed
from actspec.spec.values import SpecValue

MICRO = 1e-3
"""A rotor of less is a micro motor's [N*m]."""
GEARED = 3.0
"""A gear ratio from which on rotor and output cannot be taken for each other."""
LEAST_DRIVEN = 0.004
"""What torque constant and current give, over the stall torque: of mN*m read as N*m it is a thousandth. Chosen: a
direct drive on 60 A, of 840 A at stall (U15 II), has 0.07."""


def number(value: SpecValue | None) -> float | None:
    """The number of a field of something that turns; None where there is none, or it is of a slide."""
    return None if value is None or value.linear else value.value


def any_number(value: SpecValue | None) -> float | None:
    """The number of a field, whether it is of something that turns or of a slide; None where there is none."""
    return None if value is None else value.value


@dataclass(frozen=True, slots=True)
class Limit:
    """An effort or velocity limit of joints that a motor drives.

    Attributes:
        value: As stated, with a number.
        path: Where it stands; its last part tells which of the two it is.
        reduction: From the motor's output to the joint, where no transmission stands there.
        motors: How many drive one joint.
        train: Key of the transmission in the drive's `trains`; None: there is none.
        counted: Where the number of motors is written; None: it is not.
        reduced: Where the reduction is written; likewise.
    """

    value: SpecValue
    path: Path
    reduction: float
    motors: int
    train: Path | None = None
    counted: Path | None = None
    reduced: Path | None = None


@dataclass(frozen=True, slots=True)
class Rub:
    """Friction of joints whose effort limit is the motor's own.

    Attributes:
        value: Of dry or viscous friction, as stated, with a number.
        path: Where it stands; its last part tells which of the two it is.
        limit: Which of the motor's torques limits the joint: `peak` or `continuous`; None: the first that is known.
        reduction: From the motor's output to the joint, where no transmission stands there.
        motors: How many drive one joint.
        train: Key of the transmission in the drive's `trains`; None: there is none.
    """

    value: SpecValue
    path: Path
    limit: str | None
    reduction: float
    motors: int
    train: Path | None = None


@dataclass(frozen=True, slots=True)
class Train:
    """What stands between the output of a motor, which turns, and a joint: a transmission, or a gearbox's end.

    Of a gearbox whose output travels the stages from the first length on are such a train.

    Attributes:
        stages: From the motor to the joint.
        motors: How many drive one joint.
        root: Where the stages are written.
        first: Index of the first one there.
    """

    stages: tuple[Stage, ...]
    motors: int
    root: Path
    first: int = 0

    def place(self, index: int) -> Path:
        """Where the number of a stage is written."""
        return stage_path(self.stages[index], (*self.root, self.first + index))

    @property
    def slide(self) -> bool:
        """Whether the joint travels."""
        return sum(stage_ratio(stage) is None for stage in self.stages) % 2 == 1

    @property
    def speed(self) -> float:
        """Speed of the motor's output per speed of the joint [-, or rad/m]."""
        speed, travels = 1.0, self.slide
        for stage in reversed(self.stages):
            speed *= stage_speed(stage, travels)
            travels ^= stage_ratio(stage) is None
        return speed

    @property
    def torque(self) -> float:
        """Torque or force at the joint per torque of one motor [-, or 1/m]."""
        passed = math.prod(number(stage.efficiency) or 1.0 for stage in self.stages)
        return self.speed * passed * self.motors


@dataclass(frozen=True, slots=True)
class Witness:
    """A limit that the robot's file states of a joint that a motor drives.

    Attributes:
        joint: Name of the joint.
        value: The limit, in its unit.
        unit: N*m, N, rad/s or m/s.
        speed: It is one of speed.
        factor: What a figure at the motor's output is times at the joint, beside train and motors; None: unknown.
        limit: Where the spec states the same limit; None: it does not.
        train: Key of the train in the drive's `trains`; None: there is none.
        motors: How many drive one joint, where no train has them.
        counted: Where their number is written; None: it is not.
        reduced: Where the reduction to the joint is written; likewise.
        reduction: Its size [-].
    """

    joint: str
    value: float
    unit: str
    speed: bool
    factor: float | None
    limit: Path | None
    train: Path | None = None
    motors: int = 1
    counted: Path | None = None
    reduced: Path | None = None
    reduction: float = 1.0


@dataclass(frozen=True, slots=True)
class Drive:
    """A motor, by its name in `motors`, and what is said of its joints.

    Attributes:
        name: Its name.
        motor: The motor.
        limits: Limits that the spec states.
        witnesses: Limits that the robot's file states.
        trains: Transmissions to its joints, and the end of a gearbox whose output travels, each by a key of its own.
        reductions: To its joints without a transmission; None: nothing is known of its joints, as behind a linkage.
        sure: Numbers that the author is sure of.
        large: The author is sure of the size of every motor.
        wheels: Its joints are all commanded a velocity, as wheels are.
        rubs: Friction of its joints.
    """

    name: str
    motor: Motor
    limits: tuple[Limit, ...] = ()
    witnesses: tuple[Witness, ...] = ()
    trains: Mapping[Path, Train] = field(default_factory=dict)
    reductions: tuple[float, ...] | None = (1.0,)
    sure: frozenset[Path] = frozenset()
    large: bool = False
    wheels: bool = False
    rubs: tuple[Rub, ...] = ()

    @property
    def hinges(self) -> list[tuple[float, float]]:
        """Of each way to a joint that turns: the output's turns in one of its own, and its torque over the output's."""
        if self.reductions is None:
            return []
        ways = [(train.speed, train.torque) for train in self.trains.values() if not train.slide]
        ways += [(reduction, reduction) for reduction in self.reductions]
        return [way for way in ways if all(0.0 < part < math.inf for part in way)]


@dataclass(frozen=True, slots=True)
class Output:
    """A motor's figures at its gearbox output; None is unknown.

    Attributes:
        gear: Rotor turns in one output turn.
        efficiency: Of the gearbox.
        torque: What the drive gives: the peak torque where it is stated, else that of the peak current, else the
            largest of stall, drive and continuous torque [N*m].
        winding: The stall or drive torque where it is above that, as of a winding whose drive gives less [N*m].
        speed: Without load [rad/s].
        torque_path: Where the torque is written.
        winding_path: Where that of the winding is written.
        speed_path: Where the speed is written.
    """

    gear: float | None
    efficiency: float
    torque: float | None
    winding: float | None
    speed: float | None
    torque_path: Path
    winding_path: Path
    speed_path: Path

    @property
    def thermal(self) -> bool:
        """Whether nothing but a continuous torque is known: that the drive gives more is likely."""
        return self.torque_path[-1] == "continuous_torque"

    @property
    def micro(self) -> bool:
        """Whether the motor is known to be a tiny one, by its torque at the rotor."""
        return self.gear is not None and 0.0 < (self.torque or 0.0) < MICRO * self.gear * self.efficiency


def output_of(name: str, motor: Motor) -> Output:
    """The figures of a motor that turns at its gearbox output."""
    path: Path = ("motors", name)
    gear, efficiency = gear_of(motor), efficiency_of(motor)
    written: list[tuple[SpecValue | None, Path]] = [
        (getattr(motor, field), (*path, field))
        for field in ("stall_torque", "peak_torque", "continuous_torque")
    ]
    speed, speed_path = motor.no_load_speed, (*path, "no_load_speed")
    if motor.curve is not None:
        written.append((motor.curve.drive_torque, (*path, "curve", "drive_torque")))
        speed, speed_path = motor.curve.no_load_speed, (*path, "curve", "no_load_speed")
    known = [(value, place) for given, place in written if (value := number(given)) is not None]
    nothing: tuple[float | None, Path] = (None, path)
    most, most_path = max(known, key=lambda item: item[0], default=nothing)
    drives = [item for item in known if item[1][-1] == "peak_torque"]
    given = (number(motor.torque_constant) or 0.0) * (number(motor.peak_current) or 0.0)
    if motor.peak_torque is None and given >= LEAST_DRIVEN * (most or 0.0):
        drives.append((given, (*path, "peak_current")))
    # Of two equal ones the first is blamed, as without a peak; a continuous torque is not what the drive gives at most.
    thermal = most_path[-1] == "continuous_torque"
    peak = next((item for item in drives if item[0] and (thermal or item[0] < (most or 0.0))), None)
    torque, torque_path = (most, most_path) if peak is None else peak
    winding, winding_path = (most, most_path) if (torque or 0.0) < (most or 0.0) else nothing
    fast = number(speed)
    if motor.side == "motor":
        to_output = None if gear is None else gear * efficiency
        torque = None if torque is None or to_output is None else torque * to_output
        winding = None if winding is None or to_output is None else winding * to_output
        fast = None if fast is None or gear is None else fast / gear
    return Output(gear, efficiency, torque, winding, fast, torque_path, winding_path, speed_path)


def is_geared(output: Output) -> bool:
    """Whether rotor and output cannot be taken for each other."""
    return output.gear is not None and output.gear >= GEARED


def gear_of(motor: Motor) -> float | None:
    """Rotor turns in one output turn; None where it is unknown, no number, or one of the two travels."""
    return number(motor.gear_ratio) if motor.gearbox is None else turns_of(motor.gearbox)


def turns_of(stages: Sequence[Stage]) -> float | None:
    """Turns at the input of stages in one at their output; None where it is unknown, no number, or one of the two
    travels."""
    ratios = [stage_ratio(stage) for stage in stages]
    product = math.prod(ratio for ratio in ratios if ratio is not None)
    # A product that leaves the range of floats is RES011's.
    return product if None not in ratios and 0.0 < product < math.inf else None


def cut_gearbox(motor: Motor) -> tuple[Motor, int] | None:
    """A motor with the stages of its gearbox that turn, and their number; None where its output turns, too."""
    stages = motor.gearbox or ()
    first = next((index for index, stage in enumerate(stages) if stage_ratio(stage) is None), None)
    if first is None or motor.side != "motor" or not all(is_one(stage) for stage in stages):
        return None
    # What is stated of its output is of what travels.
    return motor.model_copy(update={"gearbox": stages[:first], "reflected_inertia": None}), first


def scaled(witness: Witness, trains: Mapping[Path, Train]) -> float:
    """What a figure at the motor's output is times at the joint of a witness, of its train and motors."""
    if witness.train is not None:
        train = trains[witness.train]
        return 1.0 / train.speed if witness.speed else train.torque
    return 1.0 if witness.speed else float(witness.motors)


def efficiency_of(motor: Motor) -> float:
    """Of the gearbox; 1 where none is stated."""
    stages = [number(stage.efficiency) for stage in motor.gearbox or ()]
    return (number(motor.efficiency) or 1.0) * math.prod(part or 1.0 for part in stages)


def is_one(stage: Stage) -> bool:
    """Whether a stage says what it is; if not, it is reported elsewhere."""
    return sum(getattr(stage, kind) is not None for kind in KINDS_OF_STAGE) == 1


def stage_path(stage: Stage, path: Path) -> Path:
    """Where the number of a stage is written."""
    return (*path, next(kind for kind in KINDS_OF_STAGE if getattr(stage, kind) is not None))


def figure_at(motor: Motor, path: Path) -> SpecValue | None:
    """A figure of a motor or of its curve."""
    node: object = motor
    for part in path:
        node = None if node is None else getattr(node, str(part))
    assert node is None or isinstance(node, SpecValue)
    return node


def with_figure(motor: Motor, path: Path, value: SpecValue | None) -> Motor:
    """The motor with another figure."""
    if len(path) == 1:
        return motor.model_copy(update={str(path[0]): value})
    part = getattr(motor, str(path[0]))
    return motor.model_copy(update={str(path[0]): part.model_copy(update={str(path[1]): value})})
