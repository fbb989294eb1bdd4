"""Static agreement of randomisation: the ranges in the files against those of the spec."""

from __future__ import annotations

import ast
import json
import math
import os
from collections.abc import Iterator
from typing import Any

from actspec.audit.artifact import RandomizedRange
from actspec.diagnostics import one_line
from actspec.files import NotRegular, TooLarge, read_regular
from actspec.ir import ActuatorSet, JointActuator, Randomization
from actspec.robot.view import RobotView
from actspec.sampling import own_ranges
from actspec.verify.agreement import Row
from actspec.verify.fields import broken
from actspec.verify.layout import TOLERANCE
from actspec.verify.readback import Asked, read_back
from actspec.verify.target import Target

MOST_BYTES = 16 << 20
"""Chosen: the largest such file seen has 100 kB."""


class _Unreadable(Exception):
    pass


def range_rows(target: Target, actuators: ActuatorSet, robot: RobotView) -> list[Row]:
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
            rows.append(broken(target, f"{target.path(file)} cannot be read: {err}"))
    return rows


def _read(path: str) -> bytes:
    try:
        return read_regular(path, MOST_BYTES)
    except (OSError, ValueError, NotRegular, TooLarge) as err:
        raise _Unreadable(getattr(err, "strerror", None) or str(err)) from err


def _json_rows(target: Target, file: str, actuators: ActuatorSet) -> Iterator[Row]:
    try:
        record = json.loads(_read(target.path(file)))
        joints = {str(entry["joint"]): entry for entry in record["joints"]}
    except (ValueError, KeyError, TypeError, RecursionError) as err:
        raise _Unreadable(f"it is no {file} that actspec writes ({type(err).__name__})") from err
    for actuator in actuators.joints:
        entry = joints.get(actuator.joint)
        if entry is None:
            yield _fault(target, actuator, "randomize", "VFY109", f"{file} does not have the joint")
            continue
        yield _range_row(target, actuator, file, entry)


def _range_row(target: Target, actuator: JointActuator, file: str, entry: Any) -> Row:
    asked = own_ranges(actuator)
    try:
        found = {str(one["field"]): one for one in entry["ranges"]}
        for field in dict.fromkeys((*asked, *found)):
            want, got = asked.get(field), found.get(field)
            if want is None or got is None:
                what = "is not in the spec" if want is None else "is missing"
                return _fault(target, actuator, f"randomize.{field}", "VFY110", f"{file}: the range {what}")
            wrong = _difference(want, got)
            if wrong is not None:
                return _fault(target, actuator, f"randomize.{field}", "VFY110", f"{file}: {wrong}")
    except (KeyError, TypeError, ValueError) as err:
        raise _Unreadable(f"{actuator.joint}: its ranges are none ({type(err).__name__})") from err
    return Row(target.name, actuator.group, actuator.joint, 1, "randomize", "", 0.0, 0.0, True)


def _difference(want: Randomization, got: Any) -> str | None:
    """What of a range is another one; None: nothing."""
    for name in ("operation", "distribution", "when", "per"):
        if got[name] != getattr(want, name):
            return f"{name} is {one_line(repr(got[name]))}, and should be {getattr(want, name)!r}"
    for name in ("low", "high"):
        value = float(got[name])
        if not math.isclose(value, getattr(want, name), rel_tol=TOLERANCE, abs_tol=1e-12):
            return f"{name} is {value:g}, and should be {getattr(want, name):g}"
    return None


def _python_rows(target: Target, file: str, actuators: ActuatorSet, robot: RobotView) -> Iterator[Row]:
    ours, theirs = (os.path.join(folder, file) for folder in (target.fresh, target.folder))
    trees = [_tree(path) for path in (ours, theirs)]
    if trees[0] == trees[1]:
        yield Row(target.name, "", "", len(actuators.joints), f"randomize ({file})", "", 0.0, 0.0, True)
        return
    fresh, built = (
        reading.ranges
        for reading in read_back(
            [Asked(ours, target.options), Asked(theirs, target.options)], actuators, robot
        )
    )
    wrong = list(_changed(fresh, built)) or ["its text is another one"]
    for text in wrong:
        yield Row(
            *(target.name, "", "", len(actuators.joints), f"randomize ({file})", "", None, 0.0, False),
            code="VFY110",
            message=f"{file}: {text}",
        )


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
    return f"{one_line(operation)} {low:g} to {high:g} ({one_line(distribution)})"


def _fault(target: Target, actuator: JointActuator, quantity: str, code: str, message: str) -> Row:
    return Row(
        *(target.name, actuator.group, actuator.joint, 1, quantity, "", None, 0.0, False),
        code=code,
        message=message,
    )
