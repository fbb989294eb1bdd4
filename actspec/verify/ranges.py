"""Static agreement of randomisation: the ranges in the files against those of the spec."""

from __future__ import annotations

import ast
import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from actspec.diagnostics import Span, one_line
from actspec.fields import BY_SPEC, FIELDS
from actspec.files import FAULTS, read_regular
from actspec.ir import ActuatorSet, JointActuator, Randomization
from actspec.readings.artifact import RandomizedRange
from actspec.readings.compare import same
from actspec.robot.view import RobotView
from actspec.sampling import own_ranges
from actspec.units import format_number
from actspec.verify.agreement import Row, TargetFiles
from actspec.verify.classify import WrongFigure, classify
from actspec.verify.fields import broken
from actspec.verify.layout import TOLERANCE, figure_text
from actspec.verify.readback import Asked, read_back

MOST_BYTES = 16 << 20
"""Chosen: the largest such file seen has 100 kB."""


class _Unreadable(Exception):
    pass


def range_rows(target: TargetFiles, actuators: ActuatorSet, robot: RobotView) -> list[Row]:
    """Rows of a target's files of ranges.

    The JSON is held to the spec; events and functions are held to what actspec writes, whose approximations
    are known: events by their ranges, a function by its syntax, remarks aside.
    """
    rows: list[Row] = []
    for file in target.files:
        try:
            if file.endswith(".json"):
                rows += _json_rows(target, file, actuators)
            elif file.endswith(".py"):
                rows += _python_rows(target, file, actuators, robot)
        except _Unreadable as err:
            row = broken(target, f"the file cannot be read: {err}")
            rows.append(replace(row, place=Span(target.path(file))))
    return rows


def _read(path: str) -> bytes:
    try:
        return read_regular(path, MOST_BYTES)
    except FAULTS as err:
        raise _Unreadable(getattr(err, "strerror", None) or str(err)) from err


def _json_rows(target: TargetFiles, file: str, actuators: ActuatorSet) -> Iterator[Row]:
    text = _read(target.path(file)).decode("utf-8", "replace")
    try:
        record = json.loads(text)
        joints = {str(entry["joint"]): entry for entry in record["joints"]}
        nominal = {name: _nominal(entry) for name, entry in joints.items()}
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError, RecursionError) as err:
        raise _Unreadable(f"it is no {file} that actspec writes ({type(err).__name__})") from err
    fresh = json.loads(_read(os.path.join(target.fresh, file)))
    ours = {entry["joint"]: entry for entry in fresh["joints"]}
    asked = {name: _nominal(entry) for name, entry in ours.items()}
    for actuator in actuators.joints:
        name = actuator.joint
        if name not in joints:
            yield target.fault("randomize", "VFY109", f"{file} does not have the joint", actuator=actuator)
            continue
        row, word = _range_row(target, actuator, file, joints[name])
        ranges = row if row.ok else replace(row, place=_place(target, file, text, name, word))
        yield ranges
        units = {field: str(one["unit"]) for field, one in ours[name]["nominal"].items()}
        values = [
            replace(row, place=_place(target, file, text, name, f'"{row.quantity}": {{'))
            for row in _nominal_rows(target, actuator, asked, nominal, units)
        ]
        yield from values
        if ranges.ok and not values and _rest(joints[name]) != _rest(ours[name]):
            wrong = target.fault("randomize", "VFY110", "a unit or a word differs", actuator=actuator)
            yield replace(wrong, place=_place(target, file, text, name, '"joint"'))
    if _rest(record) != _rest(fresh):
        what, place = "the head of the file differs", Span(target.path(file))
        yield target.fault(f"randomize ({file})", "VFY110", what, joints=len(joints), place=place)


def _nominal(entry: Any) -> dict[str, float | None]:
    """Nominal values of a joint, by the words of figures."""
    found = {}
    for name, one in entry["nominal"].items():
        value = one["value"]
        found[_figure_of(name)] = None if value is None else float(value)
    return found


def _nominal_rows(
    target: TargetFiles,
    actuator: JointActuator,
    asked: Mapping[str, Mapping[str, float | None]],
    found: Mapping[str, Mapping[str, float | None]],
    units: Mapping[str, str],
) -> Iterator[Row]:
    """Rows of nominal values that are other ones."""
    joint = actuator.joint
    wanted, got = asked[joint], found[joint]
    for field in dict.fromkeys((*wanted, *got)):
        want, have = wanted.get(field), got.get(field)
        if same(want, have, TOLERANCE):
            continue
        everywhere = {name: (asked[name].get(field), found.get(name, {}).get(field)) for name in asked}
        code, reason = classify(WrongFigure(field, want, have, wanted, got, everywhere))
        name = FIELDS[field].spec
        unit = units.get(name, "")
        should = f"{figure_text(have, unit)}, and should be {figure_text(want, unit)}"
        yield target.fault(
            name,
            code,
            one_line(f"the nominal {name} is {should}: {reason}"),
            actuator=actuator,
            unit=unit,
            max_error=None if want is None or have is None else abs(have - want),
            expected=want,
            got=have,
        )


def _place(target: TargetFiles, file: str, text: str, joint: str, word: str) -> Span:
    """Where a file of ours has a joint and then a word; the file where it is another one."""
    start = text.find(f'"joint": {json.dumps(joint)}')
    found = text.find(word, start)
    return Span(target.path(file), 0 if start < 0 or found < 0 else text.count("\n", 0, found) + 1)


def _rest(record: Any) -> dict[str, Any]:
    """What is compared neither by ranges nor by nominal values, nor follows from who wrote the file."""
    compared = ("ranges", "nominal", "joints", "tool", "spec_sha256")
    found = {name: value for name, value in record.items() if name not in compared}
    if "nominal" in record:
        found["units"] = [one.get("unit") for one in record["nominal"].values()]
        found["ranges"] = [{**one, "low": None, "high": None} for one in record["ranges"]]
    return found


def _range_row(target: TargetFiles, actuator: JointActuator, file: str, entry: Any) -> tuple[Row, str]:
    """A joint's row, and a word of the file at what is another one."""
    asked = own_ranges(actuator)
    try:
        found = {str(one["field"]): one for one in entry["ranges"]}
        for field in dict.fromkeys((*asked, *found)):
            want, got = asked.get(field), found.get(field)
            if want is None or got is None:
                what = "is not in the spec" if want is None else "is missing"
                text = f"the range of {one_line(field)} {what}"
                return target.fault(f"randomize.{field}", "VFY110", text, actuator=actuator), '"ranges"'
            wrong = _difference(want, got)
            if wrong is not None:
                text = f"of the range of {field}, {wrong}"
                return target.fault(
                    f"randomize.{field}", "VFY110", text, actuator=actuator
                ), f'"field": "{field}"'
    except (KeyError, TypeError, ValueError, OverflowError) as err:
        raise _Unreadable(f"{actuator.joint}: its ranges are none ({type(err).__name__})") from err
    return Row(target.name, actuator.group, actuator.joint, 1, "randomize", "", 0.0, 0.0, True), ""


def _difference(want: Randomization, got: Any) -> str | None:
    """What of a range is another one; None: nothing."""
    for name in ("operation", "distribution", "when", "per"):
        if got[name] != getattr(want, name):
            return f"{name} is {one_line(repr(got[name]))}, and should be {getattr(want, name)!r}"
    for name in ("low", "high"):
        value = float(got[name])
        if not same(value, getattr(want, name), TOLERANCE):
            return f"{name} is {format_number(value)}, and should be {format_number(getattr(want, name))}"
    return None


def _python_rows(target: TargetFiles, file: str, actuators: ActuatorSet, robot: RobotView) -> Iterator[Row]:
    ours, theirs = (os.path.join(folder, file) for folder in (target.fresh, target.folder))
    trees = [_tree(path) for path in (ours, theirs)]
    if trees[0] == trees[1]:
        yield target.right(f"randomize ({file})", joints=len(actuators.joints))
        return
    fresh, built = (
        reading.ranges
        for reading in read_back(
            [Asked(ours, target.options), Asked(theirs, target.options)], actuators, robot
        )
    )
    wrong = list(_changed(fresh, built)) or ["its text differs"]
    for text in wrong:
        count = len(actuators.joints)
        yield target.fault(f"randomize ({file})", "VFY110", text, joints=count, place=Span(theirs))


def _tree(path: str) -> str:
    """A Python file's syntax without remarks; it is not executed."""
    try:
        return ast.dump(ast.parse(_read(path)))
    except (SyntaxError, ValueError, RecursionError, MemoryError) as err:
        raise _Unreadable(f"it is no Python ({type(err).__name__})") from err


def _changed(fresh: tuple[RandomizedRange, ...], built: tuple[RandomizedRange, ...]) -> Iterator[str]:
    def key(one: RandomizedRange) -> tuple[object, ...]:
        return one.field, one.joints, one.actuators

    ours, theirs = ({key(one): one for one in ranges} for ranges in (fresh, built))
    for name in dict.fromkeys((*ours, *theirs)):
        want, got = ours.get(name), theirs.get(name)
        where = f"the range of {name[0]}"
        if want is None or got is None:
            yield f"{where} {'is one too many' if want is None else 'is missing'}"
            continue
        said, asked = ((one.operation, one.low, one.high, one.distribution) for one in (got, want))
        if said != asked:
            yield f"{where} is {_words(said)}, and should be {_words(asked)}"


def _words(one: tuple[str, float, float, str]) -> str:
    operation, low, high, distribution = one
    return f"{one_line(operation)} {format_number(low)} to {format_number(high)} ({one_line(distribution)})"


def _figure_of(name: str) -> str:
    """The figure that a nominal value of the spec is held to."""
    return "delay_nominal" if name == "delay" else BY_SPEC[name].name
