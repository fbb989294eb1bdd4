"""Rules by family. Those that need an ActuatorSet alone run inside `compile`."""

from __future__ import annotations

from actspec.audit.rules.damping import model_damping_beside_kd
from actspec.audit.rules.friction import implausible_friction
from actspec.audit.rules.stability import explicit_stability
from actspec.diagnostics import Diagnostic
from actspec.ir import ActuatorSet


def check_actuators(
    actuators: ActuatorSet, integrator: str, explicit_targets: tuple[str, ...]
) -> tuple[Diagnostic, ...]:
    """Run the rules that need no file.

    Args:
        actuators: What is to be compiled.
        integrator: The model's integrator, MuJoCo's name; "" when there is none.
        explicit_targets: Names of targets that apply the drive's torque explicitly.
    """
    return (
        *model_damping_beside_kd(actuators),
        *implausible_friction(actuators),
        *explicit_stability(actuators, integrator, explicit_targets),
    )
