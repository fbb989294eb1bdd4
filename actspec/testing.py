"""For the tests of projects that have a spec: their files and configurations hold its figures.

from actspec.testing import assert_agrees
def test_actuators():
    assert_agrees("robots/go2.yaml", "assets/go2.xml")
"""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, NoReturn, SupportsFloat

from actspec.diagnostics import AuditError, Collector, Diagnostic, listed
from actspec.fields import FIELDS, Role
from actspec.readings.compare import COPIED, Deviation, Figure, compare, same, times
from actspec.readings.motor_names import NAMELESS, names_wanted
from actspec.units import format_quantity

if TYPE_CHECKING:
    from actspec.audit.case import Case
    from actspec.ir import ActuatorSet
    from actspec.readings.artifact import Artifact, FileReading
    from actspec.readings.dynamics import RobotDynamics
    from actspec.spec.validate import Spec

__all__ = ["Comparison", "assert_agrees", "compared"]

Joints = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Comparison:
    """A spec beside one file or object.

    Attributes:
        spec: What the spec is called.
        other: What is held to it is called.
        count: How many figures were compared, joints times fields.
        differences: Joints, and a figure in which they alike differ from the spec.
        missing: Joints of the spec that the other has not.
        unknown: Joints, and a figure of the spec that the other does not state, so that it is not compared.
        undriven: Joints of the spec that no actuator drives in the other, where others have one.
        periods: Control period of the other and of the spec [s], where both state it and they differ.
        not_taken: What the other's reader cannot take as it is written, of the figures that are compared: text for a
            number, a list with more values than names, or without names.
        faster: Joints, a URDF's velocity limit of twice their no-load speed or more, and that speed, where the spec
            states no velocity limit.
    """

    spec: str
    other: str
    count: int
    differences: tuple[tuple[Joints, Deviation], ...]
    missing: Joints
    unknown: tuple[tuple[Joints, Deviation], ...]
    undriven: Joints = ()
    periods: tuple[Figure, Figure] | None = None
    faster: tuple[tuple[Joints, Figure, Figure], ...] = ()
    not_taken: tuple[Diagnostic, ...] = ()

    def __str__(self) -> str:
        return "\n".join((*self.wrong(), *self.left_out()))

    def wrong(self) -> list[str]:
        """A line for each figure that differs or is not read, for the control period, and for joints not driven."""
        lines = [f"{', '.join(joints)}: {_words(one)}" for joints, one in self.differences]
        for joints, mine, wanted in self.faster:
            whose = "it turns" if len(joints) == 1 else "they turn"
            lines.append(
                f"{', '.join(joints)}: the velocity limit is {_shown(mine)}, and by the spec {whose} at "
                f"{_shown(wanted)} without load{times(mine.value, wanted.value)}"
            )
        for joints, what in ((self.undriven, "no actuator drives it in"), (self.missing, "not in")):
            if joints:
                lines.insert(0, f"{', '.join(joints)}: {what} {self.other}")
        if self.periods is not None:
            mine, wanted = self.periods
            ratio = times(mine.value, wanted.value)
            lines.insert(0, f"the control period is {_shown(mine)}, {_shown(wanted)} in the spec{ratio}")
        for item in self.not_taken:
            where = f"{item.where}: " if item.where else ""
            lines.append(f"{item.span}: {where}{item.message} ({item.code})")
        return lines

    def left_out(self) -> list[str]:
        """A line for each figure that is not compared."""
        return [
            f"{', '.join(joints)}: the {_noun(one)} is not stated, {_shown(one.reference)} in the spec"
            for joints, one in self.unknown
        ]


def assert_agrees(
    spec: Spec | ActuatorSet | str | os.PathLike[str],
    cfg_or_file: object,
    *,
    tolerance: float = COPIED,
    joints: str | Sequence[str] = ".*",
    fields: str | Sequence[str] = (),
    missing: Literal["ignore", "error"] = "ignore",
    robot: str | None = None,
    target: str | Sequence[str] = (),
) -> Comparison:
    """Assert that a file or an object has the figures that a spec states.

    A figure is compared where the spec states it and the file states it too, or runs it: a servo of an MJCF without
    `forcerange` has no limit, and one whose gain is not its kp another target. Figures are those at the joint, gears
    applied, in SI units.

    Args:
        spec: A spec, its path, or what `actspec.resolve` made of it.
        cfg_or_file: Path of an MJCF, URDF, cfg `.py`, deploy YAML or spec, which is read and never run; or an object:
            Isaac Lab's `ArticulationCfg` or its `actuators`, mjlab's `EntityCfg`, `EntityArticulationInfoCfg` or
            `Entity`, `mujoco.MjSpec` or `MjModel`.
        tolerance: Largest relative difference of equal figures.
        joints: Only these joints of the spec: a pattern, or several.
        fields: Only these figures, by their names in a spec: `kp`, `effort_limit`, `friction.viscous`, or several;
            default: all.
        missing: What becomes of figures that the file does not state: `ignore`, they are in the result; or `error`.
        robot: Name of the robot, where the file has several and it is not clear which one is meant; the file's or
            the spec's.
        target: What the file is for, `NAME==VERSION`, or several: `isaaclab==2.3` decides what its `friction` is. A
            release that actspec does not know yet is a `UserWarning` (AUD018 of the audit).

    Returns: What was compared, `str()` of which lists what was not.

    Raises:
        AssertionError: a figure or the control period differs, with both, their units and their places; a joint is
            missing, or has no actuator in a model where others have one; the file states a figure that its reader
            cannot take (AUD022 of the audit); nothing at all could be compared.
        ActspecError: the spec or the file cannot be read, or it is not known which robot is meant.
        TypeError: the spec, or the object, is none of those above.
        ValueError: an unknown field, a pattern of joints that is none, or a tolerance that is no number of 0 or more.
    """
    __tracebackhide__ = True  # pytest shows the caller
    if missing not in ("ignore", "error"):
        raise ValueError(f"missing is 'ignore' or 'error', got {missing!r}")
    found = compared(
        spec, cfg_or_file, tolerance=tolerance, joints=joints, fields=fields, robot=robot, target=target
    )
    lines = found.wrong() + (found.left_out() if missing == "error" else [])
    if lines:
        head = f"{found.other} does not agree with {found.spec}"
        raise AssertionError("\n  ".join((f"{head} ({found.count} figures compared):", *lines)))
    if not found.count:
        why = "\n  ".join(
            (f"no figure of {found.other} can be compared with {found.spec}:", *found.left_out())
        )
        raise AssertionError(why)
    return found


def compared(
    spec: Spec | ActuatorSet | str | os.PathLike[str],
    cfg_or_file: object,
    *,
    tolerance: float = COPIED,
    joints: str | Sequence[str] = ".*",
    fields: str | Sequence[str] = (),
    robot: str | None = None,
    target: str | Sequence[str] = (),
) -> Comparison:
    """What `assert_agrees` asserts, as a value; arguments and errors are the same, without the AssertionError."""
    from actspec.audit.build import case_of
    from actspec.audit.difference import read_all
    from actspec.audit.same_robot import of_robot, one_robot
    from actspec.audit.settings import beyond_known, named_versions
    from actspec.patterns import match_names
    from actspec.readings.dynamics import dynamics_of

    out = Collector()
    versions = named_versions([target] if isinstance(target, str) else target, out)
    out.raise_if_failed(AuditError)
    for item in beyond_known(versions):
        # pytest shows it with the test that calls `assert_agrees`.
        warnings.warn(f"{item.where}: {item.message} ({item.code}): {item.help}", stacklevel=3)
    if not (isinstance(tolerance, SupportsFloat) and 0.0 <= tolerance < math.inf):
        raise ValueError(f"tolerance is a number of 0 or more, got {tolerance!r}")
    names = _field_names((fields,) if isinstance(fields, str) else fields)
    ours = _resolved(spec)
    if isinstance(cfg_or_file, (str, os.PathLike)):
        theirs = read_all((os.fspath(cfg_or_file),), {})
    else:
        theirs = _live(cfg_or_file)
    readings = of_robot((ours, *theirs), robot)
    case = case_of(readings, versions, {}, ours.path)
    pair = one_robot(case, len(readings[0].artifacts), len(readings[1].artifacts), robot)
    mine, other = (dynamics_of(case.artifacts[i], case.rows_of(i)) for i in pair)
    every = tuple(mine.joints)
    chosen: list[str] = []
    for pattern in [joints] if isinstance(joints, str) else joints:
        chosen += match_names(pattern, every) or _no_joint(pattern, every, mine.file)
    found = _comparison(mine, other, tuple(dict.fromkeys(chosen)), names, tolerance)
    found = replace(
        found, not_taken=_not_taken(theirs[0], case.artifacts[pair[1]], names, chosen, bool(fields))
    )
    if "velocity_limit" in names:
        found = replace(found, faster=_faster(case, pair, chosen))
    ends = None if fields else _periods(*(case.artifacts[i] for i in pair))
    if ends is None:
        return found
    apart = not same(ends[0].value, ends[1].value, tolerance)
    return replace(found, count=found.count + 1, periods=ends if apart else None)


def _no_joint(pattern: str, joints: Joints, spec: str) -> NoReturn:
    raise ValueError(f"no joint of {spec} matches {pattern!r}; it has {listed(joints)}")


def _resolved(spec: Spec | ActuatorSet | str | os.PathLike[str]) -> FileReading:
    """A spec as a reading."""
    from actspec.api import resolve
    from actspec.audit.read import artifact_of
    from actspec.ir import ActuatorSet
    from actspec.readings.artifact import FileKind, FileReading

    actuators = spec if isinstance(spec, ActuatorSet) else resolve(spec)
    span = actuators.joints[0].span if actuators.joints else None
    path = os.fspath(spec) if isinstance(spec, (str, os.PathLike)) else span.path if span else actuators.robot
    return FileReading(path, FileKind.SPEC, None, (artifact_of(path, actuators),))


def _live(thing: object) -> tuple[FileReading, ...]:
    """An object as readings.

    Raises:
        TypeError: there is no reader for it.
    """
    from actspec.readings.live import read_live

    found = read_live(thing)
    if not found:
        raise TypeError(
            "a path, a cfg of Isaac Lab or mjlab, or a model of MuJoCo can be compared with a spec, got"
            f" {type(thing).__name__}"
        )
    return found


def _field_names(asked: Sequence[str]) -> tuple[str, ...]:
    """Fields of `FIELDS` that a spec has a key for; of these the asked ones."""
    every = {name: field.spec for name, field in FIELDS.items() if field.spec}
    wrong = [name for name in asked if name not in every.values()]
    if wrong:
        known = ", ".join(dict.fromkeys(every.values()))
        raise ValueError(f"a spec has no figure {wrong[0]!r}; it has {known}")
    return tuple(name for name, key in every.items() if not asked or key in asked)


def _comparison(
    spec: RobotDynamics,
    other: RobotDynamics,
    joints: Joints,
    fields: tuple[str, ...],
    tolerance: float,
) -> Comparison:
    from actspec.audit.difference import states
    from actspec.readings.dynamics import levelled

    count = 0
    found: dict[object, tuple[list[str], Deviation]] = {}
    left: dict[object, tuple[list[str], Deviation]] = {}
    bare: list[str] = []
    for joint in joints:
        theirs = other.joints.get(joint)
        if theirs is None:
            continue
        mine = levelled(spec.joints[joint], theirs)
        stated = [name for name in fields if name in mine.figures and mine.figures[name].stated]
        stated = [name for name in stated if mine.figures[name].value is not None]
        if joint in other.undriven and any(
            FIELDS[name].role is Role.DRIVE and mine.figures[name].value for name in stated
        ):
            bare.append(joint)
        shared = [name for name in stated if states(theirs, name, other.kind)]
        count += len(shared)
        for one in compare(theirs.figures, mine.figures, shared, tolerance):
            found.setdefault((one.field, one.value, one.expected), ([], one))[0].append(joint)
        for name in stated:
            if name not in shared:
                one = Deviation(name, None, mine.figures[name])
                left.setdefault((name, one.expected), ([], one))[0].append(joint)
    return Comparison(
        spec.file,
        _called(other),
        count,
        tuple((tuple(names), one) for names, one in found.values()),
        tuple(joint for joint in joints if joint not in other.joints),
        tuple((tuple(names), one) for names, one in left.values()),
        tuple(bare),
    )


def _faster(
    case: Case, pair: tuple[int, int], joints: Sequence[str]
) -> tuple[tuple[Joints, Figure, Figure], ...]:
    """See `Comparison.faster`; of equal figures the joints together."""
    from actspec.audit.rules.spec_pairs import faster_than_line, spec_joints

    found: dict[tuple[float | None, float | None], tuple[list[str], Figure, Figure]] = {}
    for joint in spec_joints(case):
        name, at = joint.rows[0].joint, (joint.spec.artifact, joint.rows[0].artifact)
        figures = faster_than_line(case, joint) if at == pair and name in joints else None
        if figures is not None:
            found.setdefault((figures[0].value, figures[1].value), ([], *figures))[0].append(name)
    return tuple((tuple(names), mine, wanted) for names, mine, wanted in found.values())


def _not_taken(
    reading: FileReading, other: Artifact, fields: Sequence[str], joints: Sequence[str], some: bool
) -> tuple[Diagnostic, ...]:
    """See `Comparison.not_taken`; not what the reader says of another robot of the file, of another field or joint.

    Of a model it says of what is no figure of a drive too, which is left where some fields are asked for.
    """
    from actspec.readings.artifact import FileKind
    from actspec.readings.deploy_keys import PER_JOINT

    own = {key: field for field, keys in PER_JOINT.items() for key in keys}
    others = {note for one in reading.artifacts if one.config is not None for note in one.config.notes}
    others -= set(other.config.notes) if other.config is not None else set()
    items = [*reading.not_taken]
    unnamed = [item for item in reading.diagnostics if item.code == NAMELESS]
    if unnamed and not items and other.config is not None and other.config.nameless_lists:
        keys = listed(item.where for item in unnamed)
        said = (
            f"no joint is named for {keys}, so they are not compared: add {names_wanted(other.config.motors)}"
        )
        items.append(replace(unnamed[0], where="", message=said))
    found = []
    for item in items:
        if other.robot is not None:
            asked = not some and (reading.kind is not FileKind.URDF or not item.where or item.where in joints)
        else:
            asked = own.get(item.where, fields[0]) in fields
        if asked and item not in others:
            found.append(item)
    return tuple(found)


def _periods(spec: Artifact, other: Artifact) -> tuple[Figure, Figure] | None:
    """The control period of the other and of the spec [s]; None where one of them does not state it."""
    from actspec.readings.dynamics import setting_place, settings_of

    found = []
    for artifact in (other, spec):
        period = settings_of(artifact).get("control_dt")
        if not isinstance(period, float):
            return None
        found.append(Figure(period, "s", setting_place(artifact, "control_dt"), True))
    return found[0], found[1]


def _called(robot: RobotDynamics) -> str:
    """The file, with the robot's name where the file's does not say it."""
    stem = os.path.splitext(os.path.basename(robot.file))[0]
    return robot.file if robot.name in ("", stem) else f"{robot.file} ({robot.name})"


def _words(one: Deviation) -> str:
    """`the effort limit is 23.5 N*m (cfg.py:12:3), 45.43 N*m (go2.yaml:40:9) in the spec (x0.517)`."""
    ratio = times(one.value, one.expected)
    return f"the {_noun(one)} is {_shown(one.figure)}, {_shown(one.reference)} in the spec{ratio}"


def _noun(one: Deviation) -> str:
    return FIELDS[one.field].noun


def _shown(figure: Figure | None) -> str:
    if figure is None:
        return "not stated"
    value = figure.value
    text = "unlimited" if value == math.inf else format_quantity(value, figure.unit)
    return f"{text} ({figure.place})"
