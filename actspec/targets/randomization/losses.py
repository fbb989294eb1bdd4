"""What a stack of randomisation loses, with the reasons that several stacks share."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from actspec.ir import JointActuator, Randomization
from actspec.sampling import unit_of
from actspec.targets.base import Approximation
from actspec.targets.randomization.draws import Draw, stated_range
from actspec.targets.randomization.sizes import lost
from actspec.units import format_quantity


@dataclass(slots=True)
class Losses:
    """Collects the approximations of one stack.

    Attributes:
        target: Name of the target in the spec.
        stack: `isaaclab`, `mjlab` or `playground`; it is the first part of every field.
        items: What was lost so far.
    """

    target: str
    stack: str
    items: list[Approximation] = field(default_factory=list)

    def add(
        self, actuator: JointActuator, name: str, asked: str, emitted: str, why: str, error: float | None
    ) -> None:
        """Add one, unless the very same is there."""
        item = Approximation(
            self.target,
            actuator.joint,
            f"{self.stack}.{name}",
            asked,
            emitted,
            why,
            error,
            actuator.effort_limit.unit,
        )
        if item not in self.items:
            self.items.append(item)

    def entry(self, draw: Draw, entry: Randomization, emitted: str, why: str, error: float | None) -> None:
        """Add the loss of one of the spec's ranges."""
        unit = unit_of(draw.actuator, entry.field)
        self.add(draw.actuator, entry.field, stated_range(entry, unit), emitted, why, error)

    def dropped(self, draw: Draw, why: str) -> None:
        """A draw that the stack cannot hold: each of its ranges, once."""
        nominal = format_quantity(draw.nominal, draw.unit)
        for entry in draw.parts:
            if entry.field == draw.field:
                self.entry(draw, entry, f"none: stays {nominal}", why, lost(draw))

    def shared(self, draws: Sequence[Draw]) -> None:
        """Draws that joints should share, in a stack that draws joint by joint."""
        for draw in draws:
            for entry in draw.parts:
                if entry.per != "joint" and (entry.per == "env" or _members(draws, draw) > 1):
                    self.entry(
                        draw,
                        entry,
                        "each joint on its own",
                        f"the stack draws no number for a whole {_WHOLE[entry.per]}; each joint's range is kept",
                        None,
                    )

    def product(self, draw: Draw) -> None:
        """A draw of more than one range."""
        if len(draw.parts) > 1:
            names = " and ".join(part.field for part in draw.parts)
            self.add(
                draw.actuator,
                draw.field,
                f"the product of {names}",
                f"one {draw.distribution} draw from its least to its largest value",
                "a term draws from one range",
                None,
            )
        if len({part.when for part in draw.parts}) > 1:
            for part in draw.parts:
                if part.when != draw.when:
                    self.entry(draw, part, f"drawn at {draw.when}", "a number is drawn at one time", None)


_WHOLE = {"group": "group", "env": "robot"}


def _members(draws: Sequence[Draw], draw: Draw) -> int:
    return sum(other.actuator.group == draw.actuator.group and other.field == draw.field for other in draws)


def each(draws: dict[str, dict[str, Draw]], name: str) -> Iterator[Draw]:
    """The draws of one field, joint by joint."""
    for of_joint in draws.values():
        if name in of_joint:
            yield of_joint[name]
