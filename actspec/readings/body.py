"""What tells one machine from another with the same joints: how far these turn, and what its links weigh."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence

from actspec.fields import PLACEHOLDER
from actspec.readings.compare import DEGREES
from actspec.readings.joint import read_joints
from actspec.robot.view import RobotView

SHARE = 0.8
"""Joints that two artifacts must share, of the smaller one, and figures on which two models must agree. Chosen: a G1 of
23 joints and one of 29 share all 23; a hand and a leg share none."""

LIKENESS = 0.5
"""Of two models' figures that must agree. Chosen: a file with all limits wrong and ranges and masses right is above."""

_APART = 0.2
"""Of two limbs' figures below which they are of two machines. Chosen: of the Piper's and the X5's arms none agrees."""

_FEW = 5
"""Figures of two models below which nothing is told from them. Chosen: two kinds of two joints, and a third of one."""

BODY = frozenset(("range", "inertia"))
"""Kinds of figure that no training changes."""

_TURNS = (math.pi, math.tau)
"""Ends of ranges that limit nothing [rad]."""

Figures = Mapping[str, Mapping[str, tuple[float, ...]]]
"""Kind of figure to what each joint has."""


def are_alike(one: Figures, other: Figures, kinds: int) -> bool:
    """Whether the figures of two models may be of one robot: by joint names alone every pendulum is the same.

    Kinds of figure (ranges, limits, what the links weigh) speak each with the share of joints on which they agree.
    Less than half of what they say together is two robots; few kinds, or few figures, say nothing.

    Args:
        one: From `figures_of`.
        other: Likewise.
        kinds: Least kinds of figure that speak: less where the names differ, too.
    """
    shares, count = _shares(one, other)
    return len(shares) < kinds or count < _FEW or sum(shares) >= LIKENESS * len(shares)


def are_one_body(one: RobotView, other: RobotView, share: float = SHARE, *, mirrored: bool = False) -> bool:
    """Whether ranges and inertias of two models are those of one machine, or too few to tell.

    Versions of a machine have the same joints and other links; two files of one version have been seen to agree on
    every inertia, and on all but a few ranges.

    Args:
        one: The first.
        other: The second.
        share: Of the figures that must agree.
        mirrored: Whether they are its two sides, so that a range may be the other one's mirror image.
    """
    figures = figures_of(one), figures_of(other)
    shares, count = _shares_of(BODY, *(map(_of_either_side, figures) if mirrored else figures))
    return count < _FEW or sum(shares) >= share * len(shares)


def are_two_limbs(one: Figures, other: Figures, limb: Collection[str], *, mirrored: bool = False) -> bool:
    """Whether a limb of two models is of two machines, whatever the rest of the robot is: hardly one figure agrees, of
    ranges and inertias, and of limits beside these. Too few to tell are not.

    Args:
        one: From `figures_of`.
        other: Likewise.
        limb: The joints that both have in it.
        mirrored: As in `are_one_body`.
    """
    figures = [
        {kind: {joint: value for joint, value in own.items() if joint in limb} for kind, own in of.items()}
        for of in (one, other)
    ]
    sides = [*map(_of_either_side, figures)] if mirrored else figures

    def differ(kinds: Collection[str]) -> bool:
        shares, count = _shares_of(kinds, *sides)
        return count >= _FEW and sum(shares) < _APART * len(shares)

    return differ(BODY) and differ(one.keys() | other.keys())


def _of_either_side(figures: Figures) -> Figures:
    """Figures whose ranges are alike on both sides of a machine: each as it goes farther to the positive."""
    ranges = {
        joint: (low, high) if low + high >= 0.0 else (-high, -low)
        for joint, (low, high) in figures.get("range", {}).items()
    }
    return {**figures, "range": ranges}


def share_a_body(one: Figures, other: Figures, *, names: bool) -> bool:
    """Whether ranges and inertias of two models show one machine, be they few: nothing to tell by is no.

    Args:
        one: From `figures_of`.
        other: Likewise.
        names: Whether names speak for it; else the inertias must, for half of all arms turn from -pi to pi.
    """
    shares, _ = _shares_of(BODY, one, other)
    inertia, _ = _shares(*({"inertia": of.get("inertia", {})} for of in (one, other)))
    # The next machine of a family turns as far, and its links weigh more: HyQReal 1 and 2.
    if not names and (not inertia or inertia[0] < SHARE):
        return False
    return bool(shares) and sum(shares) >= SHARE * len(shares)


def _shares_of(kinds: Collection[str], one: Figures, other: Figures) -> tuple[list[float], int]:
    """`_shares` of some kinds of figure."""
    stated = [
        {
            # An unlimited joint is one whose range was left out as often as one that turns round and round.
            kind: {
                joint: values
                for joint, values in of[kind].items()
                if all(map(math.isfinite, values))
                and not _is_left_out(kind, values, its.get(kind, {}).get(joint))
            }
            for kind in of.keys() & set(kinds)
        }
        for of, its in ((one, other), (other, one))
    ]
    return _shares(*stated)


def _is_left_out(kind: str, one: Sequence[float], other: Sequence[float] | None) -> bool:
    """Whether one of two ranges is what an exporter writes for none, a turn each way, and the other is somebody's."""
    return kind == "range" and other is not None and _is_a_turn(one) is not _is_a_turn(other)


def _is_a_turn(values: Sequence[float]) -> bool:
    return any(all(math.isclose(abs(end), turn, abs_tol=0.01) for end in values) for turn in _TURNS)


def _shares(one: Figures, other: Figures) -> tuple[list[float], int]:
    """For each kind of figure that both have the share of joints on which they agree; how many figures that are."""
    shares, count = [], 0
    for kind in one.keys() & other.keys():
        same = [_is_same(kind, mine, other[kind][j]) for j, mine in one[kind].items() if j in other[kind]]
        if same:
            shares.append(sum(same) / len(same))
            count += len(same)
    return shares, count


def _is_same(kind: str, one: Sequence[float], other: Sequence[float]) -> bool:
    if kind == "inertia":
        return math.isclose(one[0], other[0], rel_tol=0.2, abs_tol=1e-9)
    # A range in degrees is of the robot that has it in radians.
    factors = (1.0, DEGREES, 1.0 / DEGREES) if kind == "range" else (1.0,)
    least = 0.02 if kind == "range" else 0.0
    return any(
        all(math.isclose(f * a, b, rel_tol=0.02, abs_tol=least) for a, b in zip(one, other, strict=True))
        for f in factors
    )


def figures_of(robot: RobotView | None) -> Figures:
    """What tells a model from another with the same joints: ranges, limits, and the links' inertia at each joint.

    Args:
        robot: The model; None: something else, which has none of its own.
    """
    if robot is None:
        return {}
    found: dict[str, dict[str, tuple[float, ...]]] = {}
    for name, reading in read_joints(robot).items():
        joint = reading.joint
        if "range" not in joint.unknown:
            found.setdefault("range", {})[name] = joint.range or (-math.inf, math.inf)
        for kind, limit in (("effort", reading.drive_limit.value), ("speed", joint.velocity_limit)):
            if limit is not None and 0.0 < limit < PLACEHOLDER:
                found.setdefault(kind, {})[name] = (limit,)
        at_zero = joint.zero_inertia[0] if joint.zero_inertia is not None else None
        if at_zero is None and reading.inertia is not None and not robot.keyframes:
            at_zero = reading.inertia.held.reference
        armature = reading.armature.value or 0.0
        if at_zero is not None:
            found.setdefault("inertia", {})[name] = (at_zero - armature,)
    return found
