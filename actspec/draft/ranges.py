"""The ranges of a joint out of what its files say: which of several counts, and which have nothing to draw."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from actspec.draft.rows import range_text
from actspec.draft.sources import places
from actspec.ir import JointActuator, Randomization
from actspec.sampling.ranges import without_effect

_MOMENTS = ("startup", "reset", "interval")
"""When a range is drawn, the earliest first."""


def with_ranges(joint: JointActuator, said: Sequence[JointActuator]) -> tuple[JointActuator, tuple[str, ...]]:
    """The joint with one range a field, and a remark on each range that is left out.

    Of a file the one that is drawn last counts, of those of one moment the last in the text: events of Isaac Lab and
    mjlab start from the configuration's figure, not from what was drawn before. Of files the first that has the field
    counts. A range that changes nothing in the joint is none.

    Args:
        joint: With all its figures.
        said: What the files say of it, the most believed first.
    """
    found: dict[str, Randomization] = {}
    remarks: list[str] = []
    for one in said:
        own: dict[str, Randomization] = {}
        for item in sorted(one.randomize, key=lambda item: _MOMENTS.index(item.when)):
            if (earlier := own.get(item.field)) is not None:
                remarks += _left_out(earlier, item, "drawn last", joint)
            own[item.field] = item
        # The author's order: fields of a spec are written as they come.
        for field in dict.fromkeys(item.field for item in one.randomize):
            if (first := found.setdefault(field, own[field])) is not own[field]:
                remarks += _left_out(own[field], first, "of the file that counts first", joint)
    kept = []
    for item in found.values():
        if (why := without_effect(joint, item)) is None:
            kept.append(item)
        else:
            remarks.append(f"{_stated(item, joint)} is left out: {why}")
    return replace(joint, randomize=tuple(kept)), tuple(remarks)


def _left_out(item: Randomization, taken: Randomization, why: str, joint: JointActuator) -> list[str]:
    """The remark on a range that another one takes the place of; none where both are the same."""
    if replace(item, span=None) == replace(taken, span=None):
        return []
    return [f"{_stated(item, joint)} is left out: {_at(taken)} is {why}, at {taken.when}"]


def _stated(item: Randomization, joint: JointActuator) -> str:
    return f"randomize.{item.field} {range_text(item, joint)} of {_at(item)}"


def _at(item: Randomization) -> str:
    return places([item.span] if item.span is not None else []) or "another file"
