"""Rules by family. Those that need an ActuatorSet alone run inside `compile`."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from actspec.audit.rules.damping import model_damping_beside_kd
from actspec.audit.rules.friction import implausible_friction
from actspec.audit.rules.stability import explicit_stability
from actspec.diagnostics import Diagnostic
from actspec.ir import ActuatorSet


def check_actuators(
    actuators: ActuatorSet, explicit: Mapping[str, Collection[str]]
) -> tuple[Diagnostic, ...]:
    """Run the rules that need no file.

    Args:
        actuators: What is to be compiled.
        explicit: What it is compiled to, in words, to the joints whose drive is integrated explicitly there.
    """
    return (
        *model_damping_beside_kd(actuators),
        *implausible_friction(actuators),
        *explicit_stability(actuators, explicit),
    )
