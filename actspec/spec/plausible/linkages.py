"""Linkages: rows that do not fit the others, poses that no joint has, limits that the robot's file contradicts."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from actspec.diagnostics import Path, Span, listed
from actspec.ir import JointActuator, Origin
from actspec.spec.document import SourceMap
from actspec.spec.gears import Linkage
from actspec.spec.models import SpecModel
from actspec.spec.plausible.driven import AGREES, WITNESS
from actspec.spec.plausible.relations import DEGREE, FAR_ABOVE_FILE
from actspec.spec.plausible.table import Doubt, Found, at, by_number
from actspec.spec.plausible.witnesses import limits_of_file
from actspec.spec.values import SpecValue
from actspec.units import format_quantity

CODE = "SPEC195"
FEWEST = 4
"""Rows from which on a course can be told from them."""
NEIGHBOURS = 5.0
"""Two rows of which one is so many times the other say nothing of what lies between."""
POWER = 0.2
"""What a power of ten may differ by from what the rows beside it say [powers of ten]."""
BEYOND = 0.3
"""A pose of a table may be this far beyond the joint's range [rad or m], or a quarter of its width."""


def linkage_doubts(
    model: SpecModel,
    spans: SourceMap,
    joints: Sequence[JointActuator] = (),
    doubted: Collection[str | Span | None] = (),
) -> Iterator[Doubt]:
    """What can hardly be right about linkages: of each what its rows say, else its poses, else its strength.

    Args:
        model: What the spec says.
        spans: Where it says it.
        joints: The resolved spec; none: whatever the robot is.
        doubted: Numbers that are doubted themselves: where, and their spans.
    """
    by_name = {joint.joint: joint for joint in joints}
    strong: dict[Span | None, list[_Strength]] = {}
    for name, linkage in model.linkages.items():
        members = [by_name.get(joint) for joint in linkage.joints]
        found = list(_rows(linkage, ("linkages", name, "table"), spans))
        found = found or list(by_number(_poses(name, linkage, members, spans)))
        yield from found
        for joint in () if found else members:
            if joint is not None and (strength := _strength(name, joint)) is not None:
                strong.setdefault(joint.effort_limit.span, []).append(strength)
    for span, strengths in strong.items():
        if span not in doubted:
            yield from _too_strong(strengths, model, spans)


def _rows(linkage: Linkage, path: Path, spans: SourceMap) -> Iterator[Doubt]:
    """Rows of a table that do not fit the others."""
    rows = linkage.table or ()
    if len(rows) < FEWEST:
        return
    if len(linkage.joints) > 1:
        yield from _handed(linkage, path, spans)
        return
    places = [row.at[0] for row in rows]
    disordered = list(_out_of_order(places, path, spans))
    yield from disordered or _off_course(places, [row.jacobian[0][0] for row in rows], path, spans)


def _poses(
    name: str, linkage: Linkage, joints: Sequence[JointActuator | None], spans: SourceMap
) -> Iterator[Found]:
    """Poses that lie far outside of their joints' ranges."""
    poses: list[tuple[Path, tuple[SpecValue, ...]]] = [
        (("linkages", name, "table", index, "at"), row.at) for index, row in enumerate(linkage.table or ())
    ]
    if isinstance(linkage.at, tuple):
        poses.append((("linkages", name, "at"), linkage.at))
    for index, joint in enumerate(joints):
        if joint is None or joint.position_range is None:
            continue
        low, high = joint.position_range
        slack = max(BEYOND, 0.25 * (high - low))
        for path, pose in poses:
            value, size = pose[index], pose[index].value or 0.0
            beyond = max(low - size, size - high)
            if slack < beyond < math.inf:
                shown = " to ".join(format_quantity(end, value.unit, 4) for end in (low, high))
                message = f"a pose of {value.written} is far outside of the joint's range, {shown}"
                help = _slip(value, low - slack, high + slack)
                yield Found(at(spans, CODE, message, (*path, index), help), joint.joint, beyond)


@dataclass(frozen=True, slots=True)
class _Strength:
    """A limit by a linkage, beside that of the robot's file.

    Attributes:
        linkage: Name of the linkage.
        joint: The joint.
        said: The limit of the file.
        ratio: The limit over that.
    """

    linkage: str
    joint: JointActuator
    said: float
    ratio: float

    @property
    def far(self) -> bool:
        """Whether it is far from the file's."""
        return not 1.0 / WITNESS < self.ratio < WITNESS

    @property
    def broken(self) -> bool:
        """Whether it is a power of ten off, or far above."""
        power = math.log10(self.ratio)
        near = abs(power - round(power)) <= POWER
        return self.far and (near or self.ratio > FAR_ABOVE_FILE)


def _strength(name: str, joint: JointActuator) -> _Strength | None:
    """A joint's limit by its linkage; None where it is stated, or the file has none."""
    limit, (said, _) = joint.effort_limit, limits_of_file(joint)
    if limit.origin is not Origin.DERIVED or not limit.value or not said:
        return None
    ratio = limit.value / said
    return _Strength(name, joint, said, ratio) if 0.0 < ratio < math.inf else None


def _too_strong(strengths: Sequence[_Strength], model: SpecModel, spans: SourceMap) -> Iterator[Doubt]:
    """Limits of one motor's joints: where those of other linkages agree with the file, it is no matter of the motor."""
    agrees = any(1.0 / AGREES < one.ratio < AGREES for one in strengths)
    # Beside one that agrees it need not be a power of ten: a gear that is counted twice is 16.
    broken = [one for one in strengths if (one.far if agrees else one.broken)]
    names = list(dict.fromkeys(one.linkage for one in broken))
    proved = len(names) < len({one.linkage for one in strengths})
    for name in names if proved else names[:1]:
        linkage = model.linkages[name]
        key = next(key for key in ("table", "jacobian", "factor") if getattr(linkage, key) is not None)
        place: Path = ("linkages", name, key)
        worst = max((one for one in broken if one.linkage == name), key=lambda one: abs(math.log(one.ratio)))
        limit = worst.joint.effort_limit
        motor = next(
            (
                ("motors", motor, field)
                for motor in linkage.motors
                for field in ("peak_torque", "continuous_torque", "stall_torque")
                if spans.value(("motors", motor, field)) == limit.span
            ),
            None,
        )
        if proved:
            help = f"look at the {key} here: other linkages of this motor agree with the file"
        elif len(names) > 1 and motor is not None:
            first = spans.value(place)
            place, help = motor, f"look at the torque here, or at the linkages {listed(names)} ({first})"
        else:
            help = f"look at the {key} here, or the torque of the motor ({limit.span})"
        message = (
            f"{worst.joint.joint}: {format_quantity(limit.value, limit.unit, 4)} by the linkage '{name}' is "
            f"{format_quantity(max(worst.ratio, 1.0 / worst.ratio), '', 3)} times "
            f"{'above' if worst.ratio > 1.0 else 'below'} the {format_quantity(worst.said, limit.unit, 4)} of the "
            "robot's file"
        )
        yield at(spans, CODE, message, place, help, *(() if motor is None else (motor,)))


def _out_of_order(places: Sequence[SpecValue], path: Path, spans: SourceMap) -> Iterator[Doubt]:
    """The one pose without which all are in order, if a slip in it puts it there."""
    sizes = [value.value or 0.0 for value in places]
    if _ordered(sizes):
        return
    for index, value in enumerate(places):
        rest = [*sizes[:index], *sizes[index + 1 :]]
        if not _ordered(rest):
            continue
        step = abs(rest[-1] - rest[0]) / (len(rest) - 1)
        up = rest[-1] > rest[0]
        before = rest[index - 1] if index else rest[0] - 3.0 * step * (1 if up else -1)
        after = rest[index] if index < len(rest) else rest[-1] + 3.0 * step * (1 if up else -1)
        low, high = min(before, after), max(before, after)
        help = _slip(value, low, high)
        if help is None:
            continue
        near = " and ".join(
            places[other].written for other in (index - 1, index + 1) if 0 <= other < len(places)
        )
        message = f"a pose of {value.written} is out of the order of the table, beside {near}"
        yield at(spans, CODE, message, (*path, index, "at", 0), help)
        return


def _ordered(sizes: Sequence[float]) -> bool:
    return all(a < b for a, b in pairwise(sizes)) or all(a > b for a, b in pairwise(sizes))


def _slip(value: SpecValue, low: float, high: float) -> str | None:
    """What puts a position between two others: another unit, its sign, its point."""
    size, unit = value.value or 0.0, value.unit
    small, other = (DEGREE, "deg") if value.unit == "rad" else (1e-3, "mm")
    slips = [
        (-1.0, "is the sign wrong? Then it is {}"),
        (small, f"is it in {other}? Then write {size:g} {other}, {{}}"),
    ]
    slips += [(10.0**power, "did you mean {}?") for power in (-1, 1, -2, 2)]
    for factor, words in slips:
        if low < size * factor < high:
            return words.format(format_quantity(size * factor, unit, 4))
    return None


def _off_course(
    places: Sequence[SpecValue], speeds: Sequence[SpecValue], path: Path, spans: SourceMap
) -> Iterator[Doubt]:
    """The one row with another sign than all, or a power of ten off what the rows beside it say."""
    order = sorted(range(len(places)), key=lambda index: places[index].value or 0.0)
    xs = [places[index].value or 0.0 for index in order]
    ys = [speeds[index].value or 0.0 for index in order]
    if 0.0 in ys or not all(map(math.isfinite, (*xs, *ys))) or not _ordered(xs):
        return
    found: list[tuple[float, int, float]] = []
    for index, y in enumerate(ys):
        others = [*ys[:index], *ys[index + 1 :]]
        if len({math.copysign(1.0, other) for other in others}) > 1:
            continue
        meant = _beside(xs, ys, index)
        if meant is None:
            continue
        if y * meant < 0.0:
            # Past its dead point a linkage turns the other way: at an end it may.
            if 0 < index < len(ys) - 1 or 4.0 * abs(y + meant) < abs(y - meant):
                found.append((0.0, index, -1.0))
            continue
        far = math.log10(y / meant)
        power = round(far)
        if power and abs(far - power) < POWER:
            found.append((abs(far - power), index, 10.0**-power))
    if not found:
        return
    _, index, factor = min(found)
    row = order[index]
    value = speeds[row]
    near = " and ".join(
        speeds[order[other]].written for other in (index - 1, index + 1) if 0 <= other < len(ys)
    )
    right = format_quantity((value.value or 0.0) * factor, value.unit, 6)
    message = f"a Jacobian of {value.written} at {places[row].written}, beside {near}"
    if factor < 0.0:
        message += ": the joint would be driven the other way there"
    yield at(spans, CODE, message, (*path, row, "jacobian", 0, 0), f"did you mean {right}?")


def _beside(xs: Sequence[float], ys: Sequence[float], index: int) -> float | None:
    """What the rows beside one say of it, on a straight line; None where they say nothing."""
    last = len(xs) - 1
    one, two = (index - 1, index + 1) if 0 < index < last else (1, 2) if index == 0 else (last - 1, last - 2)
    if ys[one] * ys[two] <= 0.0 or not 1.0 / NEIGHBOURS < ys[one] / ys[two] < NEIGHBOURS:
        return None
    meant = ys[one] + (ys[two] - ys[one]) * (xs[index] - xs[one]) / (xs[two] - xs[one])
    # Beyond an end it may come near a dead point, where every size is possible.
    return meant if meant * ys[one] > 0.0 and abs(meant) > 0.5 * abs(ys[one]) else None


def _handed(linkage: Linkage, path: Path, spans: SourceMap) -> Iterator[Doubt]:
    """The one pose at which two motors would move two joints mirrored: between them lies one without an inverse."""
    rows = linkage.table or ()
    if len(linkage.joints) != 2 or any(len(row.jacobian) != 2 for row in rows):
        return
    signs = []
    for row in rows:
        (a, b), (c, d) = ([entry.value or 0.0 for entry in line] for line in row.jacobian)
        signs.append(a * d - b * c > 0.0)
    for index, sign in enumerate(signs):
        if signs.count(sign) == 1:
            message = "the determinant of this Jacobian has another sign than that of all other poses"
            help = "is the sign of an entry wrong? Between the two there would be a pose without limits"
            yield at(spans, CODE, message, (*path, index, "jacobian"), help)
