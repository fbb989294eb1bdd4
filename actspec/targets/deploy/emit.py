"""The deploy target: joint orders with their index maps, gains, limits, pose and rates, for the robot side.

Nothing here is an approximation. A torque-speed line, friction, armature or a command filter describe the
motor that a simulator has to imitate; on the robot it is the motor itself that has them, so the file leaves
them out and loses no torque. An encoder bias belongs to one robot and one day: calibration, not deployment.
What nobody says is `null`, never 0.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Iterator, Sequence

from actspec.diagnostics import Collector, EmitError, listed, one_line
from actspec.ir import ActuatorSet, Command, JointActuator, Origin, Quantity
from actspec.robot.view import ModelFormat, RobotView, isaac_order
from actspec.spec.models import DeployTarget
from actspec.targets.base import Emission, EmittedFile, TargetOptions
from actspec.targets.deploy.order import check_sdk_order
from actspec.targets.kit.provenance import source_lines, written_by
from actspec.targets.kit.python_text import environment, grouped, identifier, origin_of
from actspec.targets.kit.yaml_quoted import double_quoted
from actspec.units import format_number

FORMAT = "actspec-deploy/1"

Value = Callable[[JointActuator], Quantity | None]
Order = tuple[str | None, ...]


def emit(actuators: ActuatorSet, robot: RobotView, options: TargetOptions) -> Emission:
    """Write a robot's deploy file; see `choose.Emit`.

    Raises: EmitError: the SDK's order does not name exactly the managed joints.
    """
    collector = Collector()
    own = tuple(actuator.joint for actuator in actuators.joints)
    sdk = options.of(DeployTarget).joint_order or None
    check_sdk_order(options, own, collector)
    collector.raise_if_failed(EmitError)
    isaac = isaac_order(robot, own)
    orders: dict[str, Order | None] = {"robot": own, "isaac": isaac, "sdk": sdk}
    text = (
        environment("deploy")
        .get_template("deploy.yaml.j2")
        .render(
            header=[f"# {comment(line)}".rstrip() for line in _header(actuators, robot)],
            format=FORMAT,
            robot=scalar(actuators.robot),
            spec_sha256=actuators.spec_sha256,
            gaps=sdk is not None and None in sdk,
            orders=[_known(name, order) for name, order in orders.items()],
            maps=[_map(first, second, orders) for first in orders for second in orders if first != second],
            timing=list(_timing(actuators)),
            rows=[(comment(about), lines) for about, lines in _rows(actuators)],
        )
    )
    path = f"{identifier(actuators.robot).lower()}_deploy.yaml"
    return Emission((EmittedFile(path, text.encode("utf-8")),), (), collector.sorted())


def _header(actuators: ActuatorSet, robot: RobotView) -> Iterator[str]:
    yield written_by()
    if robot.format is not ModelFormat.NONE:
        yield f"model {os.path.basename(robot.path)}"
    if actuators.variant is not None:
        yield f"variant {actuators.variant}"
    if actuators.unmanaged:
        yield f"Not managed by the spec, and in no order below: {listed(actuators.unmanaged)}"
    yield from source_lines(actuators, _shown(actuators))


def _shown(actuators: ActuatorSet) -> Iterator[Quantity]:
    """Every known number of the file."""
    yield actuators.physics_dt
    for actuator in actuators.joints:
        for value in _VALUES.values():
            quantity = value(actuator)
            if quantity is not None and quantity.known:
                yield quantity
        if actuator.delay is not None and actuator.delay.nominal.known:
            yield actuator.delay.nominal
        yield from (end for end in actuator.command_range or () if end.known)


def _known(name: str, order: Order | None) -> list[str]:
    return [f"  {name}: null"] if order is None else entry(name, order, "  ")


def _map(first: str, second: str, orders: dict[str, Order | None]) -> list[str]:
    source, result = orders[first], orders[second]
    if source is None or result is None:
        return [f"  {first}_to_{second}: null"]
    return entry(f"{first}_to_{second}", index_map(source, result), "  ")


def _timing(actuators: ActuatorSet) -> Iterator[str]:
    dt = actuators.physics_dt
    origin = actuators.assumed_step or comment(origin_of(dt))
    yield f"  physics_dt: {scalar(dt.value)}  # s, of the simulation; {origin}"
    period, meaning = actuators.control_period, "physics steps in one control step"
    if actuators.decimation is None and period is not None and not actuators.assumed_step:
        meaning += f"; {format_number(round(period / dt.require(), 3))} are no whole number"
    yield f"  decimation: {scalar(actuators.decimation)}  # {meaning}"
    yield f"  control_dt: {scalar(period)}  # s, between two actions of the policy"


_VALUES: dict[str, Value] = {
    "kp": lambda a: a.kp,
    "kd": lambda a: a.kd,
    "effort_limit": lambda a: a.effort_limit,
    "velocity_limit": lambda a: a.velocity_limit,
    "default_position": lambda a: a.default_position,
    "action_scale": lambda a: a.action_scale,
}
_MEANING = {
    "kp": "drive stiffness",
    "kd": "drive velocity gain, without the joint's own friction",
    "effort_limit": "clamp of the torque",
    "velocity_limit": "speed limit of the joint",
    "default_position": "pose at zero action",
}
_OFFSET = {Command.POSITION: "default_position + ", Command.VELOCITY: "", Command.EFFORT: ""}
"""What an action is added to, by command."""


def _rows(actuators: ActuatorSet) -> Iterator[tuple[str, list[str]]]:
    """Comment and lines of each list, in the robot's order."""
    joints = actuators.joints
    yield "What the command is", entry("command", [joint.command.value for joint in joints])
    for name, value in _VALUES.items():
        quantities = [value(joint) for joint in joints]
        numbers = [None if q is None else q.value for q in quantities]
        meaning = [_MEANING[name]] if name in _MEANING else _commands(joints)
        about = [*meaning, *_units(joints, quantities), *_origins(joints, quantities)]
        yield "; ".join(about), entry(name, numbers)
        if name == "velocity_limit":
            ranges = [joint.position_range for joint in joints]
            units = _units(joints, [joint.default_position for joint in joints])
            said = "; ".join(["the joint's own range", *units, "null: none is stated"])
            for side, index in (("position_lower", 0), ("position_upper", 1)):
                yield said, entry(side, [None if ends is None else ends[index] for ends in ranges])
    yield from _command_range(joints)
    yield _policy_delay(joints)


def _commands(joints: Sequence[JointActuator]) -> list[str]:
    """What a command is made of, or each kind of it with its joints."""
    pairs = [(f"command = {_OFFSET[j.command]}action_scale x action", j.joint) for j in joints]
    kinds = grouped(pairs, lambda pair: pair[0])
    if len(kinds) == 1:
        return [kinds[0][0]]
    return [f"{text} at {listed((name for _, name in members), 4)}" for text, members in kinds]


def _command_range(joints: Sequence[JointActuator]) -> Iterator[tuple[str, list[str]]]:
    """The clamp of the command, which the robot's side has to apply as the simulators do."""
    meaning = "clamp of the command before it is sent"
    if all(joint.command_range is None for joint in joints):
        yield f"{meaning}; none", ["command_range: null"]
        return
    ends = [joint.command_range or (None, None) for joint in joints]
    lows = [low for low, _ in ends]
    about = [meaning, *_units(joints, lows), *_origins(joints, lows, none="none")]
    lines = ["command_range:"]
    for name, index in (("low", 0), ("high", 1)):
        values = [None if (end := pair[index]) is None else end.value for pair in ends]
        lines += entry(name, values, "  ")
    yield "; ".join(about), lines


def _policy_delay(joints: Sequence[JointActuator]) -> tuple[str, list[str]]:
    meaning = "delay of the command that the policy was trained with"
    delays = [joint.delay for joint in joints]
    if all(delay is None for delay in delays):
        return f"{meaning}; not stated", ["policy_delay: null"]
    known = [None if delay is None else delay.nominal for delay in delays]
    # An unknown delay without a range has no ends either.
    ends = [
        (None, None)
        if delay is None or not (delay.nominal.known or delay.high > 0.0)
        else (delay.low, delay.high)
        for delay in delays
    ]
    lists = {
        "nominal": [None if delay is None else delay.nominal.value for delay in delays],
        "low": [low for low, _ in ends],
        "high": [high for _, high in ends],
    }
    about = [meaning, "s", *_origins(joints, known)]
    return (
        "; ".join(about),
        [
            "policy_delay:",
            *(line for name, numbers in lists.items() for line in entry(name, numbers, "  ")),
        ],
    )


def _units(joints: Sequence[JointActuator], quantities: Sequence[Quantity | None]) -> list[str]:
    """The unit, or each with its joints where hinges and slides are mixed."""
    pairs = [(q.unit, j.joint) for q, j in zip(quantities, joints, strict=True) if q is not None and q.unit]
    kinds = grouped(pairs, lambda pair: pair[0])
    if len(kinds) <= 1:
        return [unit for unit, _ in kinds]
    return [f"{unit} at {listed((name for _, name in members), 4)}" for unit, members in kinds]


def _origins(
    joints: Sequence[JointActuator], quantities: Sequence[Quantity | None], none: str = "not stated"
) -> list[str]:
    """Where the numbers come from, and which are not there: `none` says how."""
    said = []
    for quantity, joint in zip(quantities, joints, strict=True):
        if quantity is None:
            said.append((none, joint.joint))
        elif not quantity.known:
            said.append(("unknown", joint.joint))
        else:
            text = "a default" if quantity.origin is Origin.DEFAULT else origin_of(quantity)
            said.append((text, joint.joint))
    kinds = grouped(said, lambda pair: pair[0])
    if len(kinds) == 1:
        return [kinds[0][0]]
    return [f"{text}: {listed((name for _, name in members), 4)}" for text, members in kinds]


def index_map(source: Sequence[str | None], result: Sequence[str | None]) -> tuple[int | None, ...]:
    """Where each entry of one order stands in another: `result[i] = source[index_map(source, result)[i]]`.

    A gap of `result` has None, and one of `source` nobody's index.
    """
    place = {name: index for index, name in enumerate(source) if name is not None}
    return tuple(None if name is None else place[name] for name in result)


WIDTH = 100
"""Columns of a list."""

_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_WORDS = frozenset({"y", "n", "yes", "no", "on", "off", "true", "false", "null", "none", "nan", "inf"})


def scalar(value: str | float | int | None) -> str:
    """A value on one line, the same to a reader of YAML 1.1 and of 1.2; None is `null`."""
    if value is None:
        return "null"
    if isinstance(value, str):
        if _PLAIN.fullmatch(value) and value.lower() not in _WORDS:
            return value
        return double_quoted(value, ascii_only=True)
    if isinstance(value, int):
        return str(value)
    # Twelve digits hide the last bit of an arithmetic; -0.0 is 0.0.
    text = repr(float(f"{value:.12g}") + 0.0)
    if text in ("inf", "-inf"):
        return text.replace("inf", ".inf")
    # YAML 1.1 takes 1e-05 for a word.
    return text.replace("e", ".0e") if "e" in text and "." not in text else text


def flow(values: Iterable[str | float | int | None]) -> list[str]:
    """A flow list as lines, broken between entries only; the first is to follow its key."""
    items = [scalar(value) for value in values]
    one = f"[{', '.join(items)}]"
    if len(one) <= WIDTH - 24:
        return [one]
    lines, line = ["["], "   "
    for item in items:
        if len(line) + len(item) + 2 > WIDTH and line.strip():
            lines.append(line)
            line = "   "
        line += f" {item},"
    return [*lines, line, "  ]"]


def comment(text: str) -> str:
    """Text of any origin behind a `#`: it cannot end its line."""
    return one_line(text)


def entry(key: str, values: Sequence[str | float | int | None], indent: str = "") -> list[str]:
    """`key: [...]` as lines."""
    first, *rest = flow(values)
    return [f"{indent}{key}: {first}", *(f"{indent}{line}" for line in rest)]
