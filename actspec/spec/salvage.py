"""A faulty spec without its faulty sections, so that the others are checked in the same run."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from pydantic import ValidationError

from actspec.spec.models import SPEC_VERSION, SpecModel
from actspec.spec.paths import Path

_BY_NAME = ("actuators", "motors", "linkages", "sources", "targets", "accept")
"""Sections of named parts: a fault concerns its part."""
_ROBOT = {"name": "robot", "model": "robot"}
_GROUP = {"joints": ["joint"], "level": "ideal_pd"}


def salvaged(data: dict[str, Any], faults: Iterable[Path]) -> tuple[SpecModel, frozenset[Path]] | None:
    """The spec without the parts that have faults.

    Args:
        data: The document.
        faults: Place of every fault.

    Returns:
        The rest, and the places of which it tells nothing: what is left out, and what refers to it.
        None where nothing is left.
    """
    # A fault at () is a missing section.
    left_out = {path[: 2 if path[0] in _BY_NAME else 1] for path in faults if path}
    rest = {key: dict(value) if isinstance(value, dict) else value for key, value in data.items()}
    for path in left_out:
        if len(path) == 2 and isinstance(rest.get(str(path[0])), dict):
            rest[str(path[0])].pop(path[1], None)
        else:
            rest.pop(str(path[0]), None)
    rest["actspec"] = SPEC_VERSION
    rest.setdefault("robot", _ROBOT)
    if not rest.get("actuators"):
        rest["actuators"] = {"": _GROUP}
        left_out.add(("actuators", ""))
    try:
        model = SpecModel.model_validate(rest)
    except ValidationError:
        return None
    for name, linkage in model.linkages.items():
        if any(("motors", motor) in left_out for motor in linkage.motors) or ("motors",) in left_out:
            left_out.add(("linkages", name))
    unlinked = any(path[:1] == ("linkages",) for path in left_out)
    for name, group in model.actuators.items():
        motors = [group.motor, *(override.motor for override in group.overrides.values())]
        if group.motor is None and unlinked:
            # Its motors may be those of a linkage that is left out.
            left_out.add(("actuators", name))
        if any(("motors", motor) in left_out for motor in motors) or ("motors",) in left_out:
            left_out.add(("actuators", name))
    if any(path[:1] == ("targets",) for path in left_out):
        left_out.add(("accept",))
    return model, frozenset(left_out)
