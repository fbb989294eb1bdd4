"""Means of PACE (leggedrobotics/pace-sim2real): a vector without names, fitted in Isaac Lab by CMA-ES.

`mean_NNN.pt` is blocks of one number a joint, then one delay for all: armature, viscous friction, friction, bias, delay
in physics steps, of which the simulation takes the whole ones. What bias, delay and friction mean changed:

| commits | delay | bias b | friction |
|---|---|---|---|
| bb8c6cc to 2d1d85f | the command's | drive at q + b, compared at q - b | static alone |
| 5576994 to 056d106 | the torque's | the same | static alone |
| b49895a to f8ec8b8 | the torque's | q = q_measured + b | static alone |
| b09382f | the torque's | q = q_measured + b | static and sliding |
| 7ad0f45 (v0.2.0) | the command's | q = q_measured + b | both; with a ratio block, sliding = ratio x static |

A bias of actspec is q_measured = q + bias, so it is -b. Source: cma_es.py and pace_actuator.py at these commits; of
v0.2.0 its release notes, which keep the torque's delay as `delay_mode="effort"`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from actspec.diagnostics import Collector, Span, listed, nearest
from actspec.ir import tidy
from actspec.logs import LogError
from actspec.sysid.foreign.figures import Figure, Found, Given, JointFound, Options, take, unit_of
from actspec.units import format_quantity

OPTIONS = ("joints", "layout", "step", "commit")
EXPORT = (
    "write its numbers as text, with torch: python -c \"import torch; print(*torch.load('mean_100.pt', "
    "weights_only=True, map_location='cpu').tolist(), sep='\\n')\" > mean_100.csv"
)
BLOCKS = ("armature", "viscous", "friction", "ratio", "bias", "delay", "effort_delay")
"""Words of a layout; `effort_delay` is a delay of the torque by configuration."""
DELAYS = ("delay", "effort_delay")
"""Blocks of one number."""
USUAL = "armature,viscous,friction,bias,delay"


@dataclass(frozen=True, slots=True)
class Era:
    """What a vector meant in some commits.

    Attributes:
        commits: The commits, short.
        command: Whether the delay is the command's; else the torque's.
        bias: Whether the bias is that of one encoder.
        sliding: Whether the friction is the sliding one too.
    """

    commits: tuple[str, ...]
    command: bool
    bias: bool
    sliding: bool


ERAS = (
    Era(("bb8c6cc", "2af45c6", "7e815b6", "7c5b5f6", "7263d68", "2d1d85f"), True, False, False),
    Era(("5576994", "9ae26dd", "7888e66", "a615152", "056d106"), False, False, False),
    Era(
        (
            "b49895a",
            "d520822",
            "76ecc90",
            "41f6608",
            "013cc13",
            "34fca99",
            "7e028a9",
            "439c80e",
            "005c8a7",
            "v0.1.0",
            "a636e5e",
            "f8ec8b8",
        ),
        False,
        True,
        False,
    ),
    Era(("b09382f",), False, True, True),
    Era(("7ad0f45", "v0.2.0"), True, True, True),
)


def read(given: Given, options: Options, collector: Collector) -> Found:
    """A vector, one number a line or separated by commas."""
    numbers = _numbers(given)
    _needed(options, collector)
    collector.raise_if_failed(LogError)
    era = _era(options.commit)
    step, n = options.step or 0.0, len(options.joints)
    expected = sum(1 if block in DELAYS else n for block in options.layout)
    if len(numbers) != expected:
        parts = " + ".join("1" if block in DELAYS else str(n) for block in options.layout)
        raise LogError.of(
            "SYS072",
            f"has {len(numbers)} numbers; the layout {','.join(options.layout)} of {listed(options.joints)} makes "
            f"{parts} = {expected}",
            Span(given.path),
            help="name every joint of `joint_order`, and the blocks that were fitted",
        )
    joints = {name: JointFound() for name in options.joints}
    friction: dict[str, tuple[float, int]] = {}
    ratios: dict[str, float] = {}
    at = 0
    for block in options.layout:
        if block in DELAYS:
            line, mean = numbers[at]
            at += 1
            if mean < 0.0:
                collector.error("SYS072", f"the delay is {mean}, below 0", span=Span(given.path, line))
            else:
                _delay(joints, int(mean), mean, step, era.command and block == "delay")
            continue
        for name in options.joints:
            line, value = numbers[at]
            at += 1
            if block != "bias" and value < 0.0:
                message = f"the {block} of {name} is {value}, below 0"
                help = "is the layout another one, or the file?"
                collector.error("SYS072", message, span=Span(given.path, line), help=help)
            elif block == "ratio" and value > 1.0:
                message = f"the ratio of {name} is {value}: sliding friction is at most the static one"
                collector.error(
                    "SYS072", message, span=Span(given.path, line), help="is the layout another one?"
                )
            elif block == "friction":
                friction[name] = (value, line)
            elif block == "ratio":
                ratios[name] = value
            elif block == "bias" and era.bias:
                note = f"PACE's {value} has the other sign: q = q_measured + b"
                joints[name].figures["encoder_bias"] = Figure(
                    -value + 0.0, unit_of("encoder_bias"), note=note
                )
            elif block == "bias":
                joints[name].left_out["encoder_bias"] = (
                    f"{value} rad at {options.commit[:7]}: the drive adds it, the comparison subtracts it"
                )
            elif block == "viscous":
                take(joints[name], "friction.viscous", value, Span(given.path, line), collector)
            else:
                joints[name].figures[block] = Figure(value, unit_of(block))
    for name, (value, line) in friction.items():
        span = Span(given.path, line)
        _friction(joints[name], value, ratios.get(name), era, options.commit, span, collector)
    _tell(joints, given, step, collector)
    return Found(given, "pace", options.commit, joints)


def _needed(options: Options, collector: Collector) -> None:
    """What the vector does not say."""
    if not options.joints:
        help = "--joint LF_HAA LF_HFE ..., as in `joint_order` of the fit"
        collector.error(
            "SYS071", "the numbers have no names: which joints, in which order?", where="--joint", help=help
        )
    if not options.layout:
        collector.error("SYS071", "which blocks has the vector?", where="--layout", help=f"--layout {USUAL}")
    for block in options.layout:
        if block not in BLOCKS or options.layout.count(block) > 1:
            guess = nearest(block, BLOCKS)
            help = (
                f"did you mean '{guess}'?"
                if guess and guess != block
                else f"blocks: {', '.join(BLOCKS)}, each once"
            )
            collector.error("SYS071", f"'{block}' is no block of a vector", where="--layout", help=help)
    if "ratio" in options.layout and "friction" not in options.layout:
        collector.error("SYS071", "`ratio` is of the block `friction`, which is not there", where="--layout")
    if set(DELAYS) <= set(options.layout):
        collector.error("SYS071", "a vector has one delay", where="--layout")
    if not options.step:
        help = "--step '2.5 ms', `sim.dt` of the fit"
        collector.error("SYS071", "the delay counts steps: of which length?", where="--step", help=help)
    if not options.commit:
        help = "--commit f8ec8b8, of the checkout that made the fit"
        message = "bias, delay and friction changed their meaning from version to version: which was it?"
        collector.error("SYS071", message, where="--commit", help=help)


def _era(commit: str) -> Era:
    for era in ERAS:
        if any(commit.startswith(known) for known in era.commits):
            return era
    known = [name for era in ERAS for name in era.commits]
    raise LogError.of(
        "SYS071",
        f"what bias, delay and friction mean at {commit[:40]} is not known here",
        where="--commit",
        help=f"known commits: {listed(known, len(known))}",
    )


def _numbers(given: Given) -> list[tuple[int, float]]:
    """Line and value of each number."""
    try:
        text = given.data.decode("utf-8-sig")
    except UnicodeDecodeError as err:
        raise LogError.of("SYS070", "is no text", Span(given.path), help=EXPORT) from err
    found = []
    for line, row in enumerate(text.strip().strip("[]").splitlines(), 1):
        for cell in row.replace(";", ",").split(","):
            if not cell.strip():
                continue
            try:
                value = float(cell)
            except ValueError:
                value = math.nan
            if not math.isfinite(value):
                message = f"'{cell.strip()[:40]}' is no number"
                raise LogError.of("SYS072", message, Span(given.path, line), help=EXPORT)
            found.append((line, value))
    return found


def _friction(
    joint: JointFound,
    value: float,
    ratio: float | None,
    era: Era,
    commit: str,
    span: Span,
    collector: Collector,
) -> None:
    """Static friction, sliding friction, or both in one number."""
    if ratio is not None:
        take(joint, "friction.coulomb", tidy(ratio * value), span, collector, f"{ratio} x static")
    elif not era.sliding:
        joint.left_out["friction.coulomb"] = (
            f"PACE at {commit[:7]} fits static friction alone; the sliding one stayed at the robot's configuration"
        )
    take(
        joint,
        "friction.coulomb" if era.sliding and ratio is None else "friction.static",
        value,
        span,
        collector,
    )


def _delay(joints: dict[str, JointFound], steps: int, mean: float, step: float, command: bool) -> None:
    late = tidy(steps * step)
    words = f"{steps} steps of {format_quantity(step, 's')} (mean {mean})"
    for joint in joints.values():
        if command:
            joint.figures["delay"] = Figure(late, unit_of("delay"), note=words)
        else:
            joint.left_out["delay"] = (
                f"{words} = {format_quantity(late, 's')} from the drive's torque to the joint; a spec's delay is the "
                "command's, behind which the drive sees the joint as it is"
            )


def _tell(joints: dict[str, JointFound], given: Given, step: float, collector: Collector) -> None:
    left = dict.fromkeys(field for joint in joints.values() for field in joint.left_out)
    first = next(iter(joints.values()))
    for field in left:
        collector.warning("SYS073", f"{field} is left out: {first.left_out[field]}", span=Span(given.path))
    collector.info(
        "SYS074",
        f"figures of PhysX with a step of {format_quantity(step, 's')} and of the gains in its configuration; without "
        "standard deviations, because CMA-ES gives none",
        span=Span(given.path),
    )
