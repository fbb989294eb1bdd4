"""What a spec must fulfil beyond the type of each field: references, sides, levels, commands."""

from __future__ import annotations

from actspec.spec.document import Breaches, Document
from actspec.spec.models import SpecModel
from actspec.spec.rules.groups import check_group
from actspec.spec.rules.motors import check_linkages, check_motor
from actspec.spec.rules.robot import (
    check_accept,
    check_references,
    check_robot,
    check_targets,
    check_timing,
    check_variants,
)

__all__ = ["check_spec"]


def check_spec(model: SpecModel, document: Document, breaches: Breaches) -> None:
    """Report every breach.

    Args:
        model: What the spec says.
        document: Where it says it.
        breaches: Takes the breaches; `left_out` are sections (`("robot",)`) and named parts (`("motors", "m")`)
            that `model` lacks because of other faults.
    """
    check_robot(model.robot, breaches)
    check_timing(model.timing, breaches)
    check_references(document.data, model, breaches)
    for name, motor in model.motors.items():
        check_motor(name, motor, breaches)
    for name, group in model.actuators.items():
        check_group(name, group, model, breaches)
    check_linkages(model.linkages, breaches)
    check_targets(model.targets, breaches)
    check_variants(model.variants, model.variant if document.variant is None else None, breaches)
    check_accept(model.accept, model.targets, breaches)
