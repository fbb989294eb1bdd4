"""Ranges as JSON, exactly as the spec states them: format `actspec-randomization/1`, schema in schemas/."""

from __future__ import annotations

from typing import Any

import actspec
from actspec.files import json_of
from actspec.ir import ActuatorSet, JointActuator
from actspec.sampling import FACTORS, FIELDS, nominal_of, own_ranges, unit_of
from actspec.targets.base import EmittedFile
from actspec.targets.kit.events import StackWriter

FORMAT = "actspec-randomization/1"

SHORT = 60
"""Characters of a part that stands on one line. Chosen: a number with its unit does, a range does not."""


def write(stack: StackWriter) -> EmittedFile:
    """The file of all joints, whether a range is stated or not."""
    return EmittedFile(f"{stack.stem}_randomization.json", record(stack.actuators).encode("utf-8"))


def record(actuators: ActuatorSet) -> str:
    """The JSON text: SI units, joint side, joints in the robot's order; null is unknown or not there."""
    found = {
        "format": FORMAT,
        "tool": f"actspec {actspec.__version__}",
        "spec_sha256": actuators.spec_sha256,
        **({"variant": actuators.variant} if actuators.variant else {}),
        "robot": actuators.robot,
        "order": ["field", *FACTORS],
        "joints": [_joint(actuator) for actuator in actuators.joints],
    }
    return _text(found, "") + "\n"


def _text(value: Any, indent: str) -> str:
    """JSON, a part without parts of its own on one line where it is short."""
    one = json_of(value, indent=None)
    if not isinstance(value, (dict, list)) or not value:
        return one
    parts = list(value.values()) if isinstance(value, dict) else value
    if len(one) <= SHORT and not any(isinstance(part, (dict, list)) for part in parts):
        return one
    inner = f"{indent}  "
    begin, end = "{}" if isinstance(value, dict) else "[]"
    keys = (
        [f"{json_of(key, indent=None)}: " for key in value] if isinstance(value, dict) else [""] * len(parts)
    )
    rows = [f"{inner}{key}{_text(part, inner)}" for key, part in zip(keys, parts, strict=True)]
    return f"{begin}\n" + ",\n".join(rows) + f"\n{indent}{end}"


def _joint(actuator: JointActuator) -> dict[str, Any]:
    return {
        "joint": actuator.joint,
        "group": actuator.group,
        "level": actuator.level.value,
        "command": actuator.command.value,
        "nominal": {
            field: {"value": nominal_of(actuator, field), "unit": unit_of(actuator, field)}
            for field in FIELDS
        },
        "ranges": [
            {
                "field": field,
                "operation": entry.operation,
                "unit": "1" if entry.operation == "scale" else unit_of(actuator, field),
                "distribution": entry.distribution,
                "low": entry.low,
                "high": entry.high,
                "when": entry.when,
                "every": None if entry.every is None else list(entry.every),
                "per": entry.per,
            }
            for field, entry in own_ranges(actuator).items()
        ],
    }
