"""What a spec must fulfil beyond the type of each field: references, sides, levels, commands."""

from __future__ import annotations

from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Path
from actspec.spec.models import SpecModel
from actspec.spec.rules.groups import check_group
from actspec.spec.rules.motors import check_linkages, check_motor
from actspec.spec.rules.robot import (
    Breaches,
    check_accept,
    check_robot,
    check_sources,
    check_targets,
)

if TYPE_CHECKING:
    from actspec.spec.document import Document

__all__ = ["check_spec"]


def check_spec(
    model: SpecModel, document: Document, collector: Collector, left_out: frozenset[Path] = frozenset()
) -> None:
    """Add every breach to the collector.

    Args:
        model: What the spec says.
        document: Where it says it.
        collector: Takes the breaches.
        left_out: Sections (`("robot",)`) and named parts (`("motors", "m")`) that `model` lacks because of
            other faults; nothing is said about them.
    """
    breaches = Breaches(document.spans, collector, left_out)
    check_robot(model.robot, breaches)
    if not any(path[0] == "sources" for path in left_out):
        check_sources(document.data, model.sources, breaches)
    for name, motor in model.motors.items():
        check_motor(name, motor, breaches)
    for name, group in model.actuators.items():
        check_group(name, group, model, breaches)
    check_linkages(model.linkages, model.motors, model.sources, breaches)
    check_targets(model.targets, breaches)
    check_accept(model.accept, model.targets, breaches)
