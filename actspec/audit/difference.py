"""What is different between two robots in effective dynamics: figures of each joint, and the robot's steps."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from actspec.audit.dynamics import SETTING_NOUNS, JointDynamics, RobotDynamics
from actspec.diagnostics import Span
from actspec.readings.artifact import FileKind
from actspec.readings.compare import Figure
from actspec.readings.fields import FIELDS

SAME = 1e-9
"""Largest relative difference of equal figures. Chosen: what is left of a float after units and sums."""

SAME_INERTIA = 1e-6
"""Likewise for inertia of the links. Chosen: engines of other versions compute it from the same file to 1e-7."""

EFFECTS = {"natural_frequency": "natural frequency", "damping_ratio": "damping ratio"}
"""What follows from the other figures and the links, and is told beside them."""

_GAINS = frozenset({"kp", "kd", "back_emf", "total_damping"})


@dataclass(frozen=True, slots=True)
class Change:
    """One figure that is another one.

    Attributes:
        joint: Whose; "" for the whole robot.
        field: Of `FIELDS`, `SETTING_NOUNS` or `EFFECTS`, or `control`, `network`, `inertia_min`, `inertia_max`.
        noun: The field in words.
        old: Before, in `unit`; None is unknown, or that there was none.
        new: After.
        unit: SI unit; "" where there is none.
        old_place: Where it was written; None when nowhere.
        new_place: Where it is.
    """

    joint: str
    field: str
    noun: str
    old: float | str | None
    new: float | str | None
    unit: str
    old_place: Span | None = None
    new_place: Span | None = None

    @property
    def ratio(self) -> float | None:
        """New over old; None where that says nothing."""
        old, new = self.old, self.new
        if isinstance(old, str) or isinstance(new, str) or not old or not new:
            return None
        return new / old if math.isfinite(old) and math.isfinite(new) else None


@dataclass(frozen=True, slots=True)
class Difference:
    """Two robots.

    Attributes:
        old: Before.
        new: After.
        added: Joints that only the new one has.
        removed: Joints that only the old one has.
        changes: Robot first, then by joint; without those of joints that were added or removed.
        effects: What follows for joints with changes.
    """

    old: RobotDynamics
    new: RobotDynamics
    added: tuple[str, ...]
    removed: tuple[str, ...]
    changes: tuple[Change, ...]
    effects: tuple[Change, ...]

    @property
    def same(self) -> bool:
        """Whether nothing changed."""
        return not (self.added or self.removed or self.changes)


def difference(old: RobotDynamics, new: RobotDynamics, tolerance: float = SAME) -> Difference:
    """Compare two robots.

    Between files of one kind, a figure that one of them lacks has changed. Between kinds it says nothing: a URDF has
    no gains, and what drives a motor's or a bare joint's position is in another file.

    Args:
        old: Before.
        new: After.
        tolerance: Largest relative difference of equal figures.
    """
    changes = list(_settings(old, new, tolerance))
    effects: list[Change] = []
    for name, after in new.joints.items():
        before = old.joints.get(name)
        if before is None:
            continue
        found = list(_joint(before, after, old.kind, new.kind, tolerance))
        changes += found
        if found:
            effects += _effects(before, after)
    return Difference(
        old,
        new,
        tuple(name for name in new.joints if name not in old.joints),
        tuple(name for name in old.joints if name not in new.joints),
        tuple(changes),
        tuple(effects),
    )


def _settings(old: RobotDynamics, new: RobotDynamics, tolerance: float) -> Iterator[Change]:
    for name, noun in SETTING_NOUNS.items():
        before, after = old.settings.get(name), new.settings.get(name)
        if (before is None or after is None) and old.kind is not new.kind:
            continue
        if not _equal(before, after, tolerance):
            unit = "s" if name in ("physics_dt", "control_dt") else ""
            yield Change("", name, noun, before, after, unit)


def _joint(
    old: JointDynamics, new: JointDynamics, old_kind: FileKind, new_kind: FileKind, tolerance: float
) -> Iterator[Change]:
    alike = old_kind is new_kind
    if alike and old.control != new.control:
        yield Change(new.joint, "control", "drive", old.control, new.control, "", old.place, new.place)
    found = []
    for name, field in FIELDS.items():
        before, after = old.figures.get(name), new.figures.get(name)
        if not alike and not (_tells(old, before, name, old_kind) and _tells(new, after, name, new_kind)):
            continue
        change = _figure(new.joint, name, field.noun, before, after, tolerance)
        if change is not None:
            found.append(change)
    parts = [change for change in found if change.field in ("kd", "joint_damping", "actuator_damping")]
    for change in found:
        # A total that is its only part says nothing new.
        total = change.field == "total_damping"
        if not (total and any((part.old, part.new) == (change.old, change.new) for part in parts)):
            yield change
    if alike and old.network != new.network:
        yield Change(new.joint, "network", "network", old.network, new.network, "", old.place, new.place)
    # Over the poses, of which a spec takes more than a model.
    if alike and old.inertia is not None and new.inertia is not None:
        ends = zip(
            ("inertia_min", "inertia_max"), ("least", "largest"), old.inertia, new.inertia, strict=True
        )
        unit = new.figures["armature"].unit
        largest = max(abs(end) for end in (*old.inertia, *new.inertia))
        for name, word, low, high in ends:
            if abs(high - low) > SAME_INERTIA * largest:
                yield Change(new.joint, name, f"{word} inertia of the links", low, high, unit)


def _figure(
    joint: str, name: str, noun: str, before: Figure | None, after: Figure | None, tolerance: float
) -> Change | None:
    old, new = (None if figure is None else figure.value for figure in (before, after))
    if _equal(old, new, tolerance):
        return None
    unit = next((figure.unit for figure in (after, before) if figure is not None), "")
    places = (None if figure is None else figure.place for figure in (before, after))
    return Change(joint, name, noun, old, new, unit, *places)


def _tells(joint: JointDynamics, figure: Figure | None, name: str, kind: FileKind) -> bool:
    """Whether a file says what a figure of another kind of file can be compared with."""
    if figure is None or figure.value is None:
        return False
    if joint.control in ("none", "motor") and name in _GAINS:
        return False
    return figure.stated or not (joint.control == "none" or kind is FileKind.URDF)


def _effects(old: JointDynamics, new: JointDynamics) -> Iterator[Change]:
    for name, noun in EFFECTS.items():
        before: float | None = getattr(old, name)
        after: float | None = getattr(new, name)
        if before is not None and after is not None and not _equal(before, after, SAME_INERTIA):
            yield Change(new.joint, name, noun, before, after, "rad/s" if name == "natural_frequency" else "")


def _equal(old: float | str | None, new: float | str | None, tolerance: float) -> bool:
    if old is None or new is None or isinstance(old, str) or isinstance(new, str):
        return old == new
    return math.isclose(old, new, rel_tol=tolerance, abs_tol=1e-12)
