"""Parameters of MuJoCo's `mujoco.sysid`: `params_x_hat.yaml`, whose names are its author's; what they meant was Python.

Each entry is `{name, value, nominal, min_value, max_value, frozen}` with lists of numbers. Confidence intervals lie
beside it in a pickle, which is not read. Source: mujoco/sysid/_src/parameter.py and io.py of MuJoCo 4.0.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from actspec.diagnostics import Collector, Path, Span, listed, shortened
from actspec.logs import LogError
from actspec.spec.document import Document
from actspec.sysid.foreign.figures import Figure, Found, Given, JointFound, Options, document, number, unit_of
from actspec.units import format_quantity

OPTIONS = ("joints", "names", "step", "linear")
EXPORT = "give params_x_hat.yaml, which `mujoco.sysid.save_results` writes beside it"
WORDS: Mapping[str, tuple[str, ...]] = {
    "armature": ("armature",),
    "damping": ("friction.viscous",),
    "frictionloss": ("friction.coulomb",),
    "kp": ("kp",),
    "pgain": ("kp",),
    "kd": ("kd",),
    "kv": ("kd",),
    "dgain": ("kd",),
    "pdgain": ("kp", "kd"),
}
"""Last or first word of a parameter's name, beside a joint's, to the fields that its numbers are."""
MAPPED = ("armature", "friction.viscous", "friction.coulomb", "kp", "kd")
"""Fields that `--map` takes."""
KEYS = {"name", "value", "nominal", "min_value", "max_value", "frozen"}
NEAR_BOUND = 1e-3
"""Of the distance between the bounds. Source: the share within which mujoco.sysid moves a value off its bound."""


def read(given: Given, options: Options, collector: Collector) -> Found:
    """Parameters by name; those that no joint's figure is known for are left out, and named."""
    read = document(given, EXPORT)
    if not options.joints and not options.names:
        help = "--joint hip knee, whose names the parameters begin with; or --map NAME=JOINT.FIELD"
        raise LogError.of("SYS071", "which joints' parameters are these?", where="--joint", help=help)
    names = dict.fromkeys((*options.joints, *(joint for joint, _ in options.names.values())))
    joints = {name: JointFound() for name in names}
    for name in options.names:
        if name not in read.data:
            collector.error("SYS071", f"the file has no parameter '{shortened(name)}'", where="--map")
    left: dict[str, str] = {}
    moved = False
    for name, entry in read.data.items():
        if not isinstance(entry, dict) or set(entry) != KEYS:
            message = f"'{shortened(name)}' is no parameter of mujoco.sysid: {listed(sorted(KEYS))}"
            collector.error("SYS070", message, span=read.spans.value((name,)), help=EXPORT)
            continue
        values, low, high, nominal = (
            _flat(read, (name, key), entry[key], collector)
            for key in ("value", "min_value", "max_value", "nominal")
        )
        if collector.failed:
            continue
        moved = moved or (not entry["frozen"] and values != nominal)
        meant = _meaning(name, options)
        if meant is None:
            left[name] = f"{_written(values)}: of which joint and field?"
        elif entry["frozen"]:
            left[name] = f"{_written(values)}: frozen, it was not fitted"
        elif len(meant[1]) != len(values):
            left[name] = f"{len(values)} numbers: {' and '.join(meant[1])} take {len(meant[1])}"
        else:
            for field, value, ends in zip(meant[1], values, zip(low, high, strict=True), strict=True):
                _take(joints[meant[0]], field, value, ends, (name, "value"), read, options.linear, collector)
            continue
        if meant is not None:
            for field in meant[1]:
                joints[meant[0]].left_out[field] = left[name]
    if not collector.failed and (not moved or os.path.basename(given.path) == "params_x_0.yaml"):
        message = (
            "are the values before the fit: none differs from its nominal one"
            if not moved
            else "are before the fit"
        )
        collector.error("SYS070", message, span=Span(given.path), help="give params_x_hat.yaml")
    for name, why in left.items():
        collector.warning(
            "SYS073",
            f"'{shortened(name)}' is left out: {why}",
            span=read.spans.value((name,)),
            help=None
            if _meaning(name, options)
            else f"--map {shortened(name)}=JOINT.armature; fields: {', '.join(MAPPED)}",
        )
    _tell(joints, given, options, collector)
    taken = {
        name: joint for name, joint in joints.items() if joint.figures or joint.bounds_hit or joint.left_out
    }
    rest = [f"{shortened(name)} {why}" for name, why in left.items() if _meaning(name, options) is None]
    return Found(given, "mujoco.sysid", "", taken, f"left out: {'; '.join(rest)}" if rest else "")


def _meaning(name: str, options: Options) -> tuple[str, tuple[str, ...]] | None:
    """Joint and fields of a parameter: as `--map` says, else by the joint's name and a word of MuJoCo."""
    if name in options.names:
        joint, field = options.names[name]
        return joint, (field,)
    for joint in sorted(options.joints, key=len, reverse=True):
        for word, fields in WORDS.items():
            plain = re.escape(joint)
            if re.fullmatch(rf"{plain}[_./: -]{word}|{word}[_./: -]{plain}", name):
                return joint, fields
    return None


def _flat(read: Document, path: Path, given: Any, collector: Collector) -> list[float]:
    return [value for value in _numbers(read, path, given, collector) if value is not None]


def _numbers(read: Document, path: Path, given: Any, collector: Collector) -> Iterator[float | None]:
    if isinstance(given, list):
        for index, item in enumerate(given):
            yield from _numbers(read, (*path, index), item, collector)
    else:
        yield number(read, path, given, collector)


def _take(
    joint: JointFound,
    field: str,
    value: float,
    ends: tuple[float, float],
    path: Path,
    read: Document,
    linear: bool,
    collector: Collector,
) -> None:
    width = ends[1] - ends[0]
    if field in joint.figures or field in joint.bounds_hit:
        collector.error("SYS072", f"{field} has two parameters", span=read.spans.value(path))
    elif value < 0.0:
        collector.error("SYS072", f"{field} is {value}, below 0", span=read.spans.value(path))
    elif min(value - ends[0], ends[1] - value) <= NEAR_BOUND * width:
        joint.bounds_hit.append(field)
        collector.warning(
            "SYS073",
            f"'{shortened(str(path[0]))}' is left out: {value} is at a bound of the fit, {ends[0]} to {ends[1]}",
            span=read.spans.value(path),
            help="widen the bounds where they are not physical; else the data do not tell it",
        )
    else:
        joint.figures[field] = Figure(value, unit_of(field, linear))


def _written(values: Sequence[float]) -> str:
    return listed([str(value) for value in values], 4)


def _tell(joints: Mapping[str, JointFound], given: Given, options: Options, collector: Collector) -> None:
    """What an armature of MuJoCo is: that of its integrator."""
    rest = [name for name, joint in joints.items() if "armature" in joint.figures]
    if not rest:
        return
    sizes = []
    for name in rest:
        kd = joints[name].figures.get("kd")
        if options.step and kd is not None:
            size = format_quantity(options.step * kd.value / 2.0, unit_of("armature", options.linear), 3)
            sizes.append(f"{name} {size}")
    length = (
        f"h = {format_quantity(options.step, 's')}" if options.step else "h the step (--step), kd the drive's"
    )
    collector.info(
        "SYS074",
        f"armature of {listed(rest)} is that of MuJoCo's step: with implicitfast a joint moves as if it had h kd/2 "
        f"more, {length}" + (f": {', '.join(sizes)} is missing in it" if sizes else ""),
        span=Span(given.path),
        help="fit again with a smaller step where that is not small beside the armature",
    )
