"""Static agreement of what is no figure of a joint: which joints there are, their orders, steps, classes."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from actspec.diagnostics import one_line
from actspec.files import NotRegular, TooLarge, read_regular
from actspec.ir import ActuatorSet
from actspec.readings.dynamics import SETTING_NOUNS
from actspec.units import format_quantity
from actspec.verify.agreement import Row, TargetFiles, alike
from actspec.verify.readback import FileFigures

TOLERANCE = 1e-6
"""Relative difference of equal figures. Source: MuJoCo's own form has six digits; the others have all."""


MAPS = ("order", "index")
"""Blocks of the file whose entries are lists over the joints."""

MOST_BYTES = 8 << 20
"""Chosen: as the audit's reader, which has taken the file before."""


def layout_rows(
    target: TargetFiles, actuators: ActuatorSet, fresh: FileFigures, built: FileFigures
) -> Iterator[Row]:
    """Rows of a file's joints, steps, order and settings; see `fields.field_rows`."""
    yield from _missing(target, actuators, fresh, built)
    yield from _settings(target, actuators, fresh, built)
    yield from _order(target, fresh, built)
    yield from _raw(target, actuators, fresh, built)


def driven(joint: str, fresh: FileFigures, built: FileFigures) -> bool:
    """Whether a file has a joint, with a drive where actspec writes one."""
    if joint not in built.figures:
        return joint not in fresh.figures
    return built.controls.get(joint) != "none" or fresh.controls.get(joint) == "none"


def figure_text(value: float | None, unit: str) -> str:
    """A figure with its unit; `none` where there is no limit."""
    if value is None:
        return "unknown"
    if math.isinf(value):
        return "none"
    return format_quantity(value, unit) if unit else f"{value:.6g}"


def _missing(
    target: TargetFiles, actuators: ActuatorSet, fresh: FileFigures, built: FileFigures
) -> Iterator[Row]:
    """Joints that the file does not have, or does not drive, though actspec writes them so."""
    for members in alike(actuators):
        gone = [a for a in members if not driven(a.joint, fresh, built)]
        if gone:
            had = gone[0].joint in built.figures
            what = f"the file does not {'drive' if had else 'have'} the joint"
            yield target.fault("joint", "VFY109", what, actuator=gone[0], joints=len(gone))


def _settings(
    target: TargetFiles, actuators: ActuatorSet, fresh: FileFigures, built: FileFigures
) -> Iterator[Row]:
    """What concerns the whole file: its steps."""
    step, decimation = actuators.physics_dt.value, actuators.decimation
    spec = {"physics_dt": step, "decimation": None if decimation is None else float(decimation)}
    spec["control_dt"] = None if step is None or decimation is None else step * decimation
    for name in dict.fromkeys((*fresh.settings, *built.settings)):
        expected = spec.get(name)
        if expected is None:
            expected = fresh.settings.get(name)
        got = built.settings.get(name)
        error = None if expected is None or got is None else abs(got - expected)
        tolerance = TOLERANCE * abs(expected or 0.0)
        ok = error is not None and error <= tolerance
        unit = "" if name == "decimation" else "s"
        asked, said = figure_text(expected, unit), figure_text(got, unit)
        message = f"the {SETTING_NOUNS.get(name, name)} is {said}, and should be {asked}"
        yield Row(
            *(target.name, "", "", 0, name, unit, error, tolerance, ok, expected, got),
            code=None if ok else "VFY110",
            message="" if ok else message,
        )


def _order(target: TargetFiles, fresh: FileFigures, built: FileFigures) -> Iterator[Row]:
    """The order of the joints, on which policies and deploy code depend."""
    if not fresh.order or set(fresh.order) - set(built.order):
        return
    kept = tuple(name for name in built.order if name in set(fresh.order))
    if kept == fresh.order:
        return
    wrong = next((a, b) for a, b in zip(fresh.order, kept, strict=False) if a != b)
    what = f"the order of the joints is another one: {wrong[1]} stands where {wrong[0]} belongs"
    row = target.fault("order", "VFY109", what, joints=len(kept))
    yield replace(row, joint=wrong[0])


def _raw(
    target: TargetFiles, actuators: ActuatorSet, fresh: FileFigures, built: FileFigures
) -> Iterator[Row]:
    """Drives and settings that are no number with a unit: class, network, scales."""
    for members in alike(actuators):
        wrong: dict[str, list[str]] = {}
        for actuator in members:
            joint = actuator.joint
            if joint not in built.figures or not driven(joint, fresh, built):
                continue
            ours, theirs = _written(fresh, joint), _written(built, joint)
            for name in dict.fromkeys((*ours, *theirs)):
                if ours.get(name) != theirs.get(name):
                    wrong.setdefault(name, []).append(joint)
        for name, joints in wrong.items():
            asked, got = (_written(reading, joints[0]).get(name) for reading in (fresh, built))
            what = one_line(f"{name} is {got!r}, and should be {asked!r}")
            first = next(one for one in members if one.joint == joints[0])
            yield target.fault(name, "VFY110", what, actuator=first, joints=len(joints))


def _written(reading: FileFigures, joint: str) -> dict[str, object]:
    return {"drive": reading.controls.get(joint), **reading.raw.get(joint, {})}


def order_rows(target: TargetFiles) -> Iterator[Row]:
    """Rows of each order and each map between two, held to what actspec writes."""
    ours, theirs = (
        _blocks(os.path.join(folder, target.files[0])) for folder in (target.fresh, target.folder)
    )
    for name in dict.fromkeys((*ours, *theirs)):
        asked, got = ours.get(name), theirs.get(name)
        same = asked == got
        message = "" if same else one_line(f"{name} is another one: {_first_difference(asked, got)}")
        yield Row(
            *(target.name, "", "", len(asked or ()), name, "", 0.0 if same else None, 0.0, same),
            code=None if same else "VFY109",
            message=message,
        )


def _blocks(path: str) -> dict[str, list[Any]]:
    """Lists of the blocks, by `order.isaac`; those that cannot be read are missing."""
    import yaml

    try:
        data = yaml.load(read_regular(path, MOST_BYTES), Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    except (OSError, ValueError, NotRegular, TooLarge, yaml.YAMLError, RecursionError):
        return {}
    if not isinstance(data, Mapping):
        return {}
    return {
        f"{block}.{name}": value
        for block in MAPS
        if isinstance(data.get(block), Mapping)
        for name, value in data[block].items()
        if isinstance(value, list)
    }


def _first_difference(asked: list[Any] | None, got: list[Any] | None) -> str:
    """The first entry that differs."""
    if asked is None or got is None:
        return "it is missing" if got is None else "actspec writes none"
    if len(asked) != len(got):
        return f"it has {len(got)} entries, and should have {len(asked)}"
    place, (want, have) = next(
        (i, pair) for i, pair in enumerate(zip(asked, got, strict=True)) if pair[0] != pair[1]
    )
    return f"entry {place} is {have!s:.60}, and should be {want!s:.60}"
