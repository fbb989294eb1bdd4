"""What would tell a figure that the logs did not: another experiment, or a word beside the log."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from actspec.spec.results import JointResult

EXPERIMENTS: Mapping[str, tuple[str, str]] = {
    "kp": ("steps", "hold the joint at several places under load"),
    "kd": ("multisine", "move it fast in both directions"),
    "armature": ("chirp", "accelerate it more: to higher frequencies, or further"),
    "friction.coulomb": ("friction", "move it at constant speeds both ways"),
    "friction.viscous": ("friction", "move it at constant speeds both ways, to higher speeds"),
    "friction.static": ("friction", "move it at low speeds both ways"),
    "friction.stribeck_velocity": ("friction", "move it at low speeds both ways"),
    "delay": ("multisine", "command it faster, and log at a higher rate"),
    "bandwidth": ("multisine", "command it faster"),
}
"""Field to the experiment that tells it, and what that does."""

BARE = "log the torque, or state the gains that were sent in the sidecar"
"""Without either nothing says how large a torque is."""
APART = "; rows with the drive off (`enabled` 0) tell viscous friction from kd too"
GRAVITY = (
    "gravity has to pull at the joint: hold the base so that the joint's axis is not upright, and state "
    "`base: {orientation: [w, x, y, z]}` in the sidecar"
)


@dataclass(frozen=True, slots=True)
class Remedy:
    """What would tell a figure.

    Attributes:
        words: What to do.
        experiment: Of `design --experiment`; None: no other movement would.
    """

    words: str
    experiment: str | None = None


def remedy(field: str, result: JointResult) -> Remedy:
    """What would tell a field that a results file lists without a value.

    Args:
        field: As in `randomize`.
        result: Of the joint.
    """
    if field == "encoder_bias":
        return Remedy(GRAVITY)
    # Combinations stand where single figures do not show for want of a torque and of gains.
    if any(field in name.replace("(", "").replace(")", "") for name in result.combinations):
        return Remedy(BARE + APART * (field in ("kd", "friction.viscous")))
    if field == "armature" and result.combinations:
        return Remedy(BARE)
    experiment, words = EXPERIMENTS.get(field, ("multisine", "move it more"))
    if field in result.bounds_hit:
        return Remedy(f"it is smaller than this log can show: {words}, for longer", experiment)
    return Remedy(words, experiment)
