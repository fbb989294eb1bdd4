"""Ranges as JSON, exactly as the spec states them: format `actspec-randomization/1`, schema in schemas/."""

from __future__ import annotations

import json
from typing import Any

import actspec
from actspec.ir import ActuatorSet, JointActuator
from actspec.sampling import FACTORS, FIELDS, nominal_of, own_ranges, unit_of

FORMAT = "actspec-randomization/1"


def record(actuators: ActuatorSet) -> str:
    """The JSON text: SI units, joint side, joints in the robot's order; null is unknown or not there."""
    found = {
        "format": FORMAT,
        "tool": f"actspec {actspec.__version__}",
        "spec_sha256": actuators.spec_sha256,
        "robot": actuators.robot,
        "order": ["field", *FACTORS],
        "joints": [_joint(actuator) for actuator in actuators.joints],
    }
    return json.dumps(found, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


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
